#pragma once
// Detects the contacts of steps that have nothing to do with each other, each in a scene of its own.

#include <optional>
#include <stdexcept>
#include <string>

#include "client/app/daemon/connection.hpp"
#include "client/app/input/step_input.hpp"
#include "client/cli/batch/run.hpp"

namespace collided::cli {

/// It is the step's own fault that it has no result.
struct StepRefused : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct StepResult {
  v1::Scene scene;
  client::FrameOutput output;
};

class StepRunner {
 public:
  /// Connects, or starts a daemon.
  explicit StepRunner(const BatchOptions& options);

  /// If its own daemon ends, tries once more with a new one. Throws StepRefused, also for a step with which two daemons
  /// ended, client::Error for what is no step's fault, and Interrupted.
  StepResult run(const StepInput& step);
  /// The rows of the contacts as CSV, each beginning with the pair; empty if the options do not keep contacts.
  std::string contact_rows(uint64_t pair, const StepInput& step, const StepResult& result) const;

 private:
  StepResult try_once(const StepInput& step);

  const BatchOptions& options_;
  std::optional<Connection> connection_;
};

}  // namespace collided::cli
