#pragma once
// Holds the streams that recordings use beside the main one, for work that runs side by side. Nothing else is put in
// line on them.

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

  /// Takes a side as long as it lives. All forks within an outermost one take different sides, for work on one stream
  /// would wait for the other's.
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
