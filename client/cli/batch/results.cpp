// Writes the results of one shard.

#include "client/cli/batch/results.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "client/app/output/durable.hpp"

namespace collided::cli {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  throw std::runtime_error(file.string() + ": " + what);
}

/// Whether the open file is still the one of that name: another process may have finished it meanwhile.
bool is_file(int file, const fs::path& path) {
  struct stat opened {
  }, named{};
  return fstat(file, &opened) == 0 && stat(path.c_str(), &named) == 0 && opened.st_ino == named.st_ino;
}

}  // namespace

Results::Results(const fs::path& folder, const Shard& shard, const Json& identity) : base_(folder / shard.name()) {
  open();
  try {
    lock();
    resume(identity);
  } catch (...) {
    close(file_);
    throw;
  }
}

Results::~Results() { close(file_); }

void Results::open() {
  path_ = base_.string() + kResultsEnding;
  file_ = ::open(path_.c_str(), O_RDWR | O_APPEND | O_CLOEXEC);
  if (file_ >= 0) return;
  path_ = base_.string() + kPartEnding;
  file_ = ::open(path_.c_str(), O_RDWR | O_APPEND | O_CREAT | O_CLOEXEC, 0666);
  if (file_ < 0) fail(path_, std::string("cannot be written: ") + std::strerror(errno));
}

/// A file system without locks leaves it to the scheduler that no shard is done twice at a time.
void Results::lock() {
  if (!is_regular(file_)) fail(path_, "is no file");
  const bool is_taken = flock(file_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  const bool is_finished = path_.extension() == kPartEnding && fs::exists(base_.string() + kResultsEnding);
  if (is_taken || is_finished || !is_file(file_, path_)) fail(path_, "another process is at work on this shard");
}

void Results::resume(const Json& identity) {
  index_ = read_results(path_);
  if (!index_.identity.is_null())
    if (const std::string what = difference(identity, index_.identity); !what.empty())
      fail(path_, "has results of " + what + "; name another folder, or remove it");
  if (const uint64_t torn = index_.file_bytes - index_.good_bytes; torn > 0) {
    std::fprintf(stderr, "%s: the last %llu bytes are no whole record, and are removed\n", path_.c_str(),
                 static_cast<unsigned long long>(torn));
    reopen();
    if (ftruncate(file_, static_cast<off_t>(index_.good_bytes)) != 0) fail(path_, std::strerror(errno));
  }
  if (index_.identity.is_null()) write({identity, ""});
}

/// From now on it is not finished, whatever it is named.
void Results::reopen() {
  if (path_.extension() == kResultsEnding) rename_to(kPartEnding);
}

void Results::write(const Record& record) {
  const std::string bytes = record_bytes(record);
  for (size_t at = 0; at < bytes.size();) {
    const ssize_t wrote = ::write(file_, bytes.data() + at, bytes.size() - at);
    if (wrote < 0 && errno != EINTR) fail(path_, std::string("cannot be written: ") + std::strerror(errno));
    if (wrote > 0) at += static_cast<size_t>(wrote);
  }
  if (fdatasync(file_) != 0) fail(path_, std::string("cannot be written: ") + std::strerror(errno));
}

void Results::rename_to(const char* ending) {
  const fs::path from = std::exchange(path_, base_.string() + ending);
  rename_durably(from, path_);
}

void Results::add(uint64_t pair, bool has_failed, Record record) {
  reopen();
  record.head["pair"] = pair;
  if (has_failed) record.head["failed"] = true;
  write(record);
  index_.is_finished = false;
  index_.pairs[pair] = {.offset = 0, .has_failed = has_failed};
}

void Results::finish() {
  if (!index_.is_finished) write({{{"end", true}}, ""});
  index_.is_finished = true;
  if (path_.extension() == kPartEnding) rename_to(kResultsEnding);
}

}  // namespace collided::cli
