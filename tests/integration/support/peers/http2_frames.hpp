#pragma once
// The HTTP/2 frames in what clients send through a proxy.

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace collided::test {

class Http2Frames {
 public:
  static constexpr uint8_t kData = 0, kPing = 6;  ///< Types (RFC 9113, section 6).
  static constexpr uint8_t kIsAnswer = 1;         ///< A flag of pings.

  struct Frame {
    uint8_t type = 0, flags = 0;
    std::string_view payload;
  };

  /// Adds what a connection sends, from its preface on; `see` gets each frame, once, when it is whole.
  template <class See>
  void take(size_t connection, std::string_view bytes, const See& see) {
    constexpr size_t kHead = 9;
    auto& [text, at] = sent_[connection];
    text += bytes;
    while (at + kHead <= text.size()) {
      const auto byte = [&](size_t i) { return static_cast<uint8_t>(text[at + i]); };
      const size_t size = size_t{byte(0)} << 16 | size_t{byte(1)} << 8 | byte(2);
      if (at + kHead + size > text.size()) return;
      see(Frame{byte(3), byte(4), std::string_view(text).substr(at + kHead, size)});
      at += kHead + size;
    }
  }

 private:
  struct Sent {
    std::string text;
    size_t at = 24;  ///< Of the next frame; first, after the preface.
  };
  std::map<size_t, Sent> sent_;
};

}  // namespace collided::test
