// Callers' threads may flush subnormal numbers, round otherwise, or trap: no result changes, and their environment
// stays.

#if defined(__x86_64__) || defined(__aarch64__)  // elsewhere the bits have other places
#ifdef __x86_64__
#include <immintrin.h>
#endif

#include <cfenv>

#include "tests/gpu/backend.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

#ifdef __x86_64__
constexpr unsigned kFlush = 0x8040;  // subnormal results to zero, and subnormal inputs

unsigned control() {
  constexpr unsigned kRaised = 0x3f;
  return _mm_getcsr() & ~kRaised;
}
void set_control(unsigned bits) { _mm_setcsr(bits); }
#else
constexpr unsigned kFlush = 1u << 24;  // subnormal results and inputs to zero

unsigned control() { return __builtin_aarch64_get_fpcr(); }  // what was raised is in another register
void set_control(unsigned bits) { __builtin_aarch64_set_fpcr(bits); }
#endif

struct Environment {
  const char* name;
  bool (*set)();  ///< false: this processor has none such
};
void PrintTo(const Environment& environment, std::ostream* out) { *out << environment.name; }

class FloatEnvironment : public OnBackend<testing::TestWithParam<Environment>> {
 protected:
  void TearDown() override { std::fesetenv(FE_DFL_ENV); }
};

TEST_P(FloatEnvironment, OfTheCallerChangesNothing) {
  const Case subnormal = rounded(soup(320, 60, 1e-40, 5e-41, 3e-41), Scalar::kF32);
  const Frame frame(subnormal, Mode::kCcd, Scalar::kF32);
  for (const size_t parts : {0, 3}) {
    SceneSpec spec = spec_for(subnormal, settings(Mode::kCcd, Accuracy::kExact, Scalar::kF32));
    spec.part_devices.assign(parts, spec.device);
    const FrameResult expected = Detector::create(spec)->detect(frame.input());
    if (!GetParam().set()) GTEST_SKIP() << "this processor has no traps";
    const unsigned before = control();
    const auto detector = Detector::create(spec);
    const FrameResult found = detector->detect(frame.input());
    const unsigned after = control();
    std::fesetenv(FE_DFL_ENV);
    EXPECT_EQ(after, before);
    EXPECT_NE(before, control()) << "nothing was set";
    EXPECT_TRUE(expected.any_contact);
    EXPECT_TRUE(same_contacts(found, expected));
  }
}

bool flush() {
  set_control(control() | kFlush);
  return true;
}
bool round_upward() { return std::fesetround(FE_UPWARD) == 0; }
bool trap() { return feenableexcept(FE_ALL_EXCEPT) != -1; }  // most processors of arm64 cannot

INSTANTIATE_TEST_SUITE_P(Of, FloatEnvironment,
                         testing::Values(Environment{"flush", flush}, Environment{"upward", round_upward},
                                         Environment{"traps", trap}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace collided::test
#endif
