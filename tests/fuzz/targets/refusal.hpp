#pragma once
// What every refusal of a request owes its client.

#include <google/protobuf/stubs/common.h>

#include <string>

#include "server/refusals/status.hpp"
#include "tests/fuzz/targets/fuzz.hpp"

namespace collided::fuzz {

/// Of the exception being handled.
inline void check_refusal() {
  constexpr size_t kMaxMessage = 1024;
  const server::Failure failure = server::describe_current();
  require(failure.code != grpc::StatusCode::INTERNAL && failure.code != grpc::StatusCode::UNKNOWN,
          "a bad request is no internal error: " + failure.message);
  require(!failure.message.empty() && failure.message.size() <= kMaxMessage,
          "a refusal says why, briefly: " + failure.message);
  const auto size = static_cast<int>(failure.message.size());
  require(google::protobuf::internal::IsStructurallyValidUTF8(failure.message.data(), size),
          "a refusal is UTF-8, so that its message can be read: " + failure.message);
}

}  // namespace collided::fuzz
