// What was built. Only the two programs link this, so that a commit rebuilds nothing else.
#include "deploy/version/version.hpp"

#include <grpcpp/grpcpp.h>

#include "commit.hpp"

namespace collided {

std::string version_text(const std::string& program) {
  return program +
         " " COLLIDED_VERSION "\ncommit: " COLLIDED_COMMIT "\nbuild:  " COLLIDED_BUILD "\nCUDA:   " COLLIDED_CUDA
         "\ngRPC:   " +
         grpc::Version();
}

}  // namespace collided
