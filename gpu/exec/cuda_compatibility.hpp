#pragma once
// Which CUDA devices this build can use. The rule reads facts that the runtime reports and calls no CUDA, so that it is
// tested without a GPU.

#include <compare>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace collided {

/// A compute capability: 9.0 is {9, 0}.
struct Capability {
  int major = 0, minor = 0;

  friend auto operator<=>(const Capability&, const Capability&) = default;
};

std::string to_string(Capability capability);

/// An architecture that the kernels were compiled for.
struct Architecture {
  enum class Scope {
    kLater,   ///< "90": code for later minors of the major, PTX for all later capabilities
    kFamily,  ///< "100f": code and PTX for later minors of the major
    kAlone,   ///< "90a": this capability alone
  };
  Capability capability = {};
  Scope scope = Scope::kLater;
  bool has_code = true, has_ptx = true;
};

/// Parses architectures as CMAKE_CUDA_ARCHITECTURES names them, with commas in between: "75,80-real,120-virtual".
/// Throws std::invalid_argument.
std::vector<Architecture> parse_architectures(std::string_view list);

/// What the runtime reports of the machine. Versions as CUDA writes them: 13000 is 13.0.
struct CudaMachine {
  int runtime = 0;          ///< the toolkit that this build was made with
  int driver = 0;           ///< the newest CUDA that the driver supports; 0: there is no driver
  bool has_module = false;  ///< the driver's kernel module is loaded
  bool has_devices = true;
  std::string error = {};     ///< why devices cannot be counted, in CUDA's words; empty if they can
  bool ignores_code = false;  ///< CUDA_FORCE_PTX_JIT=1
  bool ignores_ptx = false;   ///< CUDA_DISABLE_PTX_JIT=1
};

enum class Kernels { kNone, kCode, kPtx };

/// Returns the kernels that a device of this capability runs: code, if there is any for it, else PTX.
Kernels kernels_for(Capability device, std::span<const Architecture> built, const CudaMachine& machine);

/// Returns why no CUDA device of the machine can be used, and what would help; empty if there is no such reason.
std::string machine_obstacle(const CudaMachine& machine);

/// True if that reason is no fault: the machine has no GPU, or no driver of one.
bool is_absent(const CudaMachine& machine);

/// Returns why a device of this capability cannot be used on a machine without an obstacle; empty if it can.
std::string device_obstacle(Capability device, std::span<const Architecture> built, const CudaMachine& machine);

}  // namespace collided
