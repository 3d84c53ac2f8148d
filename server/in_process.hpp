#pragma once
// A server without a network, for callers in its own process. Nothing of the process is changed: no signal handler, no
// logger, no environment, no allocator.

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

#include "server/core.hpp"
#include "server/ops/lifecycle.hpp"
#include "server/ops/log.hpp"
#include "server/transport/in_process/stream.hpp"

namespace collided::server {

struct InProcessOptions {
  std::string backend = "auto";   ///< auto, cpu or cuda
  int threads = 0;                ///< CPU threads of a scene; 0: all cores
  int concurrent_frames = 0;      ///< frames computed at once; 0: 4 to 12 with a GPU, else 2
  uint64_t max_device_bytes = 0;  ///< of all scenes; 0: as derive_limits() has it
};

class InProcessServer {
 public:
  /// Throws InvalidInput for bad options, which it calls `engine` as collided::local() does, FailedPrecondition for
  /// "cuda" without a usable device.
  explicit InProcessServer(const InProcessOptions& options);
  /// Ends streams and calls, and waits for all of its threads. Channels and streams must be gone.
  ~InProcessServer();
  InProcessServer(const InProcessServer&) = delete;
  InProcessServer& operator=(const InProcessServer&) = delete;

  /// Calls go through it, but for StreamFrames, which it does not have.
  std::shared_ptr<grpc::Channel> channel(const grpc::ChannelArguments& arguments) const;
  /// As InProcessStream::open().
  std::shared_ptr<InProcessStream> open(const pb::OpenStream& open);

 private:
  InProcessServer(const Config& config, std::nullptr_t);

  Lifecycle lifecycle_;
  Core core_;
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace collided::server
