#pragma once
// A server in this process as a client's daemon.

#include "client/cpp/transport/in_process.hpp"
#include "server/in_process.hpp"

namespace collided::client {

class DaemonHere final : public InProcess, public std::enable_shared_from_this<DaemonHere> {
 public:
  /// Throws the server's exceptions.
  explicit DaemonHere(const server::InProcessOptions& options) : server_(options) {}
  std::shared_ptr<grpc::Channel> channel(const grpc::ChannelArguments& arguments) const override {
    return server_.channel(arguments);
  }
  std::unique_ptr<FrameTransport> transport() const override;
  server::InProcessServer& server() const { return server_; }

 private:
  mutable server::InProcessServer server_;  // safe from any thread
};

}  // namespace collided::client
