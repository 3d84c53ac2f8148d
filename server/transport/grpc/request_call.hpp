#pragma once
// A call that begins with one message of its client, as raw messages: the caller is identified by its metadata before
// that message is read, and the message is bounded before it is parsed.

#include <google/protobuf/message.h>
#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/grpcpp.h>

#include <memory>
#include <utility>

#include "server/limits/client_work.hpp"
#include "server/limits/decode_budget.hpp"
#include "server/limits/waiting_calls.hpp"
#include "server/refusals/status.hpp"
#include "server/scenes/scene_host.hpp"
#include "server/transport/grpc/caller.hpp"

namespace collided::server {

/// Shared by all calls; outlives them.
struct CallParts {
  const Authenticator& authenticator;
  const SceneHost& host;
  DecodeBudget& budget;
  WaitingCalls& waiting;
  ClientWork& work;
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

/// Deletes itself when done.
class RequestCall : public grpc::ServerGenericBidiReactor {
 public:
  RequestCall(const RequestCall&) = delete;
  RequestCall& operator=(const RequestCall&) = delete;

  const Caller& caller() const { return caller_; }
  bool is_cancelled() const { return context_.IsCancelled(); }
  /// Ends the call with an error. It may be gone afterwards.
  virtual void finish(const grpc::Status& status) { Finish(status); }

  void OnReadDone(bool ok) override;
  void OnDone() override { delete this; }

 protected:
  RequestCall(grpc::CallbackServerContext& context, const CallParts& parts) : context_(context), parts_(parts) {}
  ~RequestCall() override = default;
  /// Refuses the call, or reads its message.
  void begin();

  grpc::CallbackServerContext& context_;
  const CallParts& parts_;
  std::shared_ptr<void> share_;  // of the budget, for the bytes and messages
  grpc::ByteBuffer bytes_;       // of the request, then of the response

 private:
  virtual google::protobuf::Message& request_message() = 0;
  /// The message has arrived, and it is the client's turn; what this throws ends the call.
  virtual void answer() = 0;
  void await_message();
  void take_message();

  Caller caller_;
  std::unique_ptr<WaitingCalls::Wait> message_;  // until the message has arrived
};

/// Runs a body and ends the call with what it throws.
template <class Body>
void guard(RequestCall& call, const Body& body) {
  try {
    body();
  } catch (...) {
    call.finish(to_status(describe_current()));
  }
}

}  // namespace collided::server
