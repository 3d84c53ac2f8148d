// gRPC's health service.
#include "server/builtin/health.hpp"

#include <grpcpp/support/proto_buffer_reader.h>

#include <memory>
#include <optional>
#include <utility>

#include "server/errors.hpp"
#include "server/service/status.hpp"
#include "server/shorten.hpp"

namespace collided::server {

namespace rpc = grpc::health::v1;

namespace {

constexpr size_t kMostSilent = 1024, kMostSilentOfSource = 256;  // that have not asked yet
constexpr size_t kMostWatches = 1024, kMostWatchesOfSource = 64;
constexpr double kForEver = 1e9;  // seconds
constexpr uint64_t kMaxQuestionBytes = 4 << 10;

std::string parse_question(const grpc::ByteBuffer& bytes) {
  if (bytes.Length() > kMaxQuestionBytes)
    throw LimitExceeded("", fmt::format("the question has {} bytes, more than {}", bytes.Length(), kMaxQuestionBytes));
  grpc::ByteBuffer copy(bytes);  // of references
  grpc::ProtoBufferReader reader(&copy);
  rpc::HealthCheckRequest request;
  if (!request.ParseFromZeroCopyStream(&reader))
    throw InvalidInput("HealthCheckRequest", "HealthCheckRequest is malformed: its bytes are no such message");
  return request.service();
}

grpc::ByteBuffer answer_of(rpc::HealthCheckResponse::ServingStatus status) {
  rpc::HealthCheckResponse response;
  response.set_status(status);
  return to_bytes(response);
}

}  // namespace

/// Check: waits for its question, and answers it. Watch: tells every change after that, too.
class HealthCall final : public grpc::ServerGenericBidiReactor {
 public:
  HealthCall(grpc::CallbackServerContext& context, Health& health, bool is_watch)
      : context_(context), health_(health), is_watch_(is_watch), source_(source_of(context.peer())) {
    const WaitRule rule{"the question about health", health.calls_.host.limits().max_silent_seconds, kMostSilent,
                        kMostSilentOfSource, source_};
    question_ = wait(rule, [this](const auto& why) { Finish(to_status(describe(why))); });
    StartRead(&bytes_);
  }

  void OnReadDone(bool ok) override {
    if (!question_->over()) return;  // the call has been ended
    question_.reset();
    try {
      if (!ok) throw InvalidInput("request", "request is missing: the call brought no message");
      service_ = parse_question(bytes_);
      is_watch_ ? watch() : check();
    } catch (...) {
      Finish(to_status(describe_current()));
    }
  }

  void OnWriteDone(bool ok) override {
    const std::lock_guard lock(mutex_);
    is_writing_ = false;
    if (!ok && !end_) end_ = gone();
    go_on_locked();
  }

  void OnCancel() override { end(gone()); }

  void OnDone() override {
    health_.leave(*this);
    delete this;
  }

  /// The status may have changed.
  void look() {
    const std::lock_guard lock(mutex_);
    go_on_locked();
  }

 private:
  static grpc::Status gone() { return {grpc::StatusCode::CANCELLED, "the client is gone"}; }

  std::unique_ptr<WaitingCalls::Wait> wait(const WaitRule& rule, WaitingCalls::End end) {
    return health_.calls_.waiting.wait(rule, std::make_shared<const ClientIdentity>(), std::move(end));
  }

  void check() {
    const auto status = health_.status_of(service_);
    if (status == rpc::HealthCheckResponse::SERVICE_UNKNOWN)
      throw NotFound("service", "service is \"" + shorten(service_, 128) + "\", which is not served here");
    bytes_ = answer_of(status);
    StartWriteAndFinish(&bytes_, grpc::WriteOptions(), grpc::Status::OK);
  }

  void watch() {
    const WaitRule rule{"a change of health", kForEver, kMostWatches, kMostWatchesOfSource, source_};
    auto place = wait(rule, [this](const auto& why) { end(to_status(describe(why))); });
    health_.join(*this);
    const std::lock_guard lock(mutex_);
    place_ = std::move(place);
    go_on_locked();
  }

  void end(const grpc::Status& status) {
    const std::lock_guard lock(mutex_);
    if (!end_) end_ = status;
    if (is_writing_) context_.TryCancel();  // the answer may never be taken
    go_on_locked();
  }

  // Without its place it still waits for its question, whose end is the call's.
  void go_on_locked() {
    if (!place_ || is_writing_ || is_over_) return;
    if (end_) {
      is_over_ = true;
      return Finish(*end_);
    }
    const auto status = health_.status_of(service_);
    if (status == told_) return;
    told_ = status;
    is_writing_ = true;
    bytes_ = answer_of(status);
    StartWrite(&bytes_);
  }

  grpc::CallbackServerContext& context_;
  Health& health_;
  const bool is_watch_;
  const std::string source_;
  std::unique_ptr<WaitingCalls::Wait> question_;
  std::string service_;     // set by the question
  grpc::ByteBuffer bytes_;  // of the question, then of the answer

  std::mutex mutex_;                           // guards what follows
  std::unique_ptr<WaitingCalls::Wait> place_;  // among those who watch
  std::optional<rpc::HealthCheckResponse::ServingStatus> told_;
  std::optional<grpc::Status> end_;
  bool is_writing_ = false, is_over_ = false;
};

void Health::add_to(RpcRouter& router, std::string service) {
  service_ = std::move(service);
  for (const bool is_watch : {false, true})
    router.add(is_watch ? "/grpc.health.v1.Health/Watch" : "/grpc.health.v1.Health/Check",
               [this, is_watch](grpc::GenericCallbackServerContext& context) -> grpc::ServerGenericBidiReactor* {
                 return new HealthCall(context, *this, is_watch);
               });
}

void Health::set_serving(bool is_serving) {
  is_serving_ = is_serving;
  const std::lock_guard lock(mutex_);
  for (HealthCall* call : watches_) call->look();
}

Health::Status Health::status_of(const std::string& service) const {
  if (!service.empty() && service != service_) return rpc::HealthCheckResponse::SERVICE_UNKNOWN;
  return is_serving_ ? rpc::HealthCheckResponse::SERVING : rpc::HealthCheckResponse::NOT_SERVING;
}

void Health::join(HealthCall& call) {
  const std::lock_guard lock(mutex_);
  watches_.insert(&call);
}

void Health::leave(HealthCall& call) {
  const std::lock_guard lock(mutex_);
  watches_.erase(&call);
}

}  // namespace collided::server
