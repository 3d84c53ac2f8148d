#pragma once
// All streams: opened together, driven together, ended together.

#include <memory>

#include "client/measure/load/daemon/target.hpp"
#include "client/measure/load/drive/motion.hpp"
#include "client/measure/load/drive/stream_pace.hpp"
#include "client/measure/load/tally/stream_states.hpp"

namespace collided::cli::load {

class Fleet {
 public:
  /// Creates the scenes and opens a stream to each. Throws Error, std::runtime_error, Interrupted.
  Fleet(Target& target, const LoadSettings& settings, const Motion& motion);
  ~Fleet();

  const v1::Scene& scene() const;  ///< one of them; all are alike
  uint32_t stream_count() const;
  uint64_t bytes_per_frame() const;
  size_t connections() const;
  size_t threads() const;

  void begin(const Phase& phase);
  /// A closed loop sends nothing more.
  void stop();
  /// Whether every open stream has sent all of its frames, and has all answers.
  bool is_idle() const;
  /// Counts what is overdue or unanswered as such.
  void give_up(Time now);
  StreamStates states() const;
  /// What was counted since the last call.
  Tally take_tally();
  Second take_second();
  /// CPU time of the thread that has worked most.
  double busiest_thread_seconds() const;

  /// Ends the streams in good order and deletes the scenes.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace collided::cli::load
