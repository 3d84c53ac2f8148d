#pragma once
// What one question of gRPC's reflection is answered with.

#include <string>
#include <vector>

#include "grpc/reflection/v1/reflection.pb.h"

namespace collided::server {

/// From the descriptors that are built in. `services`: full names of those that are served. What is not known is an
/// error within the answer (NOT_FOUND), as is a question that is none (INVALID_ARGUMENT).
grpc::reflection::v1::ServerReflectionResponse answer_reflection(
    const grpc::reflection::v1::ServerReflectionRequest& request, const std::vector<std::string>& services);

}  // namespace collided::server
