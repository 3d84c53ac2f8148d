#pragma once
// Bytes on their way to a GPU, on a stream of their own, beside the frame in work. They are checked on the device: what
// the host reads may be memory that others still change. Few bytes are copied to pinned memory that nobody else knows,
// checked there by the host, and read from there by the device: a copy and a check of the device's take longer.

#include <cuda_runtime.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <span>
#include <string>
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

  void follow(void* stream) { followed_ = static_cast<cudaStream_t>(stream); }

  /// The device reads the sources after this call, but for memory that it cannot read, which is copied here.
  std::vector<const std::byte*> bring(const std::vector<Source>& sources, uint64_t alignment) {
    const NvtxRange range("send");
    use_device(device_);
    wait_idle();
    const uint64_t bytes = lay_out(sources, alignment);
    stays_on_host_ = bytes <= kFewBytes && can_host_read_all();
    wait_for_followed();
    if (!stays_on_host_) arrival_.ensure(bytes);
    spill(alignment);
    if (!stays_on_host_) copy_pieces();
    std::vector<const std::byte*> places;
    for (const Piece& piece : pieces_) places.push_back(piece.bytes == 0 ? nullptr : place_of(piece));
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
  void check(uint64_t n, uint64_t verdicts, const Check& check, const Check& on_host) {
    constexpr uint64_t kMaxBlocks = 2048;
    verdicts_.ensure(verdicts);
    verdict_count_ = verdicts;
    std::fill_n(verdicts_.data(), verdicts, kNoBadPlace);
    if (stays_on_host_) {
      check_on_host(n, {verdicts_.data(), verdicts}, on_host);
    } else if (n != 0) {
      in_line_ = true;
      const unsigned blocks = static_cast<unsigned>(std::min(kMaxBlocks, (n + kCheckBlock - 1) / kCheckBlock));
      check_kernel<<<blocks, kCheckBlock, 0, stream_>>>(n, check, verdicts_.data());
      check_cuda(cudaGetLastError(), "check of positions");
    }
    if (in_line_) check_cuda(cudaEventRecord(arrived_, stream_), "check of positions");
  }

  std::span<const uint64_t> first_bad() {
    const NvtxRange range("arrive");
    if (in_line_) check_cuda(cudaEventSynchronize(arrived_), "arrival of positions");
    in_line_ = false;
    return {verdicts_.data(), verdict_count_};
  }

  template <class T>
  T read(const T* place) {
    if (stays_on_host_) return *place;
    T value;
    copy(&value, place, sizeof(T));
    check_cuda(cudaStreamSynchronize(stream_), "arrival of positions");
    return value;
  }

  /// What is in line on the scene's stream is the last that reads what was brought.
  void read_last_by(cudaStream_t stream) { check_cuda(cudaEventRecord(placed_, stream), "placing of positions"); }

 private:
  static constexpr uint64_t kFewBytes = 64 << 10;

  struct Piece {
    const std::byte* from;
    uint64_t bytes, offset;
    cudaMemoryType type;
    bool is_own;  ///< in room() or spilled, where neighbours are copied as one
  };

  /// Waits until nothing of the last frame's is in use.
  void wait_idle() {
    if (in_line_) check_cuda(cudaStreamSynchronize(stream_), "arrival of positions");
    in_line_ = false;
    check_cuda(cudaEventSynchronize(placed_), "placing of positions");
  }

  /// The device waits where it alone reads the sources.
  void wait_for_followed() {
    if (followed_ == nullptr) return;
    record_followed();
    if (std::any_of(pieces_.begin(), pieces_.end(), [&](const Piece& piece) { return must_spill(piece); })) {
      check_cuda(cudaEventSynchronize(written_), "stream");
    } else {
      check_cuda(cudaStreamWaitEvent(stream_, written_), "stream");
      in_line_ = true;  // so that first_bad() waits for it, and with it whatever comes after that
    }
  }

  void record_followed() {
    cudaStreamCaptureStatus capture = cudaStreamCaptureStatusNone;
    cudaError_t error = cudaStreamIsCapturing(followed_, &capture);
    if (capture != cudaStreamCaptureStatusNone)
      throw InvalidInput("stream", "stream is being captured, and a frame cannot be part of a graph");
    if (error == cudaSuccess) error = cudaEventRecord(written_, followed_);
    if (error == cudaSuccess) return;
    cudaGetLastError();
    throw InvalidInput("stream", "stream cannot be waited for on cuda:" + std::to_string(device_) +
                                     ", where the scene is: " + cudaGetErrorString(error));
  }

  static cudaMemoryType type_of(const std::byte* memory) {
    cudaPointerAttributes attributes{};
    if (cudaPointerGetAttributes(&attributes, memory) == cudaSuccess) return attributes.type;
    cudaGetLastError();
    return cudaMemoryTypeUnregistered;
  }
  bool can_host_read_all() const {
    return std::all_of(pieces_.begin(), pieces_.end(), [](const Piece& piece) {
      return piece.type == cudaMemoryTypeUnregistered || piece.type == cudaMemoryTypeHost;
    });
  }
  const std::byte* place_of(const Piece& piece) const {
    return stays_on_host_ ? piece.from : arrival_.data() + piece.offset;
  }

  /// Decides where each source goes; bytes in all.
  uint64_t lay_out(const std::vector<Source>& sources, uint64_t alignment) {
    pieces_.clear();
    uint64_t end = 0;
    for (const Source& source : sources) {
      const bool in_room = source.empty() || lies_within(source, room_.data(), room_.capacity());
      const cudaMemoryType type = in_room ? cudaMemoryTypeHost : type_of(source.data());
      const uint64_t offset = aligned(end, alignment);
      pieces_.push_back({source.data(), source.size(), offset, type, in_room});
      if (!source.empty()) end = offset + source.size();
    }
    return end;
  }

  /// Whether the device is to read a copy of it.
  bool must_spill(const Piece& piece) const { return stays_on_host_ || piece.type == cudaMemoryTypeUnregistered; }
  void spill(uint64_t alignment) {
    uint64_t bytes = 0;
    for (const Piece& piece : pieces_)
      if (must_spill(piece)) bytes = aligned(bytes, alignment) + piece.bytes;
    spill_.ensure(bytes);
    std::byte* next = spill_.data();
    for (Piece& piece : pieces_) {
      if (!must_spill(piece)) continue;
      std::memcpy(next, piece.from, piece.bytes);
      piece.from = next;
      piece.is_own = true;
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
  CudaEvent arrived_, placed_, written_;
  cudaStream_t followed_ = nullptr;
  Buffer<std::byte, DeviceMemory> arrival_{memory_, "staging"}, table_{memory_, "staging"};
  Buffer<std::byte, PinnedMemory> room_{pinned_, "staging"}, spill_{pinned_, "staging"},
      table_room_{pinned_, "staging"};
  Buffer<uint64_t, PinnedMemory> verdicts_{pinned_, "staging"};
  uint64_t verdict_count_ = 1;
  uint64_t table_bytes_ = 0;    ///< of the table that is there
  bool in_line_ = false;        ///< something may be, on the stream
  bool stays_on_host_ = false;  ///< what was brought
  std::vector<Piece> pieces_;
};

static_assert(Memory<DeviceMemory> && Memory<PinnedMemory> && StagingRoom<CudaStaging>);

}  // namespace collided
