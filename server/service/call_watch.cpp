// What becomes of each call, as metrics and log lines.
#include "server/service/call_watch.hpp"

#include "server/service/caller.hpp"
#include "server/service/status.hpp"

namespace collided::server {

using grpc::experimental::InterceptionHookPoints;

void CallWatch::Intercept(grpc::experimental::InterceptorBatchMethods* methods) {
  if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::POST_RECV_INITIAL_METADATA))
    ids_ = ids_of(*methods->GetRecvInitialMetadata());
  if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS)) ended(methods->GetSendStatus());
  methods->Proceed();
}

void CallWatch::ended(const grpc::Status& status) const {
  metrics_.count_call(method_, code_name(status.error_code()));
  if (status.ok()) return;
  log_event(spdlog::level::info, "call refused",
            {{"method", method_},
             {"code", code_name(status.error_code())},
             {"reason", status.error_message()},
             {"request", ids_.request_id},
             {"trace", ids_.trace_id}});
}

grpc::experimental::Interceptor* CallWatches::CreateServerInterceptor(grpc::experimental::ServerRpcInfo* info) {
  const std::string_view path = info->method();
  const std::string_view method = path.substr(path.rfind('/') + 1);
  return method == "StreamFrames" ? nullptr : new CallWatch(method, metrics_);
}

}  // namespace collided::server
