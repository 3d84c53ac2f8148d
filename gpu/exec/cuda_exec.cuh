#pragma once
// The verbs of the engine on a CUDA GPU (CUB). Same meaning as CpuExec, verb by verb.

#include <cuda_runtime.h>
#include <thrust/iterator/counting_iterator.h>

#include <algorithm>
#include <cub/cub.cuh>
#include <functional>
#include <string>
#include <vector>

#include "gpu/exec/atomic.hpp"
#include "gpu/exec/buffer.hpp"
#include "gpu/exec/memory_ledger.hpp"

namespace collided {

inline void check_cuda(cudaError_t error, const char* what) {
  if (error == cudaSuccess) return;
  cudaGetLastError();
  const std::string text = std::string(what) + ": " + cudaGetErrorString(error);
  if (error == cudaErrorMemoryAllocation) throw ResourceExhausted(text);
  throw DeviceError(text);
}

template <class F>
__global__ void for_each_kernel(uint64_t n, F f) {
  const uint64_t stride = static_cast<uint64_t>(gridDim.x) * blockDim.x;
  for (uint64_t i = static_cast<uint64_t>(blockIdx.x) * blockDim.x + threadIdx.x; i < n; i += stride) f(i);
}

/// The item whose units contain `unit`.
__device__ inline uint64_t item_of_unit(Span<const uint64_t> offsets, uint64_t unit) {
  uint64_t low = 0, high = offsets.size() - 1;
  while (high - low > 1) {
    const uint64_t middle = (low + high) / 2;
    if (offsets[middle] <= unit)
      low = middle;
    else
      high = middle;
  }
  return low;
}

template <class F>
__global__ void for_each_expanded_kernel(Span<const uint64_t> offsets, uint64_t total, F f) {
  const uint64_t stride = static_cast<uint64_t>(gridDim.x) * blockDim.x;
  for (uint64_t unit = static_cast<uint64_t>(blockIdx.x) * blockDim.x + threadIdx.x; unit < total; unit += stride) {
    const uint64_t item = item_of_unit(offsets, unit);
    f(item, unit - offsets[item]);
  }
}

struct WriteOwnIndex {
  Span<uint32_t> out;
  __device__ void operator()(uint64_t i) const { out[i] = static_cast<uint32_t>(i); }
};

class CudaExec {
 public:
  CudaExec(int device, uint64_t memory_budget) : device_(device), ledger_(memory_budget), scratch_(*this, "scratch") {
    check_cuda(cudaSetDevice(device), "cudaSetDevice");
    check_cuda(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "cudaStreamCreate");
    cudaDeviceProp properties{};
    check_cuda(cudaGetDeviceProperties(&properties, device), "cudaGetDeviceProperties");
    info_ = {Backend::kCuda, properties.name, properties.totalGlobalMem};
  }
  CudaExec(const CudaExec&) = delete;
  CudaExec& operator=(const CudaExec&) = delete;
  ~CudaExec() {
    for (cudaEvent_t event : events_) cudaEventDestroy(event);
    cudaStreamDestroy(stream_);
  }

  const DeviceInfo& device() const { return info_; }

  void* allocate(const std::string& part, uint64_t bytes) {
    ledger_.take(part, bytes);
    void* memory = nullptr;
    const cudaError_t error = cudaMalloc(&memory, bytes);
    if (error != cudaSuccess) {
      ledger_.give_back(part, bytes);
      check_cuda(error, (part + ": " + std::to_string(bytes) + " bytes").c_str());
    }
    return memory;
  }
  void deallocate(const std::string& part, void* memory, uint64_t bytes) {
    cudaFree(memory);
    ledger_.give_back(part, bytes);
  }
  const MemoryLedger& ledger() const { return ledger_; }

  /// f(i) for i in [0, n).
  template <class F>
  void for_each(const char* name, uint64_t n, const F& f) {
    if (n == 0) return;
    for_each_kernel<<<blocks_for(n), kBlock, 0, stream_>>>(n, f);
    check_cuda(cudaGetLastError(), name);
  }

  /// f(item, rank) for every rank of every item: the paper's workload distribution.
  template <class F>
  void for_each_expanded(const char* name, Span<const uint64_t> offsets, uint64_t total, const F& f) {
    if (total == 0) return;
    for_each_expanded_kernel<<<blocks_for(total), kBlock, 0, stream_>>>(offsets, total, f);
    check_cuda(cudaGetLastError(), name);
  }

  /// op over transform(i), i in [0, n); op must not depend on the order.
  template <class T, class F, class Op>
  T reduce(const char* name, uint64_t n, const F& transform, const T& identity, const Op& op) {
    if (n == 0) return identity;
    const thrust::counting_iterator<uint64_t> indices(0);
    const auto call = [&](void* temporary, size_t& bytes, T* result) {
      return cub::DeviceReduce::TransformReduce(temporary, bytes, indices, result, n, op, transform, identity, stream_);
    };
    size_t bytes = 0;
    check_cuda(call(nullptr, bytes, nullptr), name);
    // The result sits in front of CUB's own storage, which wants 256-byte alignment.
    const uint64_t front = (sizeof(T) + 255) / 256 * 256;
    char* memory = scratch(front + bytes);
    check_cuda(call(memory + front, bytes, reinterpret_cast<T*>(memory)), name);
    return read(reinterpret_cast<const T*>(memory));
  }

