#pragma once
// Bytes on their way to CPU cores: what others might still change is copied, what is the slot's own is used in place.

#include <cstring>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "gpu/exec/buffer.hpp"
#include "gpu/exec/cpu/host_memory.hpp"

namespace collided {

/// Nothing that a check found wrong.
constexpr uint64_t kNoBadPlace = ~uint64_t{0};

/// Where bytes of `alignment` may begin that come after `offset` others.
constexpr uint64_t aligned(uint64_t offset, uint64_t alignment) {
  return (offset + alignment - 1) / alignment * alignment;
}

/// A span of bytes that lies in `[begin, begin + bytes)` as a whole.
inline bool lies_within(const Source& source, const std::byte* begin, uint64_t bytes) {
  const std::less_equal<const std::byte*> not_after;
  return begin != nullptr && not_after(begin, source.data()) && not_after(source.data() + source.size(), begin + bytes);
}

/// The verdicts of a check on the host.
template <class Check>
void check_on_host(uint64_t n, std::span<uint64_t> first_bad, const Check& check) {
  if (check.is_clean()) return;
  const bool is_one = first_bad.size() == 1;
  for (uint64_t i = 0; i < n && !(is_one && first_bad[0] != kNoBadPlace); ++i) check(i, first_bad.data());
}

/// What is in room() and aligned is used in place, all else is copied.
class HostStaging {
 public:
  explicit HostStaging(std::shared_ptr<MemoryLedger> ledger) : memory_(std::move(ledger)) {}

  std::span<std::byte> room(uint64_t bytes) {
    room_.ensure(bytes);
    return {room_.data(), room_.capacity()};
  }

  /// Does nothing: CPU cores have no streams, and check_frame() refuses them.
  void follow(void*) {}

  std::vector<const std::byte*> bring(const std::vector<Source>& sources, uint64_t alignment) {
    uint64_t bytes = 0;
    for (const Source& source : sources)
      if (!is_in_place(source, alignment)) bytes += aligned(source.size(), alignment);
    arrival_.ensure(bytes);
    std::vector<const std::byte*> places;
    std::byte* next = arrival_.data();
    for (const Source& source : sources) {
      const bool stays = is_in_place(source, alignment);
      places.push_back(source.empty() ? nullptr : stays ? source.data() : next);
      if (stays || source.empty()) continue;
      std::memcpy(next, source.data(), source.size());
      next += aligned(source.size(), alignment);
    }
    return places;
  }

  template <class T>
  const T* bring(const std::vector<T>& table) {
    return table.data();
  }

  template <class Check>
  void check(uint64_t n, uint64_t verdicts, const Check&, const Check& on_host) {
    first_bad_.assign(verdicts, kNoBadPlace);
    check_on_host(n, first_bad_, on_host);
  }

  std::span<const uint64_t> first_bad() const { return first_bad_; }

  template <class T>
  T read(const T* place) const {
    return *place;
  }

 private:
  bool is_in_place(const Source& source, uint64_t alignment) const {
    return lies_within(source, room_.data(), room_.capacity()) &&
           reinterpret_cast<uintptr_t>(source.data()) % alignment == 0;
  }

  HostMemory memory_;
  Buffer<std::byte, HostMemory> room_{memory_, "staging"}, arrival_{memory_, "staging"};
  std::vector<uint64_t> first_bad_;
};

static_assert(Memory<HostMemory> && StagingRoom<HostStaging>);

}  // namespace collided
