#pragma once
// A step as a CUDA graph: recorded once for each configuration, then launched as a whole.

#include <cuda_runtime.h>

#include <memory>
#include <string>
#include <vector>

#include "gpu/detector.hpp"
#include "gpu/exec/step_key.hpp"

namespace collided {

inline void check_cuda(cudaError_t error, const char* what) {
  if (error == cudaSuccess) return;
  cudaGetLastError();
  const std::string text = std::string(what) + ": " + cudaGetErrorString(error);
  if (error == cudaErrorMemoryAllocation) throw ResourceExhausted(text);
  throw DeviceError(text);
}

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
  StepGraph(const StepKey& key, uint64_t generation)
      : key_(key), generation_(generation), begin_(make_event()), end_(make_event()) {}
  StepGraph(const StepGraph&) = delete;
  StepGraph& operator=(const StepGraph&) = delete;
  ~StepGraph() {
    if (executable_ != nullptr) cudaGraphExecDestroy(executable_);
    for (const Stage& stage : stages_) {
      cudaEventDestroy(stage.begin);
      if (stage.end != nullptr) cudaEventDestroy(stage.end);
    }
    cudaEventDestroy(begin_);
    cudaEventDestroy(end_);
  }

  bool fits(const StepKey& key, uint64_t generation) const { return key_ == key && generation_ == generation; }
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
  void begin_stage(const char* name, cudaStream_t stream) {
    stages_.push_back({name, make_event(), nullptr});
    check_cuda(cudaEventRecordWithFlags(stages_.back().begin, stream, cudaEventRecordExternal), name);
  }

  /// For a stage that others go on beside; else it ends where the next begins. Nothing if it is over already.
  void end_stage(cudaStream_t stream) {
    if (stages_.back().end != nullptr) return;
    stages_.back().end = make_event();
    check_cuda(cudaEventRecordWithFlags(stages_.back().end, stream, cudaEventRecordExternal), stages_.back().name);
  }

  /// Runs the graph and brings `bytes` from the device to pinned memory of the host; waits for both.
  void launch(cudaStream_t stream, const void* result, uint64_t bytes, void* host) {
    check_cuda(cudaEventRecord(begin_, stream), "step");
    check_cuda(cudaGraphLaunch(executable_, stream), "step");
    check_cuda(cudaEventRecord(end_, stream), "step");
    check_cuda(cudaMemcpyAsync(host, result, bytes, cudaMemcpyDeviceToHost, stream), "step");
    check_cuda(cudaStreamSynchronize(stream), "step");
  }

  // Of the last launch.
  double milliseconds() const { return milliseconds_between(begin_, end_); }
  void add_stage_times(std::vector<StageTime>& times) const {
    for (size_t i = 0; i < stages_.size(); ++i)
      times.push_back({stages_[i].name, milliseconds_between(stages_[i].begin, end_of(i))});
  }

 private:
  struct Stage {
    const char* name;
    cudaEvent_t begin, end;
  };
  cudaEvent_t end_of(size_t i) const {
    if (stages_[i].end != nullptr) return stages_[i].end;
    return i + 1 < stages_.size() ? stages_[i + 1].begin : end_;
  }
  StepKey key_;
  uint64_t generation_;  ///< of the buffers that the recording holds addresses of
  cudaGraphExec_t executable_ = nullptr;
  cudaEvent_t begin_, end_;
  std::vector<Stage> stages_;
};

/// The recordings of a scene; those of old buffers go.
class StepGraphs {
 public:
  StepGraph* find(const StepKey& key, uint64_t generation) {
    for (const auto& graph : graphs_)
      if (graph->fits(key, generation)) return graph.get();
    return nullptr;
  }

  template <class F>
  StepGraph& record(const StepKey& key, uint64_t generation, cudaStream_t stream, const F& enqueue) {
    constexpr size_t kMost = 16;
    std::erase_if(graphs_, [&](const auto& graph) { return graph->generation() != generation; });
    if (graphs_.size() == kMost) graphs_.erase(graphs_.begin());
    auto graph = std::make_unique<StepGraph>(key, generation);
    recording_ = graph.get();
    try {
      graph->record(stream, enqueue);
    } catch (...) {
      recording_ = nullptr;
      throw;
    }
    recording_ = nullptr;
    graphs_.push_back(std::move(graph));
    return *graphs_.back();
  }

  bool is_recording() const { return recording_ != nullptr; }
  void begin_stage(const char* name, cudaStream_t stream) { recording_->begin_stage(name, stream); }
  void end_stage(cudaStream_t stream) { recording_->end_stage(stream); }

 private:
  std::vector<std::unique_ptr<StepGraph>> graphs_;
  StepGraph* recording_ = nullptr;
};

}  // namespace collided
