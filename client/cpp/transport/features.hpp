#pragma once
// Finds what an older daemon does not know: it would ignore a field, and answer another question.

#include <google/protobuf/message.h>

#include <string>

#include "collided/v1/collision_service.pb.h"
#include "proto/additions.hpp"

namespace collided::client {

/// Holds what a protocol has gained since release 0.1.0 (proto/additions.hpp) and a daemon lacks; usually nothing.
class Features {
 public:
  /// `additions` are those of this library's own protocol, except in tests.
  Features(const v1::GetServerInfoResponse& info, const std::string& address,
           v1::Additions additions = v1::additions_of(*v1::GetServerInfoResponse::descriptor()->file()));
  /// Throws Error (UNIMPLEMENTED), naming field, release and daemon, if the daemon would ignore something of a message,
  /// whose path in a request is `path`.
  void check(const google::protobuf::Message& message, const std::string& path = "") const;
  /// The same of a call's request, and of the method that takes it.
  void check_call(const google::protobuf::Message& request) const;
  /// True if the daemon does not know a field, enum value or method, by its full name.
  bool lack(const std::string& name) const { return missing_.contains(name); }

 private:
  void check_fields(const google::protobuf::Message& message, const std::string& path) const;
  void require(const std::string& name, const std::string& what) const;

  std::string daemon_;
  v1::Additions missing_;
};

}  // namespace collided::client
