#pragma once
// The daemon's own refusals; the engine's are in gpu/detector.hpp. status.cpp maps both to gRPC codes.

#include <stdexcept>
#include <string>
#include <utility>

namespace collided::server {

/// A refusal that names a field of the request.
class FieldError : public std::runtime_error {
 public:
  FieldError(std::string field, const std::string& what) : runtime_error(what), field_(std::move(field)) {}
  const std::string& field() const { return field_; }

 private:
  std::string field_;
};

/// The scene does not exist (any more).
class NotFound : public FieldError {
  using FieldError::FieldError;
};

/// The request is sound, but not in the present state.
class FailedPrecondition : public FieldError {
  using FieldError::FieldError;
};

/// A field of the protocol that the daemon does not serve.
class Unimplemented : public FieldError {
  using FieldError::FieldError;
};

/// The request passes a limit of the daemon.
class LimitExceeded : public FieldError {
  using FieldError::FieldError;
};

/// The caller did not show who it is. Never tells what it showed.
class Unauthenticated : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The daemon is about to stop and takes nothing new.
class Stopping : public std::runtime_error {
 public:
  Stopping() : std::runtime_error("the daemon is stopping") {}
};

}  // namespace collided::server
