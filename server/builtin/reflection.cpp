// gRPC's reflection.
#include "server/builtin/reflection.hpp"

#include <atomic>
#include <utility>

#include "grpc/reflection/v1alpha/reflection.pb.h"
#include "server/builtin/reflection_answer.hpp"
#include "server/errors.hpp"
#include "server/refusals/status.hpp"

namespace collided::server {

namespace rpc = grpc::reflection::v1;  // v1alpha has the same messages on the wire

namespace {

constexpr size_t kMaxCalls = 64, kMaxCallsOfClient = 8;  // calls at once
constexpr uint64_t kMaxRequestBytes = 64 << 10;

void check_request(uint64_t bytes) {
  if (bytes > kMaxRequestBytes)
    throw LimitExceeded("", fmt::format("the request has {} bytes, more than {}", bytes, kMaxRequestBytes));
}

Client client_of(const grpc::CallbackServerContext& context, const Authenticator& authenticator, bool is_open) {
  if (is_open) return std::make_shared<const ClientIdentity>();
  return identify(context, authenticator).client;
}

}  // namespace

/// Reads a request, writes its answer, and so on. One of the two is always pending.
class ReflectionCall final : public grpc::ServerGenericBidiReactor {
 public:
  ReflectionCall(grpc::CallbackServerContext& context, const Reflection& reflection)
      : context_(context),
        reflection_(reflection),
        client_(client_of(context, reflection.calls_.authenticator, reflection.is_open_)) {
    read();
  }

  void OnReadDone(bool ok) override {
    if (!wait_->finish()) return;  // the call has been ended
    if (!ok) return Finish(grpc::Status::OK);
    try {
      bytes_ = to_bytes(answer());
      write();
    } catch (...) {
      Finish(to_status(describe_current()));
    }
  }

  void OnWriteDone(bool ok) override {
    if (!wait_->finish()) return end_late();
    if (!ok) return Finish(grpc::Status(grpc::StatusCode::CANCELLED, "the client is gone"));
    try {
      read();
    } catch (...) {
      Finish(to_status(describe_current()));
    }
  }

  void OnDone() override { delete this; }

 private:
  void wait(const char* what, WaitingCalls::End end) {
    const WaitRule rule{what, reflection_.calls_.host.limits().max_silent_seconds, kMaxCalls, kMaxCallsOfClient};
    wait_ = reflection_.calls_.waiting.wait(rule, client_, std::move(end));
  }

  void read() {
    wait("a reflection request", [this](const auto& why) { Finish(to_status(describe(why))); });
    StartRead(&bytes_);
  }

  void write() {
    wait("a client to take its reflection answer", [this](const auto&) {
      context_.TryCancel();
      end_late();
    });
    StartWrite(&bytes_);
  }

  // Called twice: when the write has failed, and by the wait that cancelled it. The second time ends the call.
  void end_late() {
    if (++left_ == 2) Finish(grpc::Status(grpc::StatusCode::CANCELLED, "the client did not take its answer"));
  }

  rpc::ServerReflectionResponse answer() {
    check_request(bytes_.Length());
    rpc::ServerReflectionRequest request;
    parse_bounded(bytes_, client_, reflection_.calls_, request);
    return answer_reflection(request, reflection_.services_);
  }

  grpc::CallbackServerContext& context_;
  const Reflection& reflection_;
  const Client client_;
  grpc::ByteBuffer bytes_;  // of the request, then of the answer
  std::unique_ptr<WaitingCalls::Wait> wait_;
  std::atomic<int> left_ = 0;
};

void Reflection::add_to(RpcRouter& router, std::vector<std::string> services) {
  services_ = std::move(services);
  for (const auto* request :
       {rpc::ServerReflectionRequest::descriptor(), grpc::reflection::v1alpha::ServerReflectionRequest::descriptor()}) {
    const std::string& name = request->file()->service(0)->full_name();
    services_.push_back(name);
    router.add("/" + name + "/ServerReflectionInfo",
               [this](grpc::GenericCallbackServerContext& context) -> grpc::ServerGenericBidiReactor* {
                 return new ReflectionCall(context, *this);
               });
  }
}

}  // namespace collided::server
