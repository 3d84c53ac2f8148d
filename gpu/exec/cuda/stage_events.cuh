#pragma once
// Times of the stages of a frame: those of recorded steps, which note their own; those around steps, by the host's
// clock, for the host waits for the device there; and those of steps by parts, which events are around.

#include <cuda_runtime.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

#include "gpu/exec/cuda/cuda_memory.cuh"
#include "gpu/exec/cuda/step_graph.cuh"

namespace collided {

class StageEvents {
 public:
  StageEvents() = default;
  StageEvents(const StageEvents&) = delete;
  StageEvents& operator=(const StageEvents&) = delete;
  ~StageEvents() {
    for (const cudaEvent_t event : events_) cudaEventDestroy(event);
  }

  /// Forgets the frame before.
  void begin_frame() {
    named_.clear();
    of_steps_.clear();
    events_used_ = 0;
  }
  /// f() is a stage in which the host waits for what it puts in line, or does the work itself.
  template <class F>
  void time(const char* name, const F& f) {
    const size_t stage = begin(name);
    const auto start = std::chrono::steady_clock::now();
    f();
    named_[stage].milliseconds =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  }
  /// f() puts a stage in line on the stream.
  template <class F>
  void time_in_line(const char* name, cudaStream_t stream, const F& f) {
    const size_t stage = begin(name), first = events_used_;
    events_used_ += 2;
    while (events_.size() < events_used_) events_.push_back(make_event());
    named_[stage].event = first;
    check_cuda(cudaEventRecord(events_[first], stream), name);
    try {
      f();
    } catch (...) {
      cudaEventRecord(events_[first + 1], stream);  // the frame may go on without what this stage was part of
      throw;
    }
    check_cuda(cudaEventRecord(events_[first + 1], stream), name);
  }
  /// Whether some have to be over before all() is asked.
  bool are_in_line() const { return events_used_ > 0; }
  void add(const StepGraph& step) { step.add_stage_times(of_steps_); }

  /// In the order that the stages ran, once all of them are over.
  std::vector<StageTime> all() const {
    std::vector<StageTime> times;
    size_t of_steps = 0;
    for (size_t i = 0; i < named_.size(); ++i) {
      for (; of_steps < named_[i].after; ++of_steps) times.push_back(of_steps_[of_steps]);
      times.push_back({named_[i].name, milliseconds_of(named_[i])});
    }
    times.insert(times.end(), of_steps_.begin() + static_cast<std::ptrdiff_t>(of_steps), of_steps_.end());
    return times;
  }

 private:
  static constexpr size_t kNoEvent = ~size_t{0};
  struct NamedStage {
    const char* name;
    size_t after;             ///< stages of recorded steps before it
    double milliseconds = 0;  ///< by the host's clock
    size_t event = kNoEvent;  ///< the first of two
  };
  size_t begin(const char* name) {
    named_.push_back({name, of_steps_.size()});
    return named_.size() - 1;
  }
  double milliseconds_of(const NamedStage& stage) const {
    if (stage.event == kNoEvent) return stage.milliseconds;
    return milliseconds_between(events_[stage.event], events_[stage.event + 1]);
  }
  std::vector<cudaEvent_t> events_;
  size_t events_used_ = 0;
  std::vector<NamedStage> named_;
  std::vector<StageTime> of_steps_;
};

}  // namespace collided
