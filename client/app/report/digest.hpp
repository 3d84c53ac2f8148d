#pragma once
// Whether contacts are the same, in sixteen digits.

#include <cstdint>
#include <string>

#include "client/cpp/frame_stream.hpp"

namespace collided::cli {

/// Depends on every bit of all fields of all contacts that were added, and on their order. It finds differences, not
/// forgeries.
class ContactsDigest {
 public:
  void add(const client::FrameOutput& output);
  /// Sixteen hexadecimal digits.
  std::string text() const;

 private:
  template <class T>
  void add(const std::vector<T>& values);

  uint64_t digest_ = 0;
};

/// Of one frame.
inline std::string digest_of(const client::FrameOutput& output) {
  ContactsDigest digest;
  digest.add(output);
  return digest.text();
}

}  // namespace collided::cli
