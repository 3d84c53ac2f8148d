// Records of results.

#include "client/cli/batch/record.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <boost/crc.hpp>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <stdexcept>

namespace collided::cli {

namespace {

constexpr size_t kCrcDigits = 8;

std::string crc_of(std::string_view line, std::string_view text) {
  boost::crc_32_type crc;
  crc.process_bytes(line.data(), line.size());
  crc.process_bytes(text.data(), text.size());
  char digits[kCrcDigits + 1];
  std::snprintf(digits, sizeof digits, "%08x", crc.checksum());
  return digits;
}

/// Opens a file for reading. A pipe, whose opening would wait for a writer, and a device are refused.
std::FILE* open_regular(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) throw std::runtime_error(path.string() + ": cannot be read: " + std::strerror(errno));
  if (!is_regular(file)) {
    ::close(file);
    throw std::runtime_error(path.string() + ": is no file");
  }
  return ::fdopen(file, "rb");
}

/// The line with its line break; none if it is cut off, or longer than any head.
std::optional<std::string> read_line(std::FILE* file) {
  std::string line(1 << 16, '\0');
  if (std::fgets(line.data(), static_cast<int>(line.size()), file) == nullptr) return {};
  const size_t end = line.find('\n');
  if (end == std::string::npos) return {};
  line.resize(end + 1);
  return line;
}

}  // namespace

bool is_regular(int file) {
  struct stat about {};
  return fstat(file, &about) == 0 && S_ISREG(about.st_mode);
}

std::string record_bytes(const Record& record) {
  const std::string line = " " + std::to_string(record.text.size()) + " " + json_text(record.head) + "\n";
  return crc_of(line, record.text) + line + record.text;
}

uint64_t number_of(const Json& head, const char* name) {
  const auto at = head.find(name);
  return at != head.end() && at->is_number_unsigned() ? at->get<uint64_t>() : 0;
}

RecordReader::RecordReader(const std::filesystem::path& file) : file_(open_regular(file)) {
  std::error_code error;
  bytes_ = std::filesystem::file_size(file, error);
}

RecordReader::~RecordReader() { std::fclose(file_); }

std::optional<Record> RecordReader::next() {
  const std::optional<std::string> line = read_line(file_);
  if (!line || line->size() < kCrcDigits + 2) return {};
  const char* const end = line->data() + line->size();
  uint64_t bytes = 0;
  const auto [after, error] = std::from_chars(line->data() + kCrcDigits + 1, end, bytes);
  if (error != std::errc() || offset_ + line->size() > bytes_ || bytes > bytes_ - offset_ - line->size()) return {};
  Record record{Json::parse(after, end, nullptr, false), std::string(bytes, '\0')};
  if (!record.head.is_object() || std::fread(record.text.data(), 1, bytes, file_) != bytes) return {};
  if (line->compare(0, kCrcDigits, crc_of(std::string_view(*line).substr(kCrcDigits), record.text)) != 0) return {};
  offset_ += line->size() + bytes;
  return record;
}

void RecordReader::seek(uint64_t offset) {
  std::fseek(file_, static_cast<long>(offset), SEEK_SET);
  offset_ = offset;
}

}  // namespace collided::cli
