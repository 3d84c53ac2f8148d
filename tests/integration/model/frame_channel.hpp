#pragma once
// A stream of frames over either transport.

#include "tests/integration/local/local_daemon.hpp"
#include "tests/integration/support/client_channel.hpp"

namespace collided::test {

/// The ways of a client to the daemon.
struct Client {
  std::string name;
  std::unique_ptr<Stub> stub;
  std::string local_socket;
};

class FrameChannel {
 public:
  FrameChannel(Client& client, bool local, const std::string& scene, const std::string& resume_token = "") {
    if (local)
      local_ = std::make_unique<LocalStream>(client.local_socket, scene,
                                             LocalSizes{.resume_token = resume_token, .token = token_of(client.name)});
    else
      remote_ = std::make_unique<Stream>(*client.stub, scene, 0, resume_token);
  }

  const std::optional<pb::StreamOpened>& opened() const { return local_ ? local_->opened() : remote_->opened(); }
  /// With positions in shared memory, where there is some.
  bool send(const pb::Frame& frame, bool shared) {
    if (!local_) return remote_->send(frame);
    return shared ? local_->send_shared(frame) : local_->raw().send(frame);
  }
  Answer receive(uint64_t id) { return local_ ? local_->receive(id) : remote_->receive(id); }
  /// Says that no more comes, and how the stream ended.
  int close() {
    if (!local_) return remote_->finish().error_code();
    local_->raw().half_close();
    return end();
  }
  /// How the daemon ends the stream by itself.
  int end() {
    if (!local_) return remote_->wait_end().error_code();
    return local_->closed() ? local_->closed()->code() : local_->raw().closed().code();
  }

 private:
  std::unique_ptr<Stream> remote_;
  std::unique_ptr<LocalStream> local_;
};

}  // namespace collided::test
