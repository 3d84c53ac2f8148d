#pragma once
// Connections to one address with its credentials, or to a daemon in this process, and the metadata of calls.

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <grpcpp/security/credentials.h>

#include <memory>
#include <string>

#include "client/cpp/connect_options.hpp"
#include "client/cpp/transport/in_process.hpp"
#include "proto/constants.hpp"

namespace collided::client {

class ChannelFactory {
 public:
  /// Reads the files. Throws Error (INVALID_ARGUMENT) for an address as check_address() does, options that contradict
  /// each other, a file that cannot be read or holds no PEM of its kind, or a token that would go to another host in
  /// plain text.
  ChannelFactory(std::string address, ConnectOptions options);
  /// To a daemon in this process, which needs no credentials. Throws Error (INVALID_ARGUMENT) for options that it
  /// cannot have.
  ChannelFactory(std::shared_ptr<const InProcess> daemon, ConnectOptions options);
  /// The same with other options: files are read again.
  ChannelFactory with(ConnectOptions options) const;

  /// Empty in this process.
  const std::string& address() const { return address_; }
  /// Null for a daemon elsewhere.
  const std::shared_ptr<const InProcess>& in_process() const { return in_process_; }
  const ConnectOptions& options() const { return options_; }
  /// A channel with its own connection, not yet connected. Not in this process.
  std::shared_ptr<grpc::Channel> make(uint64_t max_answer_bytes = v1::kMaxAnswerBytes) const;
  /// A connected one, whose answers have so many bytes at most. Throws Error (UNAVAILABLE) after options().patience.
  std::shared_ptr<grpc::Channel> connect(uint64_t max_answer_bytes = v1::kMaxAnswerBytes) const;
  /// Has the token and, for a call about a scene, the metadata `scene-id`, by which proxies find its daemon.
  std::unique_ptr<grpc::ClientContext> context(const std::string& scene_id = "") const;
  /// The same with a deadline, of which the options' own one is the most.
  std::unique_ptr<grpc::ClientContext> context_within(const std::string& scene_id,
                                                      std::chrono::milliseconds time) const;
  /// The same with a deadline: that of the options plus `more`.
  std::unique_ptr<grpc::ClientContext> call_context(const std::string& scene_id = "",
                                                    std::chrono::milliseconds more = {}) const;

 private:
  std::shared_ptr<const InProcess> in_process_;
  std::string address_;
  ConnectOptions options_;
  std::shared_ptr<grpc::ChannelCredentials> credentials_;
};

}  // namespace collided::client
