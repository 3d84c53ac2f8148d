// gRPC's health service.
#include "server/builtin/health.hpp"

#include <grpcpp/support/proto_buffer_reader.h>

#include <memory>
#include <optional>
#include <utility>

#include "server/errors.hpp"
#include "server/refusals/status.hpp"
#include "server/shorten.hpp"

namespace collided::server {

namespace rpc = grpc::health::v1;

namespace {

constexpr size_t kMaxSilent = 1024, kMaxSilentOfSource = 256;  // that have sent no request yet
constexpr size_t kMaxWatches = 1024, kMaxWatchesOfSource = 64;
constexpr double kForever = 1e9;  // seconds
constexpr uint64_t kMaxRequestBytes = 4 << 10;

std::string parse_request(const grpc::ByteBuffer& bytes) {
  if (bytes.Length() > kMaxRequestBytes)
    throw LimitExceeded("", fmt::format("the request has {} bytes, more than {}", bytes.Length(), kMaxRequestBytes));
  grpc::ByteBuffer copy(bytes);  // copies references only
  grpc::ProtoBufferReader reader(&copy);
  rpc::HealthCheckRequest request;
  if (!request.ParseFromZeroCopyStream(&reader))
    throw InvalidInput("HealthCheckRequest", "HealthCheckRequest is malformed: its bytes are not such a message");
  return request.service();
}

grpc::ByteBuffer answer_of(rpc::HealthCheckResponse::ServingStatus status) {
  rpc::HealthCheckResponse response;
  response.set_status(status);
  return to_bytes(response);
}

}  // namespace

/// Check: waits for its request and answers it. Watch: then also reports every change.
class HealthCall final : public grpc::ServerGenericBidiReactor {
 public:
  HealthCall(grpc::CallbackServerContext& context, Health& health, bool is_watch)
      : context_(context), health_(health), is_watch_(is_watch), source_(source_of(context.peer())) {
    const WaitRule rule{"the health request", health.calls_.host.limits().max_silent_seconds, kMaxSilent,
                        kMaxSilentOfSource, source_};
    request_wait_ = wait(rule, [this](const auto& why) { Finish(to_status(describe(why))); });
    StartRead(&bytes_);
  }

  void OnReadDone(bool ok) override {
    if (!request_wait_->finish()) return;  // the call has been ended
    request_wait_.reset();
    try {
      if (!ok) throw InvalidInput("request", "request is missing: the call had no message");
      service_ = parse_request(bytes_);
      is_watch_ ? watch() : check();
    } catch (...) {
      Finish(to_status(describe_current()));
    }
  }

  void OnWriteDone(bool ok) override {
    const std::lock_guard lock(mutex_);
    is_writing_ = false;
    if (!ok && !end_) end_ = gone();
    write_or_end_locked();
  }

  void OnCancel() override { end(gone()); }

  void OnDone() override {
    health_.leave(*this);
    delete this;
  }

  /// The status may have changed.
  void update() {
    const std::lock_guard lock(mutex_);
    write_or_end_locked();
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
    const WaitRule rule{"a change of health", kForever, kMaxWatches, kMaxWatchesOfSource, source_};
    auto place = wait(rule, [this](const auto& why) { evict(to_status(describe(why))); });
    health_.join(*this);
    const std::lock_guard lock(mutex_);
    place_ = std::move(place);
    write_or_end_locked();
  }

  void evict(const grpc::Status& status) {
    const std::lock_guard lock(mutex_);
    is_evicted_ = true;
    end_locked(status);
  }

  void end(const grpc::Status& status) {
    const std::lock_guard lock(mutex_);
    end_locked(status);
  }

  void end_locked(const grpc::Status& status) {
    if (!end_) end_ = status;
    if (is_writing_) context_.TryCancel();  // the pending write may never complete
    write_or_end_locked();
  }

  // Without a place the call still waits for its request, and the end of that wait ends it. The call may be gone once
  // it is finished, so that is left to an eviction that is on its way.
  void write_or_end_locked() {
    if (!place_ || is_writing_ || is_over_) return;
    if (end_) {
      if (!is_evicted_ && !place_->finish()) return;
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
  std::unique_ptr<WaitingCalls::Wait> request_wait_;
  std::string service_;     // set by the request
  grpc::ByteBuffer bytes_;  // of the request, then of the answer

  std::mutex mutex_;                           // guards what follows
  std::unique_ptr<WaitingCalls::Wait> place_;  // among the watchers
  std::optional<rpc::HealthCheckResponse::ServingStatus> told_;
  std::optional<grpc::Status> end_;
  bool is_writing_ = false, is_evicted_ = false, is_over_ = false;
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
  for (HealthCall* call : watches_) call->update();
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
