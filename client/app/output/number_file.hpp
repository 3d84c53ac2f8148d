#pragma once
// A text file of many numbers, formatted in a buffer and written in large pieces.

#include <charconv>
#include <string>
#include <string_view>
#include <utility>

#include "client/app/output/output.hpp"

namespace collided::cli {

/// Doubles are written in the fewest digits that read back the same. Throws what OutputFile throws.
class NumberFile {
 public:
  explicit NumberFile(const std::string& file) : out_(file), buffer_(kBufferBytes, '\0') {}
  /// An open file, which it closes.
  explicit NumberFile(std::FILE* file) : out_(file), buffer_(kBufferBytes, '\0') {}

  NumberFile& text(std::string_view s) {
    if (at_ + s.size() > kBufferBytes) write();
    if (s.size() > kBufferBytes)
      out_.write(s.data(), s.size());
    else
      at_ += s.copy(buffer_.data() + at_, s.size());
    return *this;
  }
  template <class T>
  NumberFile& number(T x) {
    if (at_ + kMaxDigits > kBufferBytes) write();
    at_ = static_cast<size_t>(std::to_chars(buffer_.data() + at_, buffer_.data() + buffer_.size(), x).ptr -
                              buffer_.data());
    return *this;
  }
  void finish() {
    write();
    out_.finish();
  }

 private:
  static constexpr size_t kBufferBytes = 1 << 20, kMaxDigits = 40;

  void write() { out_.write(buffer_.data(), std::exchange(at_, 0)); }

  OutputFile out_;
  std::string buffer_;
  size_t at_ = 0;
};

}  // namespace collided::cli
