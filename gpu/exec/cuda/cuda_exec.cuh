#pragma once
// The verbs of the engine (concepts.hpp) on a CUDA GPU (CUB).

#include <cuda_runtime.h>

#include <algorithm>
#include <cstring>
#include <cub/cub.cuh>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gpu/exec/atomic.hpp"
#include "gpu/exec/buffer.hpp"
#include "gpu/exec/concepts.hpp"
#include "gpu/exec/cpu/cpu_loops.hpp"
#include "gpu/exec/cuda/cuda_memory.cuh"
#include "gpu/exec/cuda/device.cuh"
#include "gpu/exec/cuda/for_each.cuh"
#include "gpu/exec/cuda/graph_loop.cuh"
#include "gpu/exec/cuda/in_parts.cuh"
#include "gpu/exec/cuda/nvtx.cuh"
#include "gpu/exec/cuda/reduce.cuh"
#include "gpu/exec/cuda/resumable.cuh"
#include "gpu/exec/cuda/side_streams.cuh"
#include "gpu/exec/cuda/stage_events.cuh"
#include "gpu/exec/cuda/staging.cuh"
#include "gpu/exec/cuda/step_graph.cuh"
#include "gpu/exec/cuda/waiting.cuh"
#include "gpu/exec/for_now.hpp"

namespace collided {

class CudaExec {
 public:
  /// `threads`: of the host, for what is done there; 0: all cores.
  CudaExec(int device, int threads, MemoryLimits memory)
      : device_(use_device(device)),
        memory_(device, std::make_shared<MemoryLedger>(std::move(memory))),
        loops_(threads),
        scratch_(*this, "scratch"),
        arrived_(*this, "counters"),
        times_(*this, "counters") {
    cudaDeviceProp properties{};
    check_cuda(cudaGetDeviceProperties(&properties, device), "cudaGetDeviceProperties");
    info_ = info_of(device, properties);
    processors_ = static_cast<unsigned>(properties.multiProcessorCount);
    times_.allocate(StepGraph::kMaxTimes);
    arrived_.allocate(1);
    check_cuda(cudaMemsetAsync(arrived_.data(), 0, sizeof(unsigned), stream_), "cudaMemset");
  }
  CudaExec(const CudaExec&) = delete;
  CudaExec& operator=(const CudaExec&) = delete;
  ~CudaExec() {
    cudaSetDevice(device_);
    cudaStreamSynchronize(stream_);
    cudaEventDestroy(fork_);
    cudaEventDestroy(join_);
  }

  const DeviceInfo& device() const { return info_; }

  void* allocate(const std::string& part, uint64_t bytes) {
    ++generation_;
    ++allocations_;
    return memory_.allocate(part, bytes);
  }
  void deallocate(const std::string& part, void* memory, uint64_t bytes) {
    ++generation_;
    cudaStreamSynchronize(stream_);  // what is in line may use it
    memory_.deallocate(part, memory, bytes);
  }
  static constexpr bool kLaunchesCost = true;
  static constexpr bool kRecordsLoops = collided::kRecordsLoops;
  const MemoryLedger& ledger() const { return *memory_.ledger(); }

  using Staging = CudaStaging;
  Staging make_staging() const { return Staging(device_, memory_.ledger()); }
  void done_with(Staging& staging) { staging.read_last_by(stream_); }

  template <ItemFunctor F>
  void for_each(const char* name, uint64_t n, const F& f) {
    if (n == 0) return;
    launch(name, for_each_kernel<F>, blocks_for(n, kBlock), kBlock, n, f);
  }
  template <ItemFunctor F>
  void for_each(const char* name, const Counted& n, const F& f) {
    if (n.most == 0) return;
    constexpr unsigned kBlocksPerProcessor = 16;
    const unsigned blocks = std::min(blocks_for(n.most, kCountedBlock), kBlocksPerProcessor * processors_);
    launch(name, for_each_counted_kernel<F>, blocks, kCountedBlock, n, f);
  }

  template <GroupFunctor F>
  void for_each_group(const char* name, const Counted& n, const F& f) {
    if (n.most == 0) return;
    unsigned of_processor = 2 * 2048 / F::kGroupSize;
    if constexpr (requires { F::kGroupsOfProcessor; }) of_processor = F::kGroupsOfProcessor;
    const unsigned blocks = static_cast<unsigned>(std::min<uint64_t>(n.most, of_processor * processors_));
    launch(name, for_each_group_kernel<F>, blocks, F::kGroupSize, n, f);
  }

