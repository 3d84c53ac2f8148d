#pragma once
// Where the programs of a test are, and what they run on.

#include <cstdlib>
#include <string>

namespace collided::test {

/// The environment's value, else the build's: tests can run elsewhere than where they were built, and on a GPU.
inline std::string setting(const char* variable, const char* built) {
  const char* const value = std::getenv(variable);
  return value ? value : built;
}

/// The backend of the daemons that tests start.
inline std::string test_backend() { return setting("COLLIDED_TEST_BACKEND", "cpu"); }

}  // namespace collided::test
