// The results of all shards in one table.

#include "client/cli/batch/merge.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <stdexcept>

#include "client/app/output/csv.hpp"
#include "client/app/output/durable.hpp"
#include "client/app/output/progress.hpp"
#include "client/cli/batch/results.hpp"
#include "client/cli/batch/row.hpp"

namespace collided::cli {

namespace fs = std::filesystem;

namespace {

struct ShardResults {
  fs::path file;
  ResultsIndex index;
};

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  throw std::runtime_error(file.string() + ": " + what);
}

/// Files of results in the folder, also unfinished ones, in the order of their names.
std::vector<fs::path> result_files(const fs::path& folder) {
  if (!fs::is_directory(folder)) fail(folder, "is no folder");
  std::vector<fs::path> files;
  for (const fs::path& file : fs::directory_iterator(folder))
    if (file.extension() == kResultsEnding || file.extension() == kPartEnding) files.push_back(file);
  std::sort(files.begin(), files.end());
  if (files.empty()) fail(folder, "has no results of 'collidectl batch'");
  return files;
}

/// "3,5-8", as a scheduler takes it.
std::string ranges(const std::vector<uint64_t>& numbers) {
  std::string text;
  for (size_t first = 0, last = 0; first < numbers.size(); first = ++last) {
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    text += (text.empty() ? "" : ",") + std::to_string(numbers[first]);
    if (last > first) text += "-" + std::to_string(numbers[last]);
  }
  return text;
}

/// Results of the same pairs with the same options, but for which shard they are.
void check_same(const ShardResults& first, const ShardResults& other) {
  Json expected = first.index.identity;
  expected["shard"] = other.index.identity.value("shard", Json());
  if (const std::string what = difference(expected, other.index.identity); !what.empty())
    fail(other.file, "has results of " + what + " as " + first.file.filename().string());
}

void check_pairs(const ShardResults& results) {
  const Json& identity = results.index.identity;
  const uint64_t index = number_of(identity, "shard"), count = number_of(identity, "shards");
  const Shard shard{static_cast<uint32_t>(index), static_cast<uint32_t>(count)};
  if (index < 1 || index > count || count > kMaxShards) fail(results.file, "has results of no shard");
  const uint64_t pairs = number_of(identity, "pairs");
  for (const auto& [pair, result] : results.index.pairs)
    if (pair < 1 || pair > pairs || !shard.has(pair))
      fail(results.file, "has pair " + std::to_string(pair) + ", which is not of this shard");
  if (results.index.pairs.size() != shard.size_of(pairs))
    fail(results.file, "has " + std::to_string(results.index.pairs.size()) + " of " +
                           std::to_string(shard.size_of(pairs)) + " pairs");
}

using Shards = std::map<uint64_t, ShardResults>;

Shards finished_shards(const fs::path& folder) {
  Shards shards;
  for (const fs::path& file : result_files(folder)) {
    if (file.extension() == kPartEnding) continue;
    ShardResults results{file, read_results(file)};
    if (!results.index.is_whole())
      fail(file, "is cut off or damaged after " + std::to_string(results.index.good_bytes) + " of " +
                     std::to_string(results.index.file_bytes) + " bytes; run its shard again");
    if (!shards.empty()) check_same(shards.begin()->second, results);
    check_pairs(results);
    const auto [at, is_new] = shards.emplace(number_of(results.index.identity, "shard"), std::move(results));
    if (!is_new) fail(file, "is the same shard as " + at->second.file.filename().string());
  }
  return shards;
}

Shards all_shards(const fs::path& folder) {
  Shards shards = finished_shards(folder);
  if (shards.empty()) fail(folder, "has no finished shard");
  const uint64_t count = number_of(shards.begin()->second.index.identity, "shards");
  std::vector<uint64_t> missing;
  for (uint64_t shard = 1; shard <= count; ++shard)
    if (!shards.contains(shard)) missing.push_back(shard);
  if (!missing.empty())
    fail(folder, std::to_string(missing.size()) + " of " + std::to_string(count) +
                     " shards are not finished or not there: " + ranges(missing));
  return shards;
}

/// Gives `take` the record of each pair, in their order.
void for_each_pair(const Shards& shards, uint64_t pairs, const std::function<void(const Record&)>& take) {
  Progress progress;
  for (uint64_t pair = 1; pair <= pairs; ++pair) {
    const ShardResults& results = shards.at((pair - 1) % shards.size() + 1);
    RecordReader reader(results.file);  // no file stays open: there may be more shards than descriptors
    reader.seek(results.index.pairs.at(pair).offset);
    const auto record = reader.next();
    if (!record) fail(results.file, "was changed meanwhile");
    take(*record);
    progress.show("pairs", static_cast<int>(pair), static_cast<int>(pairs));
  }
}

/// A table under another name until it is whole.
class Table {
 public:
  explicit Table(const std::string& name)
      : name_(name),
        is_file_(!is_standard_output(name) && (!fs::exists(name) || fs::is_regular_file(name))),
        rows_(file()) {}
  ~Table() {
    std::error_code error;
    if (is_file_ && !is_done_) fs::remove(file(), error);
  }
  void add(std::string_view text) { rows_.text(text); }
  void finish() {
    rows_.finish();
    if (is_file_) sync_and_rename(file(), name_);
    is_done_ = true;
  }

 private:
  std::string file() const { return is_file_ ? name_ + ".unfinished" : name_; }

  std::string name_;
  bool is_file_, is_done_ = false;
  NumberFile rows_;
};

}  // namespace

Json merge_results(const MergeOptions& options) {
  const Shards shards = all_shards(options.folder);
  const Json& identity = shards.begin()->second.index.identity;
  if (!options.contacts.empty() && !identity.value("contacts", false))
    fail(options.folder, "has no contacts: 'collidectl batch --contacts' keeps them");
  Table table(options.out);
  std::optional<Table> contacts;
  table.add(kRowHeader);
  if (!options.contacts.empty()) contacts.emplace(options.contacts).add("pair," + csv_header());
  const uint64_t pairs = number_of(identity, "pairs");
  for_each_pair(shards, pairs, [&](const Record& record) {
    table.add(row_in(record));
    if (contacts) contacts->add(contacts_in(record));
  });
  if (contacts) contacts->finish();
  table.finish();
  uint64_t failed = 0;
  for (const auto& [shard, results] : shards) failed += results.index.failed();
  return {{"shards", shards.size()}, {"pairs", pairs}, {"failed_pairs", failed}, {"out", options.out}};
}

}  // namespace collided::cli
