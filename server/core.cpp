// What serves scenes and calls, whichever way they come in.
#include "server/core.hpp"

#include <stdexcept>

#include "gpu/detector.hpp"

namespace collided::server {
namespace {

const Config& checked(const Config& config) {
  if (config.backend == "cuda" && !cuda_available())
    throw std::runtime_error("--backend is cuda, but there is no usable CUDA device");
  return config;
}

}  // namespace

Core::Core(const Config& config, Lifecycle& lifecycle)
    : authenticator(checked(config)),
      observer(metrics, lifecycle),
      host(config, observer),
      service(config, host, authenticator) {}

void Core::add_to(grpc::ServerBuilder& builder) {
  service.add_to(router);
  builder.RegisterService(&service);
  builder.RegisterCallbackGenericService(&router);
}

}  // namespace collided::server
