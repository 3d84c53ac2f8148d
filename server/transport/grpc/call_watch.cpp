// Outcomes of calls, as metrics and log lines.
#include "server/transport/grpc/call_watch.hpp"

#include "collided/v1/collision_service.pb.h"
#include "server/ops/log_rate.hpp"
#include "server/refusals/status.hpp"
#include "server/transport/grpc/caller.hpp"

namespace collided::server {

namespace pb = collided::v1;

using grpc::experimental::InterceptionHookPoints;

namespace {

constexpr std::string_view kLogsItself = "WatchScene";  // most watches end long after they were admitted

bool is_served(const std::string& method) {
  static const auto* service = pb::GetSceneRequest::descriptor()->file()->FindServiceByName("CollisionService");
  return service->FindMethodByName(method) || method == "Check" || method == "Watch" ||
         method == "ServerReflectionInfo";
}

// Callers choose the path, so only known methods are counted by name.
std::string method_of(const std::string& path) {
  std::string method = path.substr(path.rfind('/') + 1);
  return is_served(method) ? method : "unknown";
}

}  // namespace

void CallWatch::Intercept(grpc::experimental::InterceptorBatchMethods* methods) {
  if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::POST_RECV_INITIAL_METADATA)) {
    events_.on_accepted(*call_.server_context());
    ids_ = ids_of(*methods->GetRecvInitialMetadata());
  }
  if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::POST_RECV_MESSAGE) && methods->GetRecvMessage())
    has_message_ = true;
  if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS)) ended(methods->GetSendStatus());
  if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::POST_RECV_CLOSE)) gone();
  methods->Proceed();
}

void CallWatch::gone() const {
  if (!has_message_ && call_.server_context()->IsCancelled()) events_.on_abandoned(call_.server_context()->peer());
}

void CallWatch::ended(const grpc::Status& status) const {
  const std::string code = code_name(status.error_code());
  metrics_.count_call(method_, code);
  if (status.ok() || method_ == kLogsItself || !admit_refusal(method_, code)) return;
  log_event(spdlog::level::info, "call refused",
            {{"method", method_},
             {"code", code},
             {"reason", status.error_message()},
             {"request", ids_.request_id},
             {"trace", ids_.trace_id}});
}

grpc::experimental::Interceptor* CallWatches::CreateServerInterceptor(grpc::experimental::ServerRpcInfo* info) {
  const std::string method = method_of(info->method());
  return method == "StreamFrames" ? nullptr : new CallWatch(*info, method, metrics_, events_);
}

}  // namespace collided::server
