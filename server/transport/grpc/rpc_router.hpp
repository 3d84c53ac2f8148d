#pragma once
// Routes a call by its path, before any of its messages is read.

#include <grpcpp/generic/async_generic_service.h>

#include <functional>
#include <map>
#include <string>

namespace collided::server {

/// For all methods except those with their own completion queue or handler.
class RpcRouter final : public grpc::CallbackGenericService {
 public:
  using Open = std::function<grpc::ServerGenericBidiReactor*(grpc::GenericCallbackServerContext&)>;

  /// Before the server is built. `path`: "/package.Service/Method".
  void add(std::string path, Open open) { methods_.emplace(std::move(path), std::move(open)); }
  grpc::ServerGenericBidiReactor* CreateReactor(grpc::GenericCallbackServerContext* context) override;

 private:
  std::map<std::string, Open, std::less<>> methods_;
};

/// Ends a call at once with the exception that is being handled.
grpc::ServerGenericBidiReactor* refuse_call();

}  // namespace collided::server
