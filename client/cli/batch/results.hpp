#pragma once
// The results of one shard, in a file that is whole whatever kills the process that writes it.
//
// - The first record tells what the results are of; each further one is a pair of frames, durable before the next one
//   is begun; the last one tells that the shard is finished.
// - Until then the file's name ends in ".part".
// - A pair that failed may be followed by another try, which counts.

#include <optional>
#include <unordered_map>

#include "client/cli/batch/record.hpp"
#include "client/cli/batch/shard.hpp"

namespace collided::cli {

constexpr const char* kResultsEnding = ".results";
constexpr const char* kPartEnding = ".part";

/// What is known of one pair.
struct PairResult {
  uint64_t offset = 0;  ///< of its record
  bool has_failed = false;
};

/// What a file of results holds, as far as it is whole.
struct ResultsIndex {
  Json identity;  ///< null if not even that is whole
  std::unordered_map<uint64_t, PairResult> pairs;
  uint64_t good_bytes = 0, file_bytes = 0;
  bool is_finished = false;  ///< by its last record

  /// Finished, and nothing behind that.
  bool is_whole() const { return is_finished && good_bytes == file_bytes; }
  uint64_t failed() const;
};

/// Throws std::runtime_error naming the file if it cannot be read, or is of another format, or has a pair twice.
ResultsIndex read_results(const std::filesystem::path& file);

/// The first name of an identity's that has another value in `other`, and both; empty if they are equal.
std::string difference(const Json& identity, const Json& other);

/// Writes the results of one shard. Only one process can: others are refused.
class Results {
 public:
  /// Goes on with what is there. Throws std::runtime_error naming the file and the reason, such as results of other
  /// options. A record that is not whole is removed, and told of on standard error.
  Results(const std::filesystem::path& folder, const Shard& shard, const Json& identity);
  Results(const Results&) = delete;
  Results& operator=(const Results&) = delete;
  ~Results();

  const ResultsIndex& index() const { return index_; }
  std::string path() const { return path_.string(); }
  /// The record is durable on return.
  void add(uint64_t pair, bool has_failed, Record record);
  void finish();

 private:
  void open();
  void lock();
  void resume(const Json& identity);
  void reopen();
  void write(const Record& record);
  void rename_to(const char* ending);

  std::filesystem::path base_, path_;
  int file_ = -1;
  ResultsIndex index_;
};

}  // namespace collided::cli
