// Routes a call by its path.
#include "server/transport/grpc/rpc_router.hpp"

#include "server/errors.hpp"
#include "server/refusals/status.hpp"
#include "server/shorten.hpp"

namespace collided::server {
namespace {

class Refused final : public grpc::ServerGenericBidiReactor {
 public:
  explicit Refused(const grpc::Status& status) { Finish(status); }
  void OnDone() override { delete this; }
};

}  // namespace

grpc::ServerGenericBidiReactor* refuse_call() { return new Refused(to_status(describe_current())); }

grpc::ServerGenericBidiReactor* RpcRouter::CreateReactor(grpc::GenericCallbackServerContext* context) try {
  const auto method = methods_.find(context->method());
  if (method == methods_.end()) throw Unimplemented("", "no such method is served: " + shorten(context->method(), 128));
  return method->second(*context);
} catch (...) {
  return refuse_call();
}

}  // namespace collided::server
