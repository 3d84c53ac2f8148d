#pragma once
// A step as a CUDA graph: recorded once for each configuration, then launched as a whole.

#include <cuda_runtime.h>

#include <atomic>
#include <cstddef>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gpu/exec/cuda/cuda_memory.cuh"
#include "gpu/exec/for_now.hpp"

namespace collided {

inline cudaEvent_t make_event() {
  cudaEvent_t event = nullptr;
  check_cuda(cudaEventCreate(&event), "cudaEventCreate");
  return event;
}
inline double milliseconds_between(cudaEvent_t from, cudaEvent_t to) {
  float milliseconds = 0;
  check_cuda(cudaEventElapsedTime(&milliseconds, from, to), "cudaEventElapsedTime");
  return milliseconds;
}

class StepGraph {
 public:
  static constexpr size_t kMaxTimes = 64;

  StepGraph(uint64_t key, uint64_t generation) : key_(key), generation_(generation) {}
  StepGraph(const StepGraph&) = delete;
  StepGraph& operator=(const StepGraph&) = delete;
  ~StepGraph() {
    if (executable_ != nullptr) cudaGraphExecDestroy(executable_);
  }

  bool fits(uint64_t key, uint64_t generation) const { return key_ == key && generation_ == generation; }
  uint64_t generation() const { return generation_; }

  template <class F>
  void record(cudaStream_t stream, const F& enqueue) {
    check_cuda(cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal), "begin of a recording");
    cudaGraph_t graph = nullptr;
    try {
      enqueue();
    } catch (...) {
      cudaStreamEndCapture(stream, &graph);
      if (graph != nullptr) cudaGraphDestroy(graph);
      cudaGetLastError();
      throw;
    }
    check_cuda(cudaStreamEndCapture(stream, &graph), "end of a recording");
    const cudaError_t error = cudaGraphInstantiate(&executable_, graph, 0);
    cudaGraphDestroy(graph);
    check_cuda(error, "cudaGraphInstantiate");
  }

  // While it is recorded: which of its times a stage begins or ends at. A stage ends where the next begins, unless it
  // is told where.
  size_t begin_stage(const char* name) {
    stages_.push_back({name, new_time(), kNoTime});
    return stages_.back().begin;
  }
  size_t end_stage(size_t stage) { return stages_[stage].end = new_time(); }
  bool has_end(size_t stage) const { return stages_[stage].end != kNoTime; }
  size_t stages() const { return stages_.size(); }
  size_t end() { return last_ = new_time(); }

  void launch(cudaStream_t stream) { check_cuda(cudaGraphLaunch(executable_, stream), "step"); }
  /// Of the launch, once it is over; kMaxTimes of them.
  void keep_times(const uint64_t* times) { std::memcpy(times_, times, sizeof(times_)); }

  // Of the last launch.
  double milliseconds() const {
    return stages_.empty() ? 0 : static_cast<double>(times_[last_] - times_[stages_.front().begin]) / kMillisecond;
  }
  void add_stage_times(std::vector<StageTime>& times) const {
    for (size_t i = 0; i < stages_.size(); ++i)
      times.push_back({stages_[i].name, static_cast<double>(end_of(i) - times_[stages_[i].begin]) / kMillisecond});
  }

 private:
  static constexpr double kMillisecond = 1e6;
  static constexpr size_t kNoTime = kMaxTimes;
  struct Stage {
    const char* name;
    size_t begin, end;  ///< times; kNoTime: where the next one begins
  };
  size_t new_time() {
    if (times_used_ == kMaxTimes) throw DeviceError("a step has too many stages");
    return times_used_++;
  }
  uint64_t end_of(size_t i) const {
    if (stages_[i].end != kNoTime) return times_[stages_[i].end];
    return times_[i + 1 < stages_.size() ? stages_[i + 1].begin : last_];
  }
  uint64_t key_;
  uint64_t generation_;  ///< of the buffers that the recording holds addresses of
  cudaGraphExec_t executable_ = nullptr;
  std::vector<Stage> stages_;
  size_t times_used_ = 0, last_ = 0;
  uint64_t times_[kMaxTimes] = {};  ///< in nanoseconds, of the last launch
};

/// The right to record, which few scenes of the process have at once.
class RecordingTurn {
 public:
  static std::optional<RecordingTurn> take() {
    int taken = taken_.load(std::memory_order_relaxed);
    while (taken < kMost)
      if (taken_.compare_exchange_weak(taken, taken + 1, std::memory_order_relaxed)) return RecordingTurn();
    return std::nullopt;
  }
  RecordingTurn(RecordingTurn&& other) noexcept : is_held_(std::exchange(other.is_held_, false)) {}
  RecordingTurn& operator=(RecordingTurn&& other) noexcept {
    std::swap(is_held_, other.is_held_);
    return *this;
  }
  ~RecordingTurn() {
    if (is_held_) taken_.fetch_sub(1, std::memory_order_relaxed);
  }

 private:
  static constexpr int kMost = 2;
  static inline std::atomic<int> taken_ = 0;

  RecordingTurn() = default;
  bool is_held_ = true;
};

/// The recordings of a scene; those of old buffers go.
class StepGraphs {
 public:
  StepGraph* find(uint64_t key, uint64_t generation) {
    for (const auto& graph : graphs_)
      if (graph->fits(key, generation)) return graph.get();
    return nullptr;
  }

  template <class F>
  StepGraph& record(uint64_t key, uint64_t generation, cudaStream_t stream, const F& enqueue) {
    constexpr size_t kMax = 16;
    std::erase_if(graphs_, [&](const auto& graph) { return graph->generation() != generation; });
    if (graphs_.size() == kMax) graphs_.erase(graphs_.begin());
    auto graph = std::make_unique<StepGraph>(key, generation);
    const ForNow recording(recording_, graph.get());
    graph->record(stream, enqueue);
    graphs_.push_back(std::move(graph));
    return *graphs_.back();
  }

  bool is_recording() const { return recording_ != nullptr; }
  StepGraph& recording() { return *recording_; }

 private:
  std::vector<std::unique_ptr<StepGraph>> graphs_;
  StepGraph* recording_ = nullptr;
};

}  // namespace collided
