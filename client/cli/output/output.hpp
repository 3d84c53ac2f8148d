#pragma once
// Where results go: files, or standard output under the name "-". What is for people to read then goes to standard
// error.

#include <cstdio>
#include <stdexcept>
#include <string>

namespace collided::cli {

/// Standard output cannot be written; `error_number` is EPIPE if its reader has gone.
struct OutputClosed : std::runtime_error {
  explicit OutputClosed(int error) : std::runtime_error("standard output cannot be written"), error_number(error) {}
  int error_number;
};

/// Whether `out` names standard output.
inline bool is_standard_output(const std::string& out) { return out == "-"; }

/// Before any work, so that none is lost: throws std::runtime_error naming `option`, the file and the reason if it
/// cannot be written. Leaves an old file as it is, and makes no new one.
void check_writable(const std::string& option, const std::string& file);

/// The same for a folder, which is made if it is not there. Throws UsageError for "-", which is none.
void make_folder(const std::string& option, const std::string& folder);

/// Throws UsageError if --json and --out both ask for standard output.
void check_one_output(const std::string& out, bool json);

/// A summary for people: to standard output, or to standard error while results go there.
void print_summary(const std::string& out, const std::string& text);

/// A file or standard output, in large pieces. Throws std::runtime_error naming the file and the reason.
class OutputFile {
 public:
  explicit OutputFile(const std::string& name);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();
  void write(const char* data, size_t bytes);
  /// Has everything written; nothing can be written after it.
  void finish();

 private:
  [[noreturn]] void fail() const;

  std::string name_;
  std::FILE* file_;
};

/// All of it at once. Throws as OutputFile does.
void write_text(const std::string& file, const std::string& text);

}  // namespace collided::cli
