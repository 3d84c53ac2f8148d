#pragma once
// A unary call as raw messages. It is served as what it is on the wire, a stream of one message each way: the caller is
// identified by its metadata before its message is read, and the message is bounded before it is parsed.

#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/grpcpp.h>

#include <memory>
#include <utility>

#include "collided/v1/collision_service.pb.h"
#include "server/convert/status.hpp"
#include "server/limits/decode_budget.hpp"
#include "server/limits/waiting_calls.hpp"
#include "server/scenes/scene_host.hpp"
#include "server/transport/grpc/caller.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// Shared by all calls; outlives them.
struct CallParts {
  const Authenticator& authenticator;
  const SceneHost& host;
  DecodeBudget& budget;
  WaitingCalls& waiting;
  uint64_t max_message_bytes = 0;
};

/// Memory for all decoded messages together: `max_decode_bytes`, but never less than the largest messages of two
/// clients need.
uint64_t decode_budget_bytes(const Limits& limits);

/// Throws LimitExceeded, naming the option.
void check_message_size(uint64_t bytes, uint64_t max);

/// Bounds the fields of a message, reserves its share of the budget, and parses it. Returns the share. Throws
/// InvalidInput for malformed bytes, LimitExceeded.
std::shared_ptr<void> parse_bounded(const grpc::ByteBuffer& bytes, const Client& client, const CallParts& parts,
                                    google::protobuf::Message& message);

grpc::ByteBuffer to_bytes(const google::protobuf::Message& message);

/// The call without the types of its messages. Deletes itself when done.
class UnaryCallBase : public grpc::ServerGenericBidiReactor {
 public:
  UnaryCallBase(const UnaryCallBase&) = delete;
  UnaryCallBase& operator=(const UnaryCallBase&) = delete;

  const Caller& caller() const { return caller_; }
  bool is_cancelled() const { return context_.IsCancelled(); }
  /// Ends the call with its response. It may be gone afterwards. Throws std::bad_alloc, and LimitExceeded if untaken
  /// answers leave no room: then the call stays open.
  void finish();
  /// Ends the call with an error. It may be gone afterwards.
  void finish(const grpc::Status& status) { Finish(status); }

  void OnReadDone(bool ok) override;
  void OnDone() override { delete this; }

 protected:
  UnaryCallBase(grpc::CallbackServerContext& context, const CallParts& parts) : context_(context), parts_(parts) {}
  ~UnaryCallBase() override = default;
  /// Refuses the call, or reads its message.
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
  std::unique_ptr<WaitingCalls::Wait> message_;  // until the message has arrived
  std::shared_ptr<void> share_;                  // of the budget, for the bytes and messages
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

/// Serves a call with `body`, a function of UnaryCall<Request, Response>& that ends it, now or later, or throws.
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
