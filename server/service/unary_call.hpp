#pragma once
// A unary call as raw messages. On the wire it is a stream of one message each way, and that is how it is served: the
// caller is identified on its metadata, before its message is read, and the message is bounded before it is parsed.

#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/grpcpp.h>

#include <memory>
#include <utility>

#include "collided/v1/collision_service.pb.h"
#include "server/convert/decode_budget.hpp"
#include "server/scenes/scene_host.hpp"
#include "server/service/caller.hpp"
#include "server/service/status.hpp"
#include "server/service/waiting_calls.hpp"

namespace collided::server {

/// What all calls work with. Outlives them.
struct CallParts {
  const Authenticator& authenticator;
  const SceneHost& host;
  DecodeBudget& budget;
  WaitingCalls& waiting;
  uint64_t max_message_bytes = 0;
};

/// Throws LimitExceeded that names the option.
void check_message_size(uint64_t bytes, uint64_t most);

/// Parses a message whose fields have been bounded and paid for; the result is its share of the budget. Throws
/// InvalidInput for bytes that are no such message, LimitExceeded.
std::shared_ptr<void> parse_bounded(const grpc::ByteBuffer& bytes, const Client& client, const CallParts& parts,
                                    google::protobuf::Message& message);

grpc::ByteBuffer to_bytes(const google::protobuf::Message& message);

/// The call without the types of its messages. Deletes itself at its end.
class UnaryCallBase : public grpc::ServerGenericBidiReactor {
 public:
  UnaryCallBase(const UnaryCallBase&) = delete;
  UnaryCallBase& operator=(const UnaryCallBase&) = delete;

  const Caller& caller() const { return caller_; }
  bool is_cancelled() const { return context_.IsCancelled(); }
  /// Ends the call, with the response or without. It may be gone afterwards. Throws std::bad_alloc, and LimitExceeded
  /// where answers that are not taken leave no room: the call is there then.
  void finish();
  void finish(const grpc::Status& status) { Finish(status); }

  void OnReadDone(bool ok) override;
  void OnDone() override { delete this; }

 protected:
  UnaryCallBase(grpc::CallbackServerContext& context, const CallParts& parts) : context_(context), parts_(parts) {}
  ~UnaryCallBase() override = default;
  /// Refuses, or reads the message.
  void begin();

 private:
  virtual google::protobuf::Message& request_message() = 0;
  virtual const google::protobuf::Message& response_message() const = 0;
  virtual void forget_messages() = 0;
  virtual void answer() = 0;
  void await_message();

  grpc::CallbackServerContext& context_;
  const CallParts& parts_;
  Caller caller_;
  std::unique_ptr<WaitingCalls::Wait> message_;  // until it has come
  std::shared_ptr<void> share_;                  // of the budget, for what follows
  grpc::ByteBuffer bytes_;                       // of the request, then of the response
};

template <class Request, class Response>
class UnaryCall : public UnaryCallBase {
 public:
  Request& request() { return request_; }
  Response& response() { return response_; }

 protected:
  using UnaryCallBase::UnaryCallBase;

 private:
  google::protobuf::Message& request_message() final { return request_; }
  const google::protobuf::Message& response_message() const final { return response_; }
  void forget_messages() final {
    request_ = {};
    response_ = {};
  }

  Request request_;
  Response response_;
};

/// Runs a body and ends the call with what it throws.
template <class Body>
void guard(UnaryCallBase& call, const Body& body) {
  try {
    body();
  } catch (...) {
    call.finish(to_status(describe_current()));
  }
}

/// Answers a call with `body`, a function of UnaryCall<Request, Response>& which ends it, now or later, or throws.
template <class Request, class Response, class Body>
grpc::ServerGenericBidiReactor* serve_unary(grpc::CallbackServerContext& context, const CallParts& parts, Body body) {
  class Served final : public UnaryCall<Request, Response> {
   public:
    Served(grpc::CallbackServerContext& context, const CallParts& parts, Body body)
        : UnaryCall<Request, Response>(context, parts), body_(std::move(body)) {
      this->begin();
    }

   private:
    void answer() override { body_(*this); }
    const Body body_;
  };
  return new Served(context, parts, std::move(body));
}

}  // namespace collided::server
