#pragma once
// What was built: version, commit, compiler, CUDA; and the gRPC that is loaded.

#include <string>

namespace collided {

/// What `program` prints for --version: "PROGRAM VERSION", then a line each for commit, build, CUDA and gRPC; no
/// newline at the end.
std::string version_text(const std::string& program);

}  // namespace collided
