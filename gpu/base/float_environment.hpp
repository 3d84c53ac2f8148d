#pragma once
// The floating-point environment that all proofs assume: rounding to nearest, subnormal numbers kept, no traps.

#include <cfenv>

namespace collided {

/// Sets it for the thread, and gives the thread its own back at the end. Threads started meanwhile inherit it. Callers
/// may have another: -ffast-math flushes subnormal numbers, and simulators trap NaN to find where it comes from.
class DefaultFloatEnvironment {
 public:
  DefaultFloatEnvironment() {
    std::fegetenv(&callers_);
    std::fesetenv(FE_DFL_ENV);
  }
  DefaultFloatEnvironment(const DefaultFloatEnvironment&) = delete;
  DefaultFloatEnvironment& operator=(const DefaultFloatEnvironment&) = delete;
  ~DefaultFloatEnvironment() { std::fesetenv(&callers_); }

 private:
  std::fenv_t callers_;
};

}  // namespace collided
