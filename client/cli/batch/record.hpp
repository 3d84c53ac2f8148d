#pragma once
// Results are a file of records: a line "CRC BYTES HEAD", where HEAD is a JSON object, and BYTES bytes of text. The
// CRC-32 (hexadecimal) is that of all after it, so that a record that was cut off, or changed, is no record.

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>

#include "client/app/report/json.hpp"

namespace collided::cli {

struct Record {
  Json head;
  std::string text;
};

/// Returns true if an open file is no pipe or device, neither of which can be read back.
bool is_regular(int file);

std::string record_bytes(const Record& record);

/// A number of a head, 0 if it has none of that name.
uint64_t number_of(const Json& head, const char* name);

class RecordReader {
 public:
  /// Throws std::runtime_error naming the file if it cannot be read, or is no regular file.
  explicit RecordReader(const std::filesystem::path& file);
  RecordReader(const RecordReader&) = delete;
  RecordReader& operator=(const RecordReader&) = delete;
  ~RecordReader();
  /// The next record; none at the end of the file, and where the next one is not whole.
  std::optional<Record> next();
  /// Goes to where a record begins.
  void seek(uint64_t offset);
  /// Where the next record begins: what is before is whole.
  uint64_t offset() const { return offset_; }
  uint64_t bytes() const { return bytes_; }

 private:
  std::FILE* file_;
  uint64_t bytes_ = 0, offset_ = 0;
};

}  // namespace collided::cli
