#pragma once
// Each client's use of the limits that apply across its calls and scenes: open streams, frames per second, bytes on
// devices. No gRPC here.

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "gpu/types.hpp"
#include "server/auth/client.hpp"
#include "server/devices/device_bytes.hpp"
#include "server/ops/clock.hpp"

namespace collided::server {

class ClientUsage {
 public:
  explicit ClientUsage(const Limits& limits, Now now = Clock::now)
      : now_(std::move(now)),
        max_streams_(limits.max_streams),
        device_bytes_(std::make_shared<DeviceBytes>("daemon", "max_device_bytes", limits.max_device_bytes)) {}

  /// Counts a stream while the result lives. `takes_over`: the place of one that ends as soon as this one is open, so
  /// that a client that has used up its limit can resume. Throws LimitExceeded.
  std::shared_ptr<void> begin_stream(const Client& client, bool takes_over = false);
  /// Counts a frame against a token bucket that holds one second's frames. Throws LimitExceeded with the time until the
  /// frame would be admitted.
  void count_frame(const Client& client);
  /// The quota that the client's scenes share, within the daemon's.
  std::shared_ptr<DeviceBytes> device_bytes(const Client& client);
  /// What its scenes needed, for those that come.
  std::shared_ptr<KnownLengths> known_lengths(const Client& client);
  /// Bytes that all scenes hold.
  uint64_t held_device_bytes() const { return device_bytes_->held(); }
  size_t streams() const;
  /// Applies to new requests.
  void set_limits(const Limits& limits);

 private:
  /// A token bucket; `filled` is when it was last refilled.
  struct Bucket {
    double frames = 0;
    Clock::time_point filled;
  };
  struct Entry {
    size_t streams = 0;
    std::optional<Bucket> bucket;  // none before the first frame
    std::shared_ptr<DeviceBytes> device_bytes;
    std::shared_ptr<KnownLengths> known_lengths = std::make_shared<KnownLengths>();
  };

  void end_stream(const std::string& name);

  const Now now_;
  mutable std::mutex mutex_;
  size_t max_streams_;
  size_t streams_ = 0;
  const std::shared_ptr<DeviceBytes> device_bytes_;  // of all clients
  std::map<std::string, Entry> clients_;
};

}  // namespace collided::server
