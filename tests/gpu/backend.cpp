// The backend that this executable tests.
#include "tests/gpu/backend.hpp"

namespace collided::test {

#ifdef COLLIDED_TEST_CUDA
constinit const Backend kBackend = Backend::kCuda;
#else
constinit const Backend kBackend = Backend::kCpu;
#endif

}  // namespace collided::test