  template <WalkingFunctor F>
  void for_each_part(const char* name, const Counted& n, const F& f) {
    if (n.most == 0) return;
    constexpr unsigned kBlocksPerProcessor = F::kWalks ? 16 : 64;
    const unsigned most = blocks_for(n.most, kPartsBlock / 32 * kLeastItems<F>);
    launch(name, for_each_part_kernel<F>, std::min(most, kBlocksPerProcessor * processors_), kPartsBlock, n, f);
  }

  /// A group works on each item.
  template <ManyPartsFunctor F>
  void for_each_of_many_parts(const char* name, const Counted& n, const F& f) {
    for_each_group(name, n, PartsOfItem<F>{f});
  }

  template <ResumableFunctor F>
  void for_each_resumable(const char* name, const Counted& n, uint64_t* next, const F& f) {
    if (n.most == 0) return;
    const unsigned most = blocks_for(n.most, kResumableBlock / 32);  // a warp may take as little as one
    const unsigned blocks = std::min(most, resident_blocks(name, for_each_resumable_kernel<F>, kResumableBlock));
    launch(name, for_each_resumable_kernel<F>, blocks, kResumableBlock, n, next, stop(), f);
  }

  template <class T, class F, class Op, class Then = NothingMore>
  void reduce_into(const char* name, uint64_t n, const F& transform, const T& identity, const Op& op, T* result,
                   const Then& then = {}) {
    constexpr unsigned kBlocksPerProcessor = 4;
    const unsigned blocks = std::max(1u, std::min(blocks_for(n, kReduceBlock), kBlocksPerProcessor * processors_));
    scratch_.ensure(blocks * sizeof(T));
    const Partial<T> partial{reinterpret_cast<T*>(scratch_.data()), arrived_.data()};
    launch(name, reduce_kernel<T, F, Op, Then>, blocks, kReduceBlock, n, transform, identity, op, partial, result,
           then);
  }

  template <class T>
  void exclusive_scan(const char* name, Span<T> values) {
    with_scratch(name, [&](void* memory, size_t& bytes) {
      return cub::DeviceScan::ExclusiveSum(memory, bytes, values.data, values.data, values.size(), stream_);
    });
  }

  int sort_pairs(const char* name, int bits, const SortArrays& arrays) {
    cub::DoubleBuffer<uint64_t> keys(arrays.keys.data, arrays.other_keys.data);
    if (arrays.values.empty()) {
      with_scratch(name, [&](void* memory, size_t& bytes) {
        return cub::DeviceRadixSort::SortKeys(memory, bytes, keys, arrays.keys.size(), 0, bits, stream_);
      });
      return keys.selector;
    }
    cub::DoubleBuffer<uint32_t> values(arrays.values.data, arrays.other_values.data);
    const int count = static_cast<int>(arrays.keys.size());
    with_scratch(name, [&](void* memory, size_t& bytes) {
      return cub::DeviceRadixSort::SortPairs(memory, bytes, keys, values, count, 0, bits, stream_);
    });
    return keys.selector;
  }

  /// Few scenes record at once: the driver makes their graphs one after the other, and eight hundred scenes that begin
  /// together would wait for 0.3 s (H200), in which each of them can run many steps by parts.
  bool can_step(uint64_t key) {
    if (graphs_.find(key, generation_) != nullptr) return true;
    if (!turn_to_record_) turn_to_record_ = RecordingTurn::take();
    return turn_to_record_.has_value();
  }
  /// The first step of a key is recorded as a graph, and replayed as long as all buffers are the same: one launch,
  /// whatever the number of stages.
  template <class F, class T>
  T step(uint64_t key, const T* result, const F& enqueue) {
    asks().ask();
    StepGraph* graph = graphs_.find(key, generation_);
    if (graph == nullptr) {
      reserve(enqueue);
      const ForNow begin(begin_, static_cast<uint64_t*>(nullptr));
      graph = &graphs_.record(key, generation_, stream_, [&] {
        enqueue();
        note_now(graphs_.recording().end());
      });
      turn_to_record_.reset();
    }
    const NvtxRange range("step");
    static_assert(sizeof(T) % sizeof(uint64_t) == 0 && alignof(T) % alignof(uint64_t) == 0, "answers are words");
    constexpr uint64_t kWords = sizeof(T) / sizeof(uint64_t);
    graph->launch(stream_);
    answer_.send(stream_, {reinterpret_cast<const uint64_t*>(result), kWords}, times_.all());
    ++graph_launches_;
    draining_if_thrown(stop_, stream_, [&] { wait_for_answer(answer_, stream_, asks()); });
    graph->keep_times(answer_.second(kWords));
    T host;
    std::memcpy(&host, answer_.first(), sizeof(T));
    step_milliseconds_ += graph->milliseconds();
    stage_events_.add(*graph);
    return host;
  }
  /// Its stages are timed by events, and nothing runs side by side.
  template <class F, class T>
  T step_by_parts(const T* result, const F& f) {
    asks().ask();
    const NvtxRange range("step by parts");
    check_cuda(cudaEventRecord(fork_, stream_), "step");
    {
      const ForNow in_parts(in_parts_, true);
      draining_if_thrown(stop_, stream_, f);
    }
    check_cuda(cudaEventRecord(join_, stream_), "step");
    const T found = peek(result);
    step_milliseconds_ += milliseconds_between(fork_, join_);
    return found;
  }
  template <class T>
  T peek(const T* result) {
    T host;
    download_async(host_memory(sizeof(T)), result, sizeof(T));
    draining_if_thrown(stop_, stream_, [&] { wait_until_drained(stream_, asks()); });
    std::memcpy(&host, host_.data(), sizeof(T));
    return host;
  }
  double step_milliseconds() const { return step_milliseconds_; }
  uint32_t graph_launches() const { return graph_launches_; }
  uint32_t allocations() const { return allocations_; }

