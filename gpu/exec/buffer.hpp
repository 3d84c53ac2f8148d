#pragma once
// An array that lives in the memory of a backend; it grows with head-room and loses its contents when it does.

#include <string>
#include <utility>

#include "gpu/exec/concepts.hpp"

namespace collided {

template <class T, class Exec>
class Buffer {
 public:
  Buffer(Exec& exec, std::string part) : exec_(&exec), part_(std::move(part)) {}
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  Buffer(Buffer&& other) noexcept
      : exec_(other.exec_),
        part_(other.part_),
        data_(std::exchange(other.data_, nullptr)),
        capacity_(std::exchange(other.capacity_, 0)) {}
  /// What was held here is given back.
  Buffer& operator=(Buffer&& other) noexcept {
    Buffer taken(std::move(other));
    std::swap(part_, taken.part_);
    std::swap(data_, taken.data_);
    std::swap(capacity_, taken.capacity_);
    std::swap(exec_, taken.exec_);
    return *this;
  }
  ~Buffer() { release(); }

  /// Room for exactly `count`, once; for arrays whose size is known for good.
  void allocate(uint64_t count) {
    if (count > capacity_) replace(count);
  }

  /// Room for `count` and a quarter more, so that a slowly growing need rarely allocates.
  void ensure(uint64_t count) {
    if (count > capacity_) replace(count + count / 4 + 64);
  }

  Span<T> span(uint64_t count) const { return {data_, count}; }
  Span<T> all() const { return {data_, capacity_}; }
  T* data() const { return data_; }
  uint64_t capacity() const { return capacity_; }

 private:
  void replace(uint64_t count) {
    static_assert(Memory<Exec> && std::is_trivially_copyable_v<T>, "nothing is constructed, and bytes are copied");
    release();
    data_ = static_cast<T*>(exec_->allocate(part_, count * sizeof(T)));
    capacity_ = count;
  }

  void release() {
    if (data_ != nullptr) exec_->deallocate(part_, data_, capacity_ * sizeof(T));
    data_ = nullptr;
    capacity_ = 0;
  }

  Exec* exec_;
  std::string part_;
  T* data_ = nullptr;
  uint64_t capacity_ = 0;
};

}  // namespace collided
