#pragma once
// A unary call as raw messages. It is served as what it is on the wire, a stream of one message each way.

#include <utility>

#include "collided/v1/collision_service.pb.h"
#include "server/transport/grpc/request_call.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// The call without the types of its messages.
class UnaryCallBase : public RequestCall {
 public:
  using RequestCall::finish;
  /// Ends the call with its response. It may be gone afterwards. Throws std::bad_alloc, and LimitExceeded if untaken
  /// answers leave no room: then the call stays open.
  void finish();

 protected:
  using RequestCall::RequestCall;

 private:
  virtual const google::protobuf::Message& response_message() const = 0;
  virtual void forget_messages() = 0;
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
