#pragma once
// Answers one request of gRPC's reflection.

#include <string>
#include <vector>

#include "grpc/reflection/v1/reflection.pb.h"

namespace collided::server {

/// From the descriptors that are built in. `services`: full names of those that are served. For an unknown name the
/// answer is an error (NOT_FOUND), as for a request without a question (INVALID_ARGUMENT).
grpc::reflection::v1::ServerReflectionResponse answer_reflection(
    const grpc::reflection::v1::ServerReflectionRequest& request, const std::vector<std::string>& services);

}  // namespace collided::server
