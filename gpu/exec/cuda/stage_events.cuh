#pragma once
// Times of the stages of a frame: those of recorded steps, which note their own, and those that events are around.

#include <cuda_runtime.h>

#include <algorithm>
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
  }
  /// Runs f(), which puts a stage in line on the stream.
  template <class F>
  void time(const char* name, cudaStream_t stream, const F& f) {
    const size_t first = 2 * named_.size();
    while (events_.size() < first + 2) events_.push_back(make_event());
    named_.push_back({name, of_steps_.size()});
    check_cuda(cudaEventRecord(events_[first], stream), name);
    f();
    check_cuda(cudaEventRecord(events_[first + 1], stream), name);
  }
  void add(const StepGraph& step) { step.add_stage_times(of_steps_); }

  /// In the order that the stages ran, once all of them are over.
  std::vector<StageTime> all() const {
    std::vector<StageTime> times;
    size_t of_steps = 0;
    for (size_t i = 0; i < named_.size(); ++i) {
      for (; of_steps < named_[i].after; ++of_steps) times.push_back(of_steps_[of_steps]);
      times.push_back({named_[i].name, milliseconds_between(events_[2 * i], events_[2 * i + 1])});
    }
    times.insert(times.end(), of_steps_.begin() + static_cast<std::ptrdiff_t>(of_steps), of_steps_.end());
    return times;
  }

 private:
  struct NamedStage {
    const char* name;
    size_t after;  ///< stages of recorded steps before it
  };
  std::vector<cudaEvent_t> events_;
  std::vector<NamedStage> named_;
  std::vector<StageTime> of_steps_;
};

}  // namespace collided
