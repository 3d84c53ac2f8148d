// Where results go: files, or standard output.

#include "client/app/output/output.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

#include "client/app/options/usage_error.hpp"
#include "client/app/output/numbered.hpp"

namespace collided::cli {

namespace fs = std::filesystem;

namespace {

std::string cannot_be_written(const std::string& file, int error) {
  return file + ": cannot be written: " + std::strerror(error);
}

/// Whether writing to one name changes what the other one holds.
bool is_same_file(const std::string& a, const std::string& b) {
  if (is_standard_output(a) || is_standard_output(b)) return a == b;
  std::error_code error;
  if (fs::is_character_file(a, error)) return false;
  if (fs::equivalent(a, b, error)) return true;
  const fs::path whole_a = fs::weakly_canonical(fs::absolute(a), error);
  if (error) return a == b;
  const fs::path whole_b = fs::weakly_canonical(fs::absolute(b), error);
  return error ? a == b : whole_a == whole_b;
}

/// Whether `pattern` gives the file of a frame this name.
bool is_of_pattern(const std::string& pattern, const std::string& name) {
  if (!is_numbered(pattern) || is_standard_output(name)) return false;
  std::error_code error;
  const fs::path whole_pattern = fs::weakly_canonical(fs::absolute(pattern), error);
  const fs::path whole_name = fs::weakly_canonical(fs::absolute(name), error);
  return !error && gives(whole_pattern.string(), whole_name.string());
}

using FileId = std::pair<dev_t, ino_t>;

/// None if there is no regular file of that name.
std::optional<FileId> id_of(const std::string& file) {
  struct stat about {};
  if (stat(file.c_str(), &about) != 0 || !S_ISREG(about.st_mode)) return std::nullopt;
  return FileId(about.st_dev, about.st_ino);
}

/// Removes a file that was created by that name: of a link its target.
void remove_created(const std::string& file) {
  std::error_code error;
  const fs::path created = fs::canonical(file, error);
  if (!error) fs::remove(created, error);
}

/// 0, or errno from opening it for writing.
int try_to_open(const std::string& file) {
  struct stat about {};
  const bool is_there = stat(file.c_str(), &about) == 0;
  if (is_there && !S_ISREG(about.st_mode) &&
      !S_ISDIR(about.st_mode))  // opening a pipe could block until it has a reader
    return access(file.c_str(), W_OK) == 0 ? 0 : errno;
  const int opened = open(file.c_str(), O_WRONLY | O_CLOEXEC | (is_there ? 0 : O_CREAT), 0666);
  if (opened < 0) return errno;
  close(opened);
  if (!is_there) remove_created(file);
  return 0;
}

}  // namespace

void check_writable(const std::string& option, const std::string& file) {
  if (file.empty() || is_standard_output(file)) return;
  if (const int error = try_to_open(file)) throw std::runtime_error(option + " " + cannot_be_written(file, error));
}

void make_folder(const std::string& option, const std::string& folder) {
  if (is_standard_output(folder)) throw UsageError(option + " is a folder here; standard output (-) is none");
  std::error_code error;
  fs::create_directories(folder, error);
  if (!fs::is_directory(folder) || access(folder.c_str(), W_OK) != 0)
    throw std::runtime_error(option + " " + folder + ": is no folder that can be written to");
}

void check_one_output(const std::string& out, bool json) {
  if (json && is_standard_output(out)) throw UsageError("--json and --out - both want standard output");
}

void check_distinct(std::initializer_list<NamedOutput> outputs) {
  const auto check = [](const NamedOutput& a, const NamedOutput& b) {
    if (a.file.empty() || b.file.empty()) return;
    const bool is_of_a = is_of_pattern(a.file, b.file);
    if (is_of_a || is_of_pattern(b.file, a.file) || is_same_file(a.file, b.file))
      throw UsageError(std::string(a.option) + " and " + b.option + " are two files; both are " +
                       (is_of_a || !is_numbered(b.file) ? b.file : a.file));
  };
  for (const NamedOutput* b = outputs.begin(); b != outputs.end(); ++b)
    for (const NamedOutput* a = outputs.begin(); a != b; ++a) check(*a, *b);
}

void check_kept(const std::vector<std::string>& inputs, const std::vector<NamedOutput>& outputs) {
  std::map<FileId, const std::string*> read;
  for (const std::string& input : inputs)
    if (const auto id = id_of(input)) read.emplace(*id, &input);
  for (const NamedOutput& output : outputs) {
    if (is_standard_output(output.file)) continue;
    if (const auto id = id_of(output.file); id && read.contains(*id))
      throw UsageError(std::string(output.option) + " " + output.file + " would overwrite " + *read[*id] +
                       ", which is read");
  }
}

void print_summary(const std::string& out, const std::string& text) {
  if (is_standard_output(out)) return (void)std::fputs(text.c_str(), stderr);
  if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0) throw OutputClosed(errno);
}

void print_line(const std::string& line) {
  if (std::printf("%s\n", line.c_str()) < 0 || std::fflush(stdout) != 0) throw OutputClosed(errno);
}

std::exception_ptr failure_in(const std::function<void()>& write) try {
  write();
  return nullptr;
} catch (const std::runtime_error&) {
  return std::current_exception();
}

OutputFile::OutputFile(const std::string& name)
    : name_(name), file_(is_standard_output(name) ? stdout : std::fopen(name.c_str(), "wb")) {
  if (file_ == nullptr) fail();
}

OutputFile::~OutputFile() {
  if (file_ != nullptr && file_ != stdout) std::fclose(file_);
}

void OutputFile::write(const char* data, size_t bytes) {
  if (std::fwrite(data, 1, bytes, file_) != bytes) fail();
}

void OutputFile::finish() {
  if (std::fflush(file_) != 0) fail();
  if (file_ == stdout) return;
  if (std::fclose(std::exchange(file_, nullptr)) != 0) fail();
}

void OutputFile::fail() const {
  const int error = errno;
  if (file_ == stdout) throw OutputClosed(error);
  throw std::runtime_error(cannot_be_written(name_, error));
}

void write_text(const std::string& file, const std::string& text) {
  OutputFile out(file);
  out.write(text.data(), text.size());
  out.finish();
}

}  // namespace collided::cli