  void upload(void* to, const void* from, uint64_t bytes) { transfer(to, from, bytes, cudaMemcpyHostToDevice); }
  void download(void* to, const void* from, uint64_t bytes) {
    download_async(to, from, bytes);
    wait();
  }
  void download_async(void* to, const void* from, uint64_t bytes) { transfer(to, from, bytes, cudaMemcpyDeviceToHost); }
  void wait() { check_cuda(cudaStreamSynchronize(stream_), "wait"); }
  /// Pinned.
  std::byte* host_memory(uint64_t bytes) {
    host_.ensure(bytes);
    return host_.data();
  }
  /// Pinned.
  std::shared_ptr<std::byte> host_block(uint64_t bytes) const { return pinned_block(device_, bytes); }
  void copy(void* to, const void* from, uint64_t bytes) { transfer(to, from, bytes, cudaMemcpyDeviceToDevice); }
  void fill_zero(void* memory, uint64_t bytes) {
    if (bytes == 0) return;
    begin_now();
    put_in_line("fill_zero", [&] { return cudaMemsetAsync(memory, 0, bytes, stream_); });
  }

  /// The second goes to a stream of its own. There is one scratch memory, which is the first's.
  template <class F, class G>
  void concurrently(const F& f, const G& g) {
    if (!graphs_.is_recording()) {
      f();
      g();
      return;
    }
    const SideStreams::Fork side(*sides_);
    check_cuda(cudaEventRecord(side->fork, stream_), "fork");
    check_cuda(cudaStreamWaitEvent(side->stream, side->fork), "fork");
    StepGraph& graph = graphs_.recording();
    const size_t before = graph.stages();
    f();
    begin_now();
    const size_t first_of_g = graph.stages();
    {
      const ForNow<cudaStream_t> on_side(stream_, side->stream);
      g();
      begin_now();
      if (graph.stages() > first_of_g) end_stage_now(graph.stages() - 1);
      check_cuda(cudaEventRecord(side->join, stream_), "join");
    }
    if (graph.stages() > first_of_g && first_of_g > before) end_stage_now(first_of_g - 1);
    check_cuda(cudaStreamWaitEvent(stream_, side->join), "join");
  }
  /// In a recording this becomes a loop of the graph, which the device ends.
  template <class F>
  void repeat(const uint64_t* again, const F& f) {
    if (reserving_) return f();
    if (!graphs_.is_recording()) {
      do f();
      while (peek(again) != 0);
      return;
    }
    begin_now();
    if (loop_ == nullptr) loop_ = std::make_unique<Loop>();
    record_loop(stream_, loop_->stream, again, [&] {
      const ForNow<cudaStream_t> stream(stream_, loop_->stream);
      const ForNow<SideStreams*> sides(sides_, &loop_->sides);
      f();
    });
  }

  /// Within a step its name, and the time it begins at, become part of the recording.
  template <class F>
  void stage(const char* name, const F& f) {
    const NvtxRange range(name);
    if (graphs_.is_recording()) {
      note_next(graphs_.recording().begin_stage(name));
      f();
      return;
    }
    if (reserving_) return f();
    asks().ask();
    in_parts_ ? stage_events_.time_in_line(name, stream_, f) : stage_events_.time(name, f);
  }
  void make_current() { use_device(device_); }
  void begin_frame() {
    make_current();
    stage_events_.begin_frame();
    allocations_ = 0;
    graph_launches_ = 0;
    step_milliseconds_ = 0;
  }
  template <class F>
  auto frame(const F& f) {
    const NvtxRange range("frame");
    begin_frame();
    try {
      return f();
    } catch (...) {
      turn_to_record_.reset();         // others wait for it
      cudaStreamSynchronize(stream_);  // what is in line may use memory that is given back next
      throw;
    }
  }
  std::vector<StageTime> stage_times() {
    if (stage_events_.are_in_line()) wait();
    return stage_events_.all();
  }

