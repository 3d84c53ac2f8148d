// What a file of results holds.

#include <algorithm>
#include <stdexcept>

#include "client/cli/batch/results.hpp"

namespace collided::cli {

namespace {

std::string value_text(const Json& identity, const std::string& name) {
  return identity.contains(name) ? json_text(identity[name]) : "nothing";
}

void add(ResultsIndex& index, const Record& record, uint64_t offset, const std::string& file) {
  const uint64_t pair = number_of(record.head, "pair");
  const PairResult result{offset, record.head.contains("failed")};
  const auto [at, is_new] = index.pairs.emplace(pair, result);
  if (is_new) return;
  if (!at->second.has_failed) throw std::runtime_error(file + ": has pair " + std::to_string(pair) + " twice");
  at->second = result;
}

}  // namespace

uint64_t ResultsIndex::failed() const {
  return static_cast<uint64_t>(
      std::count_if(pairs.begin(), pairs.end(), [](const auto& pair) { return pair.second.has_failed; }));
}

ResultsIndex read_results(const std::filesystem::path& file) {
  RecordReader reader(file);
  ResultsIndex index;
  index.file_bytes = reader.bytes();
  for (uint64_t offset = 0; const auto record = reader.next(); offset = reader.offset()) {
    index.is_finished = record->head.contains("end");
    if (offset == 0)
      index.identity = record->head;
    else if (!index.is_finished)
      add(index, *record, offset, file.string());
  }
  index.good_bytes = reader.offset();
  return index;
}

std::string difference(const Json& identity, const Json& other) {
  for (const auto& [name, value] : identity.items())
    if (!other.contains(name) || other[name] != value)
      return name + " " + value_text(other, name) + ", not " + json_text(value);
  return "";
}

}  // namespace collided::cli
