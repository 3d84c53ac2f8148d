// Which CUDA devices a build can use: NVIDIA's rules of compatibility as tables of cases.
#include "gpu/exec/cuda_compatibility.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

namespace collided {
namespace {

const std::vector<Architecture> kRelease = parse_architectures("75,80-real,90-real,100-real,120");
const CudaMachine kNewMachine{.runtime = 13000, .driver = 13000};

TEST(Compatibility, ArchitecturesAreReadAsCMakeNamesThem) {
  const auto parsed = parse_architectures("75,80-real,90a-virtual,100f,121");
  ASSERT_EQ(parsed.size(), 5u);
  EXPECT_EQ(parsed[0].capability, (Capability{7, 5}));
  EXPECT_TRUE(parsed[0].has_code && parsed[0].has_ptx);
  EXPECT_EQ(parsed[1].capability, (Capability{8, 0}));
  EXPECT_TRUE(parsed[1].has_code && !parsed[1].has_ptx);
  EXPECT_EQ(parsed[2].scope, Architecture::Scope::kAlone);
  EXPECT_TRUE(!parsed[2].has_code && parsed[2].has_ptx);
  EXPECT_EQ(parsed[3].capability, (Capability{10, 0}));
  EXPECT_EQ(parsed[3].scope, Architecture::Scope::kFamily);
  EXPECT_EQ(parsed[4].capability, (Capability{12, 1}));
  for (const char* list : {"", "90,", "sm_90", "9", "90b", "90-code", "native", "90;75"})
    EXPECT_THROW(parse_architectures(list), std::invalid_argument) << list;
}

struct KernelsCase {
  Capability device;
  const char* built;
  Kernels expected;
};

TEST(Compatibility, KernelsFollowNvidiasRules) {
  const KernelsCase cases[] = {
      {{9, 0}, "90", Kernels::kCode},
      {{8, 9}, "90", Kernels::kNone},         // an RTX 4090 with Hopper's build
      {{7, 5}, "90", Kernels::kNone},         // neither code nor PTX of later ones
      {{10, 0}, "90", Kernels::kPtx},         // another major
      {{12, 0}, "90-real", Kernels::kNone},   // code alone
      {{9, 0}, "90-virtual", Kernels::kPtx},  // PTX alone
      {{8, 6}, "80-real", Kernels::kCode},    // a later minor
      {{8, 9}, "80-real", Kernels::kCode},
      {{8, 0}, "86-real", Kernels::kNone},  // an earlier minor
      {{8, 0}, "86", Kernels::kNone},
      {{8, 6}, "90-real,80-real", Kernels::kCode},  // in any order
      {{8, 7}, "80-real", Kernels::kNone},          // Orin runs no code of other Ampere chips
      {{8, 7}, "80", Kernels::kPtx},
      {{8, 9}, "87-real", Kernels::kNone},  // nor they Orin's
      {{8, 7}, "87-real", Kernels::kCode},
      {{9, 0}, "90a", Kernels::kCode},
      {{10, 0}, "90a", Kernels::kNone},  // features of that chip alone
      {{10, 0}, "90a-virtual", Kernels::kNone},
      {{10, 3}, "100f", Kernels::kCode},
      {{10, 3}, "100f-virtual", Kernels::kPtx},
      {{12, 0}, "100f", Kernels::kNone},
      {{10, 0}, "103f", Kernels::kNone},
  };
  for (const auto& [device, built, expected] : cases)
    EXPECT_EQ(kernels_for(device, parse_architectures(built), kNewMachine), expected)
        << to_string(device) << " with " << built;
}

TEST(Compatibility, AReleaseHasCodeForEachGenerationAndPtxForTheRest) {
  for (const Capability device : {Capability{7, 5}, {8, 0}, {8, 6}, {8, 9}, {9, 0}, {10, 0}, {10, 3}, {12, 0}, {12, 1}})
    EXPECT_EQ(kernels_for(device, kRelease, kNewMachine), Kernels::kCode) << to_string(device);
  for (const Capability device : {Capability{8, 7}, {11, 0}, {13, 0}})
    EXPECT_EQ(kernels_for(device, kRelease, kNewMachine), Kernels::kPtx) << to_string(device);
  for (const Capability device : {Capability{5, 2}, {6, 1}, {7, 0}, {7, 2}})
    EXPECT_EQ(kernels_for(device, kRelease, kNewMachine), Kernels::kNone) << to_string(device);
}

TEST(Compatibility, CudasVariablesTakeCodeOrPtxAway) {
  const CudaMachine ptx_alone{.runtime = 13000, .driver = 13000, .ignores_code = true};
  const CudaMachine code_alone{.runtime = 13000, .driver = 13000, .ignores_ptx = true};
  EXPECT_EQ(kernels_for({9, 0}, kRelease, ptx_alone), Kernels::kPtx);
  EXPECT_EQ(kernels_for({9, 0}, parse_architectures("90-real"), ptx_alone), Kernels::kNone);
  EXPECT_EQ(kernels_for({9, 0}, kRelease, code_alone), Kernels::kCode);
  EXPECT_EQ(kernels_for({11, 0}, kRelease, code_alone), Kernels::kNone);
  EXPECT_NE(device_obstacle({11, 0}, kRelease, code_alone).find("CUDA_DISABLE_PTX_JIT"), std::string::npos);
}

struct MachineCase {
  CudaMachine machine;
  const char* expected;  ///< a part of the reason; empty: there is none
  bool is_absent;
};

TEST(Compatibility, OfDriverAndRuntimeTheMajorsCount) {
  const char* const kTooOld = "CUDA driver version is insufficient for CUDA runtime version";
  const MachineCase cases[] = {
      {{.runtime = 13000, .driver = 13000}, "", false},
      {{.runtime = 13000, .driver = 13020}, "", false},
      {{.runtime = 13010, .driver = 13000}, "", false},  // the same major, an older minor
      {{.runtime = 12080, .driver = 13000}, "", false},
      {{.runtime = 13000, .driver = 12090, .has_devices = false, .error = kTooOld},
       "supports CUDA 12.9, and this build needs CUDA 13; install driver R580 or later",
       false},
      {{.runtime = 12080, .driver = 11080, .has_devices = false, .error = kTooOld}, "R525", false},
      {{.runtime = 14000, .driver = 13000, .has_devices = false, .error = kTooOld}, "one of CUDA 14", false},
      {{.runtime = 13000, .driver = 0, .has_module = true, .has_devices = false, .error = kTooOld},
       "libcuda.so.1 cannot be used: either the driver is too old, and driver R580 or later helps",
       false},
      {{.runtime = 13000, .driver = 0, .has_devices = false, .error = kTooOld}, "has no NVIDIA driver", true},
      {{.runtime = 13000, .driver = 13000, .has_devices = false}, "no NVIDIA GPU", true},
      {{.runtime = 13000, .driver = 13000, .has_devices = false, .error = "system not yet initialized"},
       "CUDA cannot start: system not yet initialized",
       false},
  };
  for (const auto& [machine, expected, absent] : cases) {
    const std::string obstacle = machine_obstacle(machine);
    EXPECT_EQ(obstacle.empty(), *expected == '\0') << obstacle;
    EXPECT_NE(obstacle.find(expected), std::string::npos) << obstacle;
    EXPECT_EQ(is_absent(machine), absent) << obstacle;
  }
}

TEST(Compatibility, PtxNeedsADriverThatIsAsNewAsItsToolkit) {
  const CudaMachine older{.runtime = 13010, .driver = 13000};
  EXPECT_EQ(device_obstacle({9, 0}, kRelease, older), "");
  EXPECT_EQ(device_obstacle({11, 0}, kRelease, kNewMachine), "");
  EXPECT_EQ(
      device_obstacle({11, 0}, kRelease, older),
      "the NVIDIA driver is too old: this build has no code for compute capability 11.0, only PTX, which a driver "
      "of CUDA 13.1 or later compiles, and this one supports CUDA 13.0");
}

TEST(Compatibility, AMissingArchitectureIsNamed) {
  EXPECT_EQ(device_obstacle({8, 9}, parse_architectures("90"), kNewMachine),
            "this build has no kernels for compute capability 8.9, only for 9.0; a build with "
            "-DCOLLIDED_CUDA_ARCHITECTURES=89 has them, if CUDA 13 supports it");
  EXPECT_NE(
      device_obstacle({6, 1}, kRelease, kNewMachine).find("only for 7.5, 8.0 (code), 9.0 (code), 10.0 (code), 12.0"),
      std::string::npos);
}

}  // namespace
}  // namespace collided
