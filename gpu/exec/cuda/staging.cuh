#pragma once
// Bytes on their way to a GPU, on a stream of their own, beside the frame in work. They are checked on the device: what
// the host reads may be memory that others still change.

#include <cuda_runtime.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "gpu/exec/buffer.hpp"
#include "gpu/exec/cpu/staging.hpp"
#include "gpu/exec/cuda/cuda_memory.cuh"
#include "gpu/exec/cuda/nvtx.cuh"

namespace collided {

constexpr unsigned kCheckBlock = 256;

template <class Check>
__global__ void __launch_bounds__(kCheckBlock) check_kernel(uint64_t n, Check check, uint64_t* first_bad) {
  const uint64_t stride = static_cast<uint64_t>(gridDim.x) * blockDim.x;
  for (uint64_t i = static_cast<uint64_t>(blockIdx.x) * blockDim.x + threadIdx.x; i < n; i += stride)
    check(i, first_bad);
}

/// On a stream of its own.
class CudaStaging {
 public:
  CudaStaging(int device, std::shared_ptr<MemoryLedger> ledger)
      : device_(use_device(device)), memory_(device, std::move(ledger)) {
    verdicts_.allocate(1);
  }
  CudaStaging(const CudaStaging&) = delete;
  CudaStaging& operator=(const CudaStaging&) = delete;
  ~CudaStaging() {
    cudaSetDevice(device_);
    cudaStreamSynchronize(stream_);
    cudaEventSynchronize(placed_);
  }

  /// Pinned.
  std::span<std::byte> room(uint64_t bytes) {
    use_device(device_);  // the calling thread may be a new one
    if (bytes > room_.capacity()) wait_idle();
    room_.ensure(bytes);
    return {room_.data(), room_.capacity()};
  }

  /// The device reads the sources after this call, but for memory that it cannot read, which is copied here.
  std::vector<const std::byte*> bring(const std::vector<Source>& sources, uint64_t alignment) {
    const NvtxRange range("send");
    use_device(device_);
    wait_idle();
    const uint64_t bytes = lay_out(sources, alignment);
    arrival_.ensure(bytes);
    spill(alignment);
    copy_pieces();
    std::vector<const std::byte*> places;
    for (const Piece& piece : pieces_) places.push_back(piece.bytes == 0 ? nullptr : arrival_.data() + piece.offset);
    return places;
  }

  /// Nothing is to be done for a table that is there already.
  template <class T>
  const T* bring(const std::vector<T>& table) {
    const uint64_t bytes = table.size() * sizeof(T);
    if (bytes == 0) return nullptr;
    if (bytes != table_bytes_ || std::memcmp(table_room_.data(), table.data(), bytes) != 0) {
      table_bytes_ = 0;
      table_.ensure(bytes);
      table_room_.ensure(bytes);
      std::memcpy(table_room_.data(), table.data(), bytes);
      copy(table_.data(), table_room_.data(), bytes);
      table_bytes_ = bytes;
    }
    return reinterpret_cast<const T*>(table_.data());
  }

  /// A verdict is rare, so that the device writes it to the host's memory: no copy for frames without one.
  template <class Check>
  void check(uint64_t n, uint64_t verdicts, const Check& check) {
    constexpr uint64_t kMaxBlocks = 2048;
    in_line_ = true;
    verdicts_.ensure(verdicts);
    verdict_count_ = verdicts;
    std::fill_n(verdicts_.data(), verdicts, kNoBadPlace);
    if (n != 0) {
      const unsigned blocks = static_cast<unsigned>(std::min(kMaxBlocks, (n + kCheckBlock - 1) / kCheckBlock));
      check_kernel<<<blocks, kCheckBlock, 0, stream_>>>(n, check, verdicts_.data());
      check_cuda(cudaGetLastError(), "check of positions");
    }
    check_cuda(cudaEventRecord(arrived_, stream_), "check of positions");
  }

  std::span<const uint64_t> first_bad() {
    const NvtxRange range("arrive");
    check_cuda(cudaEventSynchronize(arrived_), "arrival of positions");
    in_line_ = false;
    return {verdicts_.data(), verdict_count_};
  }

