#pragma once
// What was built: version, commit, compiler, CUDA.

#include <string>

namespace collided {

/// What `program` prints for --version: "PROGRAM VERSION", then a line each for commit, build and CUDA; no newline at
/// the end.
std::string version_text(const std::string& program);

}  // namespace collided
