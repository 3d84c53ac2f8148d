#pragma once
// Answers one request of gRPC's reflection.

#include <string>
#include <vector>

#include "grpc/reflection/v1/reflection.pb.h"

namespace collided::server {

/// From the built-in descriptors. `services`: full names of those that are served. The answer to an unknown name is an
/// error (NOT_FOUND), and so is that to an empty request (INVALID_ARGUMENT).
grpc::reflection::v1::ServerReflectionResponse answer_reflection(
    const grpc::reflection::v1::ServerReflectionRequest& request, const std::vector<std::string>& services);

}  // namespace collided::server