  template <class T>
  T read(const T* place) {
    T value;
    copy(&value, place, sizeof(T));
    check_cuda(cudaStreamSynchronize(stream_), "arrival of positions");
    return value;
  }

  /// What is in line on the scene's stream is the last that reads what was brought.
  void read_last_by(cudaStream_t stream) { check_cuda(cudaEventRecord(placed_, stream), "placing of positions"); }

 private:
  struct Piece {
    const std::byte* from;
    uint64_t bytes, offset;
    bool is_pageable, is_own;  ///< is_own: in room() or spilled, where neighbours are copied as one
  };

  /// Waits until nothing of the last frame's is in use.
  void wait_idle() {
    if (in_line_) check_cuda(cudaStreamSynchronize(stream_), "arrival of positions");
    in_line_ = false;
    check_cuda(cudaEventSynchronize(placed_), "placing of positions");
  }

  static bool is_pageable(const std::byte* memory) {
    cudaPointerAttributes attributes{};
    if (cudaPointerGetAttributes(&attributes, memory) == cudaSuccess)
      return attributes.type == cudaMemoryTypeUnregistered;
    cudaGetLastError();
    return true;
  }

  /// Decides where each source goes; bytes in all.
  uint64_t lay_out(const std::vector<Source>& sources, uint64_t alignment) {
    pieces_.clear();
    uint64_t end = 0;
    for (const Source& source : sources) {
      const bool in_room = lies_within(source, room_.data(), room_.capacity());
      const bool pageable = !in_room && !source.empty() && is_pageable(source.data());
      const uint64_t offset = aligned(end, alignment);
      pieces_.push_back({source.data(), source.size(), offset, pageable, in_room || pageable});
      if (!source.empty()) end = offset + source.size();
    }
    return end;
  }

  /// Copies what the device cannot read to where it can.
  void spill(uint64_t alignment) {
    uint64_t bytes = 0;
    for (const Piece& piece : pieces_)
      if (piece.is_pageable) bytes = aligned(bytes, alignment) + piece.bytes;
    spill_.ensure(bytes);
    std::byte* next = spill_.data();
    for (Piece& piece : pieces_) {
      if (!piece.is_pageable) continue;
      std::memcpy(next, piece.from, piece.bytes);
      piece.from = next;
      next += aligned(piece.bytes, alignment);
    }
  }

  void copy_pieces() {
    Piece run{};
    const auto put_in_line = [&] { copy(arrival_.data() + run.offset, run.from, run.bytes); };
    for (const Piece& piece : pieces_) {
      if (piece.bytes == 0) continue;
      if (run.is_own && piece.is_own && piece.from == run.from + run.bytes && piece.offset == run.offset + run.bytes) {
        run.bytes += piece.bytes;
        continue;
      }
      put_in_line();
      run = piece;
    }
    put_in_line();
  }

  void copy(void* to, const void* from, uint64_t bytes) {
    if (bytes == 0) return;
    in_line_ = true;
    check_cuda(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDefault, stream_), "copy of positions");
  }

  int device_;
  DeviceMemory memory_;
  PinnedMemory pinned_{memory_.ledger()};
  CudaStream stream_;
  CudaEvent arrived_, placed_;
  Buffer<std::byte, DeviceMemory> arrival_{memory_, "staging"}, table_{memory_, "staging"};
  Buffer<std::byte, PinnedMemory> room_{pinned_, "staging"}, spill_{pinned_, "staging"},
      table_room_{pinned_, "staging"};
  Buffer<uint64_t, PinnedMemory> verdicts_{pinned_, "staging"};
  uint64_t verdict_count_ = 1;
  uint64_t table_bytes_ = 0;  ///< of the table that is there
  bool in_line_ = false;      ///< something may be, on the stream
  std::vector<Piece> pieces_;
};

static_assert(Memory<DeviceMemory> && Memory<PinnedMemory> && StagingRoom<CudaStaging>);

}  // namespace collided
