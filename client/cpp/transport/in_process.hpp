#pragma once
// What a client uses instead of connections where its daemon is in the same process (client/in_process).

#include <grpcpp/channel.h>
#include <grpcpp/support/channel_arguments.h>

#include <memory>

#include "client/cpp/transport/frame_transport.hpp"

namespace collided::client {

/// It lives as long as anything that it has made.
class InProcess {
 public:
  virtual ~InProcess() = default;
  /// For all calls but frame streams.
  virtual std::shared_ptr<grpc::Channel> channel(const grpc::ChannelArguments& arguments) const = 0;
  /// For one stream.
  virtual std::unique_ptr<FrameTransport> transport() const = 0;
};

}  // namespace collided::client