  // For kernels of others.

  /// The next kernel in line; it notes when the stage that it is the first of begins.
  template <class... Parameters, class... Arguments>
  void launch(const char* name, void (*kernel)(uint64_t*, Parameters...), unsigned blocks, unsigned block,
              const Arguments&... arguments) {
    put_in_line(name, [&] {
      kernel<<<blocks, block, 0, stream_>>>(std::exchange(begin_, nullptr), arguments...);
      return cudaGetLastError();
    });
  }
  static unsigned blocks_for(uint64_t n, unsigned block) {
    return static_cast<unsigned>(std::min<uint64_t>((n + block - 1) / block, 1u << 30));
  }
  /// As many as the device holds at once.
  template <class Kernel>
  unsigned resident_blocks(const char* name, Kernel* kernel, unsigned block) const {
    int resident = 0;
    check_cuda(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&resident, kernel, static_cast<int>(block), 0), name);
    return static_cast<unsigned>(std::max(resident, 1)) * processors_;
  }
  const uint32_t* stop() const { return stop_.on_device(); }

  Asks& asks() { return loops_.asks; }
  CpuLoops& host_loops() { return loops_; }

 private:
  static constexpr unsigned kBlock = 256;
  /// Holds the streams that loops are recorded on.
  struct Loop {
    CudaStream stream;
    SideStreams sides;
  };

  /// Goes through a step for its memory alone.
  template <class F>
  void reserve(const F& enqueue) {
    const ForNow reserving(reserving_, true);
    enqueue();
  }
  /// All work goes to the device through here, so that a step can be gone through for its memory alone.
  template <class Call>
  void put_in_line(const char* name, const Call& call) {
    if (!reserving_) check_cuda(call(), name);
  }
  /// For what cannot note by itself when its stage begins.
  void begin_now() {
    if (begin_ != nullptr) launch("time", note_time_kernel, 1, 1);
  }
  /// A time that the next kernel begins at, and one that is passed before it.
  void note_next(size_t time) {
    begin_now();
    begin_ = times_.data() + time;
  }
  void note_now(size_t time) {
    note_next(time);
    begin_now();
  }
  /// Notes the end of a recorded stage, unless a fork within it has done so.
  void end_stage_now(size_t stage) {
    StepGraph& graph = graphs_.recording();
    if (!graph.has_end(stage)) note_now(graph.end_stage(stage));
  }

  /// Calls a CUB function with the memory that it asks for.
  template <class Call>
  void with_scratch(const char* name, const Call& call) {
    size_t bytes = 0;
    check_cuda(call(nullptr, bytes), name);
    scratch_.ensure(bytes);
    begin_now();
    put_in_line(name, [&] { return call(scratch_.data(), bytes); });
  }
  void transfer(void* to, const void* from, uint64_t bytes, cudaMemcpyKind kind) {
    if (bytes != 0) put_in_line("copy", [&] { return cudaMemcpyAsync(to, from, bytes, kind, stream_); });
  }

  int device_;
  unsigned processors_ = 1;
  DeviceInfo info_;
  DeviceMemory memory_;
  CpuLoops loops_;
  CudaStream own_stream_;  ///< which outlives all buffers
  cudaStream_t stream_ = own_stream_;
  SideStreams own_sides_;
  SideStreams* sides_ = &own_sides_;
  std::unique_ptr<Loop> loop_;
  cudaEvent_t fork_ = make_event(), join_ = make_event();
  uint64_t generation_ = 0;  ///< of the buffers: changes whenever one does
  StepGraphs graphs_;
  std::optional<RecordingTurn> turn_to_record_;
  bool reserving_ = false;  ///< a step is gone through for its memory alone
  bool in_parts_ = false;   ///< a step by parts is in line
  Buffer<char, CudaExec> scratch_;
  Buffer<unsigned, CudaExec> arrived_;  ///< of a reduction's blocks
  Buffer<uint64_t, CudaExec> times_;    ///< at which the stages of a recorded step begin and end
  uint64_t* begin_ = nullptr;           ///< where the next kernel notes when it begins
  PinnedMemory pinned_{memory_.ledger()};
  Buffer<std::byte, PinnedMemory> host_{pinned_, "downloads"};
  StopWord stop_{memory_, pinned_};
  StepAnswer answer_{pinned_};
  StageEvents stage_events_;
  double step_milliseconds_ = 0;
  uint32_t allocations_ = 0, graph_launches_ = 0;
};

static_assert(Executor<CudaExec>);

}  // namespace collided