  /// In place.
  template <class T>
  void exclusive_scan(const char* name, Span<T> values) {
    size_t bytes = 0;
    check_cuda(cub::DeviceScan::ExclusiveSum(nullptr, bytes, values.data, values.data, values.size(), stream_), name);
    char* memory = scratch(bytes);
    check_cuda(cub::DeviceScan::ExclusiveSum(memory, bytes, values.data, values.data, values.size(), stream_), name);
  }

  /// Ascending, in place.
  void sort(const char* name, Span<uint64_t> keys) {
    if (keys.empty()) return;
    const uint64_t n = keys.size();
    size_t bytes = 0;
    check_cuda(cub::DeviceRadixSort::SortKeys(nullptr, bytes, keys.data, keys.data, n, 0, 64, stream_), name);
    const uint64_t front = (n * sizeof(uint64_t) + 255) / 256 * 256;
    char* memory = scratch(front + bytes);
    auto* sorted = reinterpret_cast<uint64_t*>(memory);
    check_cuda(cub::DeviceRadixSort::SortKeys(memory + front, bytes, keys.data, sorted, n, 0, 64, stream_), name);
    copy(keys.data, sorted, n * sizeof(uint64_t));
  }

  /// order[k] = place of the k-th smallest key; sorts the keys too.
  void sort_with_order(const char* name, Span<uint64_t> keys, Span<uint32_t> order) {
    if (keys.empty()) return;
    const uint64_t n = keys.size();
    size_t bytes = 0;
    check_cuda(cub::DeviceRadixSort::SortPairs(nullptr, bytes, keys.data, keys.data, order.data, order.data, n, 0, 64,
                                               stream_),
               name);
    const uint64_t key_bytes = (n * sizeof(uint64_t) + 255) / 256 * 256;
    const uint64_t order_bytes = (n * sizeof(uint32_t) + 255) / 256 * 256;
    char* memory = scratch(key_bytes + 2 * order_bytes + bytes);
    auto* sorted = reinterpret_cast<uint64_t*>(memory);
    auto* places = reinterpret_cast<uint32_t*>(memory + key_bytes);
    auto* sorted_places = reinterpret_cast<uint32_t*>(memory + key_bytes + order_bytes);
    for_each(name, n, WriteOwnIndex{{places, n}});
    check_cuda(cub::DeviceRadixSort::SortPairs(memory + key_bytes + 2 * order_bytes, bytes, keys.data, sorted, places,
                                               sorted_places, n, 0, 64, stream_),
               name);
    copy(keys.data, sorted, n * sizeof(uint64_t));
    copy(order.data, sorted_places, n * sizeof(uint32_t));
  }

  /// The only verb, with download, that waits for the device.
  template <class T>
  T read(const T* value) {
    T result;
    download(&result, value, sizeof(T));
    return result;
  }
  void upload(void* to, const void* from, uint64_t bytes) { transfer(to, from, bytes, cudaMemcpyHostToDevice); }
  void download(void* to, const void* from, uint64_t bytes) {
    transfer(to, from, bytes, cudaMemcpyDeviceToHost);
    check_cuda(cudaStreamSynchronize(stream_), "download");
  }
  void copy(void* to, const void* from, uint64_t bytes) { transfer(to, from, bytes, cudaMemcpyDeviceToDevice); }
  void fill_zero(void* memory, uint64_t bytes) {
    if (bytes != 0) check_cuda(cudaMemsetAsync(memory, 0, bytes, stream_), "fill_zero");
  }

  /// Runs one stage of the pipeline: cancellation before it, GPU events around it.
  template <class F>
  void stage(const char* name, const F& f) {
    if (cancelled && cancelled()) throw Cancelled();
    const size_t first = 2 * names_.size();
    while (events_.size() < first + 2) {
      cudaEvent_t event;
      check_cuda(cudaEventCreate(&event), "cudaEventCreate");
      events_.push_back(event);
    }
    names_.push_back(name);
    check_cuda(cudaEventRecord(events_[first], stream_), name);
    f();
    check_cuda(cudaEventRecord(events_[first + 1], stream_), name);
  }
  void begin_frame() {
    check_cuda(cudaSetDevice(device_), "cudaSetDevice");  // the calling thread may be a new one
    names_.clear();
  }
  std::vector<StageTime> stage_times() {
    check_cuda(cudaStreamSynchronize(stream_), "end of frame");
    std::vector<StageTime> times;
    for (size_t i = 0; i < names_.size(); ++i) {
      float milliseconds = 0;
      check_cuda(cudaEventElapsedTime(&milliseconds, events_[2 * i], events_[2 * i + 1]), "cudaEventElapsedTime");
      times.push_back({names_[i], milliseconds});
    }
    return times;
  }

  std::function<bool()> cancelled;

 private:
  static constexpr unsigned kBlock = 256;

  static unsigned blocks_for(uint64_t n) {
    return static_cast<unsigned>(std::min<uint64_t>((n + kBlock - 1) / kBlock, 1u << 30));
  }
  char* scratch(uint64_t bytes) {
    scratch_.ensure(bytes);
    return scratch_.data();
  }
  void transfer(void* to, const void* from, uint64_t bytes, cudaMemcpyKind kind) {
    if (bytes != 0) check_cuda(cudaMemcpyAsync(to, from, bytes, kind, stream_), "copy");
  }

  int device_;
  DeviceInfo info_;
  MemoryLedger ledger_;
  cudaStream_t stream_ = nullptr;
  Buffer<char, CudaExec> scratch_;
  std::vector<cudaEvent_t> events_;
  std::vector<const char*> names_;
};

}  // namespace collided
