// Reads a recording.

#include "client/cli/recording/reader.hpp"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "client/cli/recording/format.hpp"

namespace collided::cli {

RecordingReader::RecordingReader(const std::string& file) : file_(file), in_(file, std::ios::binary) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw std::runtime_error(file + ": does not exist");
  if (!std::filesystem::is_regular_file(file, error)) throw std::runtime_error(file + ": is not a file");
  file_bytes_ = std::filesystem::file_size(file, error);
  if (error || !in_) throw std::runtime_error(file + ": cannot be read");
  read_header();
  message_ = "the scene";
  read(spec_, read_length());
}

void RecordingReader::fail(const std::string& what) const {
  throw std::runtime_error(file_ + ": " + message_ + " at offset " + std::to_string(at_) + " " + what);
}

void RecordingReader::read_header() {
  std::string header(std::min<uint64_t>(kRecordingHeader.size(), file_bytes_), '\0');
  in_.read(header.data(), static_cast<std::streamsize>(header.size()));
  if (!header.starts_with(kRecordingTitle))
    throw std::runtime_error(file_ + ": is no recording; one begins with '" + std::string(kRecordingTitle) + "'");
  if (header != kRecordingHeader)
    throw std::runtime_error(file_ + ": is a recording of another version; this collidectl reads version 1");
  at_ = header.size();
}

/// Errors name the offset of the length.
uint64_t RecordingReader::read_length() {
  constexpr int kMaxBytes = 5;  // 2^31 - 1 takes no more
  uint64_t length = 0;
  for (int i = 0; i < kMaxBytes; ++i) {
    const int byte = in_.get();
    if (byte < 0) fail("is cut off: the file ends there without the length 0 that ends a recording");
    length |= static_cast<uint64_t>(byte & 0x7f) << (7 * i);
    if (byte >= 0x80) continue;
    if (length > kMaxRecordedBytes) break;
    if (const uint64_t rest = left() - static_cast<uint64_t>(i) - 1; length > rest)
      fail("is cut off: it has " + std::to_string(length) + " bytes; the file has " + std::to_string(rest) + " more");
    at_ += static_cast<uint64_t>(i) + 1;
    return length;
  }
  fail("has a length above the limit of " + std::to_string(kMaxRecordedBytes) + " bytes");
}

void RecordingReader::read(google::protobuf::MessageLite& message, uint64_t bytes) {
  std::string text(bytes, '\0');
  if (!in_.read(text.data(), static_cast<std::streamsize>(bytes))) fail("cannot be read");
  if (!message.ParseFromString(text)) fail("is no message of the protocol");
  at_ += bytes;
}

int RecordingReader::count_frames() {
  const uint64_t at = at_;
  int count = 0;
  try {
    for (message_ = "a frame";; ++count) {
      const uint64_t bytes = read_length();
      if (bytes == 0) break;
      in_.seekg(static_cast<std::streamoff>(at_ += bytes));
    }
  } catch (const std::runtime_error&) {  // next_frame() will tell
  }
  in_.clear();
  in_.seekg(static_cast<std::streamoff>(at_ = at));
  return count;
}

std::optional<v1::Frame> RecordingReader::next_frame() {
  message_ = "frame number " + std::to_string(++frames_);
  const uint64_t bytes = read_length();
  if (bytes == 0) {
    if (left() > 0) fail("is not there, but " + std::to_string(left()) + " bytes that follow the end of the recording");
    return {};
  }
  v1::Frame frame;
  read(frame, bytes);
  return frame;
}

}  // namespace collided::cli
