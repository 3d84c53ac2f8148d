// The work of one shard.

#include "client/cli/batch/run.hpp"

#include <future>
#include <optional>
#include <utility>

#include "client/app/daemon/interrupt.hpp"
#include "client/app/input/step_input.hpp"
#include "client/app/output/progress.hpp"
#include "client/cli/batch/results.hpp"
#include "client/cli/batch/row.hpp"
#include "client/cli/batch/step_runner.hpp"

namespace collided::cli {

namespace {

StepInput read_step(const Dataset& dataset, const FrameNames& names) {
  const std::string first = dataset.path_of(names.front());
  return names.size() == 2 ? file_step(first, dataset.path_of(names[1])) : file_frame(first);
}

/// What all results must have in common to be merged, and a shard's to be gone on with.
Json identity_of(const BatchOptions& options, const Dataset& dataset, const Shard& shard) {
  const DetectionOptions& detection = options.detection;
  return {{"format", 1},
          {"version", COLLIDED_VERSION},
          {"shard", shard.index},
          {"shards", shard.count},
          {"pairs", dataset.pairs.size()},
          {"dataset", dataset.digest()},
          {"contacts", options.keep_contacts},
          {"mode", detection.mode},
          {"accuracy", detection.accuracy},
          {"thickness", detection.thickness},
          {"delta", detection.delta},
          {"report", detection.report},
          {"kinds", detection.kinds},
          {"exclude_rings", options.exclude_rings},
          {"position_format", options.position_format}};
}

/// Pairs, from 1 on, that have no result yet.
std::vector<uint64_t> pairs_to_do(const ResultsIndex& index, const Shard& shard, uint64_t pairs, bool retry_failed) {
  std::vector<uint64_t> out;
  for (uint64_t pair = shard.index; pair <= pairs; pair += shard.count) {
    const auto known = index.pairs.find(pair);
    if (known == index.pairs.end() || (retry_failed && known->second.has_failed)) out.push_back(pair);
  }
  return out;
}

/// Reads each step while the one before is worked on.
class StepReader {
 public:
  StepReader(const Dataset& dataset, const std::vector<uint64_t>& pairs) : dataset_(dataset), pairs_(pairs) { start(); }
  /// Its get() throws std::runtime_error naming the file and what is wrong with it.
  std::future<StepInput> next() {
    std::future<StepInput> step = std::move(step_);
    step.wait();
    start();
    return step;
  }

 private:
  void start() {
    if (at_ == pairs_.size()) return;
    const FrameNames& names = dataset_.pairs[pairs_[at_++] - 1];
    step_ = std::async(std::launch::async, [this, &names] { return read_step(dataset_, names); });
  }

  const Dataset& dataset_;
  const std::vector<uint64_t>& pairs_;
  size_t at_ = 0;
  std::future<StepInput> step_;
};

/// Keeps a pair's result. Whatever is no fault of the pair is thrown on.
void do_pair(uint64_t pair, const FrameNames& names, StepReader& reader, StepRunner& runner, Results& results) {
  const auto keep_failure = [&](const std::string& why) {
    results.add(pair, true, pair_record(failed_row(pair, names, why), ""));
  };
  std::future<StepInput> read = reader.next();
  std::optional<StepInput> step;
  try {
    step = read.get();
  } catch (const std::runtime_error& unreadable) {
    return keep_failure(unreadable.what());
  }
  std::optional<StepResult> found;
  try {
    found = runner.run(*step);
  } catch (const StepRefused& refused) {
    return keep_failure(refused.what());
  }
  results.add(pair, false,
              pair_record(row_of(pair, names, found->scene, found->output), runner.contact_rows(pair, *step, *found)));
}

}  // namespace

Json run_shard(const BatchOptions& options, const Dataset& dataset, const Shard& shard) {
  Results results(options.out, shard, identity_of(options, dataset, shard));
  const std::vector<uint64_t> pairs = pairs_to_do(results.index(), shard, dataset.pairs.size(), options.retry_failed);
  const uint64_t all = shard.size_of(dataset.pairs.size());
  if (!pairs.empty()) {
    StepRunner runner(options);
    StepReader reader(dataset, pairs);
    Progress progress;
    for (size_t i = 0; i < pairs.size(); ++i) {
      check_interrupt();
      do_pair(pairs[i], dataset.pairs[pairs[i] - 1], reader, runner, results);
      progress.show("shard " + shard.text(), static_cast<int>(all - pairs.size() + i + 1), static_cast<int>(all));
    }
  }
  results.finish();
  return {{"shard", shard.text()},
          {"pairs", all},
          {"resumed_pairs", all - pairs.size()},
          {"failed_pairs", results.index().failed()},
          {"out", results.path()}};
}

}  // namespace collided::cli
