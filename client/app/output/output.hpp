#pragma once
// Where results go: to a file, or to standard output, named "-"; messages for people then go to standard error.

#include <cstdio>
#include <exception>
#include <functional>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <vector>

namespace collided::cli {

/// Standard output cannot be written; `error_number` is EPIPE if its reader has gone.
struct OutputClosed : std::runtime_error {
  explicit OutputClosed(int error) : std::runtime_error("standard output cannot be written"), error_number(error) {}
  int error_number;
};

/// Whether `out` names standard output.
inline bool is_standard_output(const std::string& out) { return out == "-"; }

/// Called before the work, so that none is lost. Throws std::runtime_error naming `option`, the file and the reason if
/// the file cannot be written. Neither changes nor creates it.
void check_writable(const std::string& option, const std::string& file);

/// The same for a folder, which is created if necessary. Throws UsageError for "-".
void make_folder(const std::string& option, const std::string& folder);

/// Throws UsageError if --json and --out both ask for standard output.
void check_one_output(const std::string& out, bool json);

/// A file that an option names; an empty name is none.
struct NamedOutput {
  const char* option;
  std::string file;
};

/// Throws UsageError naming two options whose files are one, which would be overwritten. Links to a file are that file;
/// a name with {frame} stands for those of all frames. Whatever takes output and keeps none, such as /dev/null, may
/// have several.
void check_distinct(std::initializer_list<NamedOutput> outputs);

/// Throws UsageError naming an option whose file is one that is read, also by another name.
void check_kept(const std::vector<std::string>& inputs, const std::vector<NamedOutput>& outputs);

/// Prints a summary for people: to standard output, or to standard error if `out` is standard output. Throws
/// OutputClosed.
void print_summary(const std::string& out, const std::string& text);

/// Prints a line to standard output and flushes it: whoever reads it watches. Throws OutputClosed.
void print_line(const std::string& line);

/// What keeps `write` from writing, to be thrown once the result that was to be written is shown; null if nothing does.
std::exception_ptr failure_in(const std::function<void()>& write);

/// A file or standard output. Throws std::runtime_error naming the file and the reason.
class OutputFile {
 public:
  explicit OutputFile(const std::string& name);
  /// An open file, which it closes.
  explicit OutputFile(std::FILE* file) : file_(file) {}
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();
  void write(const char* data, size_t bytes);
  /// Flushes; nothing can be written afterwards.
  void finish();

 private:
  [[noreturn]] void fail() const;

  std::string name_;
  std::FILE* file_;
};

/// Writes a whole file. Throws as OutputFile does.
void write_text(const std::string& file, const std::string& text);

}  // namespace collided::cli
