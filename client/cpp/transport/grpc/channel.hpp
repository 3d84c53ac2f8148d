#pragma once
// Connections to one address, with its credentials, and what every call on them carries.

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <grpcpp/security/credentials.h>

#include <memory>
#include <string>

#include "client/cpp/connect_options.hpp"

namespace collided::client {

/// Whether what is sent to a gRPC address cannot leave this host: unix:..., localhost or a loopback IP.
bool is_local_address(const std::string& address);

class ChannelMaker {
 public:
  /// Reads the files. Throws Error (INVALID_ARGUMENT) for options that cannot go together, a file that cannot be read,
  /// or a token that would go to another host in plain text.
  ChannelMaker(std::string address, ConnectOptions options);

  const std::string& address() const { return address_; }
  const ConnectOptions& options() const { return options_; }
  /// A connection of its own, not yet tried.
  std::shared_ptr<grpc::Channel> make() const;
  /// Waits for it. Throws Error (UNAVAILABLE) after the patience of the options.
  std::shared_ptr<grpc::Channel> connect() const;
  /// With the token and, for a call about a scene, metadata `scene-id`, by which proxies choose its daemon.
  std::unique_ptr<grpc::ClientContext> context(const std::string& scene_id = "") const;
  /// The same with a deadline: that of the options, and `more`.
  std::unique_ptr<grpc::ClientContext> call_context(const std::string& scene_id = "",
                                                    std::chrono::milliseconds more = {}) const;

 private:
  std::string address_;
  ConnectOptions options_;
  std::shared_ptr<grpc::ChannelCredentials> credentials_;
};

}  // namespace collided::client
