// Callers' threads may flush subnormal numbers, round otherwise, or trap: no result changes, and their environment
// stays.

#ifdef __x86_64__  // elsewhere the bits have other places
#include <immintrin.h>

#include <cfenv>

#include "tests/gpu/backend.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

constexpr unsigned kFlush = 0x8040;  // subnormal results to zero, and subnormal inputs

struct Environment {
  const char* name;
  void (*set)();
};
void PrintTo(const Environment& environment, std::ostream* out) { *out << environment.name; }

class FloatEnvironment : public OnBackend<testing::TestWithParam<Environment>> {
 protected:
  void TearDown() override { std::fesetenv(FE_DFL_ENV); }
};

unsigned control() {
  constexpr unsigned kRaised = 0x3f;
  return _mm_getcsr() & ~kRaised;
}

TEST_P(FloatEnvironment, OfTheCallerChangesNothing) {
  const Case subnormal = rounded(soup(320, 60, 1e-40, 5e-41, 3e-41), Scalar::kF32);
  const Frame frame(subnormal, Mode::kCcd, Scalar::kF32);
  for (const size_t parts : {0, 3}) {
    SceneSpec spec = spec_for(subnormal, settings(Mode::kCcd, Accuracy::kExact, Scalar::kF32));
    spec.part_devices.assign(parts, spec.device);
    const FrameResult expected = Detector::create(spec)->detect(frame.input());
    GetParam().set();
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

INSTANTIATE_TEST_SUITE_P(Of, FloatEnvironment,
                         testing::Values(Environment{"flush", [] { _mm_setcsr(_mm_getcsr() | kFlush); }},
                                         Environment{"upward", [] { std::fesetround(FE_UPWARD); }},
                                         Environment{"traps", [] { feenableexcept(FE_ALL_EXCEPT); }}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace collided::test
#endif
