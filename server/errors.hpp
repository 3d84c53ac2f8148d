#pragma once
// The daemon's own refusals; the engine's are in gpu/detector.hpp. convert/status.cpp maps both to gRPC codes.

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

/// The scene does not exist, no longer exists, or belongs to another client.
class NotFound : public FieldError {
  using FieldError::FieldError;
};

/// The request is valid, but not in the current state.
class FailedPrecondition : public FieldError {
  using FieldError::FieldError;
};

/// The id is in use already.
class AlreadyExists : public FieldError {
  using FieldError::FieldError;
};

/// A wrong secret.
class PermissionDenied : public FieldError {
  using FieldError::FieldError;
};

/// Another stream took the scene over.
class TakenOver : public FieldError {
  using FieldError::FieldError;
};

/// The client did not act in time; names a field.
class TimedOut : public FieldError {
  using FieldError::FieldError;
};

/// A part of the protocol that is not served.
class Unimplemented : public FieldError {
  using FieldError::FieldError;
};

/// The request exceeds a limit of the daemon.
class LimitExceeded : public FieldError {
 public:
  using FieldError::FieldError;
  /// A limit that several requests share: `subject` is "client:NAME", "scene:ID", "device:ID" or "daemon"; after
  /// `retry_after_seconds` the same request may succeed (0: waiting alone does not help).
  static LimitExceeded quota(std::string subject, const std::string& what, double retry_after_seconds = 0) {
    LimitExceeded error("", what);
    error.subject_ = std::move(subject);
    error.retry_after_seconds_ = retry_after_seconds;
    return error;
  }
  const std::string& subject() const { return subject_; }
  double retry_after_seconds() const { return retry_after_seconds_; }

 private:
  std::string subject_;
  double retry_after_seconds_ = 0;
};

/// The caller did not prove who it is. Never contains its credentials.
class Unauthenticated : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The client did not act in time.
class DeadlineExceeded : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The daemon is about to stop and accepts nothing new.
class Stopping : public std::runtime_error {
 public:
  Stopping() : std::runtime_error("the daemon is stopping") {}
};

}  // namespace collided::server
