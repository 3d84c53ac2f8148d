#pragma once
// The results of all shards in one table.

#include <string>

#include "client/app/report/json.hpp"

namespace collided::cli {

struct MergeOptions {
  std::string folder, out, contacts;
  bool json = false;
};

/// Checks that each shard is there and whole and that each pair is there once, then writes the table, and the table of
/// contacts if `contacts` names one. Returns a summary. Throws std::runtime_error naming the file or the shards, before
/// anything is written.
Json merge_results(const MergeOptions& options);

}  // namespace collided::cli
