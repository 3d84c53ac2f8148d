#pragma once
// Reads a recording (recording/format.hpp).

#include <fstream>
#include <optional>

#include "client/cpp/client.hpp"

namespace collided::cli {

/// Everything in a recording can be wrong: errors are std::runtime_errors that name the file, the message, its offset,
/// the value and the limit. No memory is taken for bytes that the file does not have.
class RecordingReader {
 public:
  /// Reads the scene.
  explicit RecordingReader(const std::string& file);
  /// With the meshes' elements.
  const v1::SceneSpec& spec() const { return spec_; }
  /// Frames that the file has whole. Errors beyond them are left to next_frame().
  int count_frames();
  /// Nothing after the last one.
  std::optional<v1::Frame> next_frame();

 private:
  [[noreturn]] void fail(const std::string& what) const;
  void read_header();
  uint64_t read_length();
  void read(google::protobuf::MessageLite& message, uint64_t bytes);
  uint64_t left() const { return file_bytes_ - at_; }

  std::string file_;
  std::ifstream in_;
  uint64_t file_bytes_ = 0, at_ = 0;
  std::string message_;  ///< what is being read, for errors
  int frames_ = 0;
  v1::SceneSpec spec_;
};

}  // namespace collided::cli
