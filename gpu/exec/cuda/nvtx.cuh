#pragma once
// Names for what the host does, shown by NVIDIA's profilers; costs nothing without one.

#include <nvtx3/nvToolsExt.h>

namespace collided {

class NvtxRange {
 public:
  explicit NvtxRange(const char* name) { nvtxRangePushA(name); }
  NvtxRange(const NvtxRange&) = delete;
  NvtxRange& operator=(const NvtxRange&) = delete;
  ~NvtxRange() { nvtxRangePop(); }
};

}  // namespace collided
