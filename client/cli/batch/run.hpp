#pragma once
// The work of one shard: each of its pairs that has no result yet, one after the other.

#include <string>

#include "client/app/options/values.hpp"
#include "client/app/report/json.hpp"
#include "client/cli/batch/shard.hpp"
#include "client/cli/dataset/dataset.hpp"

namespace collided::cli {

struct BatchOptions {
  ServerOptions server;
  DetectionOptions detection;
  uint32_t exclude_rings = 0;
  std::string position_format = kAutomaticFormat;
  std::string dataset, out, shard = "1/1";
  bool keep_contacts = false;
  bool retry_failed = false;
  bool list = false;
  bool json = false;
};

/// Detects the contacts of each pair in a scene of its own, and keeps what was found, or why the pair is no input.
/// Returns a summary. Throws std::runtime_error for what is no pair's fault, such as a daemon that cannot be reached or
/// a full disk, and Interrupted; called again, it goes on.
Json run_shard(const BatchOptions& options, const Dataset& dataset, const Shard& shard);

}  // namespace collided::cli
