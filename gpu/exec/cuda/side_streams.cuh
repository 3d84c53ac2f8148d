#pragma once
// Streams beside the main one, on which recordings have what runs side by side. No work is ever in line on them
// otherwise.

#include <cuda_runtime.h>

#include <cstddef>
#include <memory>
#include <vector>

#include "gpu/exec/cuda/cuda_memory.cuh"

namespace collided {

class SideStreams {
 public:
  struct Side {
    CudaStream stream;
    CudaEvent fork, join;
  };

  /// While it lives, its side is taken. A fork within a fork has another side than all within the outermost one: on the
  /// same stream one would wait for the other.
  class Fork {
   public:
    explicit Fork(SideStreams& sides) : sides_(sides), side_(sides.take()) {}
    Fork(const Fork&) = delete;
    Fork& operator=(const Fork&) = delete;
    ~Fork() {
      if (--sides_.depth_ == 0) sides_.taken_ = 0;
    }
    const Side* operator->() const { return &side_; }

   private:
    SideStreams& sides_;
    const Side& side_;
  };

 private:
  const Side& take() {
    if (taken_ == sides_.size()) sides_.push_back(std::make_unique<Side>());
    ++depth_;
    return *sides_[taken_++];
  }

  std::vector<std::unique_ptr<Side>> sides_;
  size_t taken_ = 0, depth_ = 0;
};

}  // namespace collided
