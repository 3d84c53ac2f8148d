#pragma once
// A frame stream over the daemon's local socket (collided/v1/local.proto): positions and contacts are in shared memory,
// and only small packets are sent.

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "client/cpp/transport/frame_transport.hpp"
#include "client/cpp/transport/local/local_layout.hpp"
#include "client/cpp/transport/local/local_peer.hpp"
#include "client/cpp/transport/local/local_region.hpp"
#include "collided/v1/local.pb.h"

namespace collided::client {

/// The socket to connect to, and who may listen there.
struct LocalPeer {
  std::string path;
  TrustedUsers trusted;
  std::chrono::milliseconds patience;  ///< to connect
  std::chrono::milliseconds deadline;  ///< until a packet is taken
};

class LocalTransport final : public FrameTransport {
 public:
  /// Connects. Throws Error: UNAVAILABLE if nobody listens there, PERMISSION_DENIED if an untrusted user does.
  LocalTransport(const LocalPeer& peer, const LocalLayout& layout, const std::string& token,
                 const LocalOptions& options);

  bool open(const v1::OpenStream& open) override;
  std::span<std::byte> input(uint64_t bytes) override;
  bool send(const v1::Frame& frame, std::span<const FrameUpdate> updates) override;
  Arrival read(v1::StreamFramesResponse& response, Time deadline) override;
  std::span<const std::byte> shared(const v1::SharedRange& range) const override;
  uint64_t device_output_bytes() const override { return layout_.is_device_output ? layout_.output_bytes : 0; }
  void half_close() override;
  void cancel() override;
  std::optional<Error> finish() override;

 private:
  using Bytes = std::span<const std::byte>;

  std::span<std::byte> take_room(uint64_t bytes);
  std::optional<v1::SharedRange> place(Bytes bytes);
  void add(const FrameUpdate& update, v1::MeshUpdate& out);
  void add(const v1::MeshUpdate& update, v1::MeshUpdate& out);
  v1::SharedRange place_if_long(const v1::Frame& frame);
  bool send_packet(const v1::LocalRequest& request);

  const LocalLayout layout_;
  LocalFd socket_;
  LocalRegion region_;
  v1::LocalOpen opening_;
  v1::LocalRequest outgoing_;  ///< the sender's, reused
  std::string packet_;         ///< the sender's, reused
  std::string incoming_;       ///< the reader's
  uint64_t frames_ = 0;        ///< sent so far; the next one's part of the input follows from it
  uint64_t used_ = 0;          ///< bytes of that part that are taken
  std::chrono::milliseconds deadline_;
  std::atomic<bool> is_cancelled_ = false;
  std::atomic<bool> is_late_ = false;  ///< a packet was not taken in time
  std::optional<v1::LocalClosed> closed_;
};

}  // namespace collided::client
