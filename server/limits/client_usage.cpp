// Each client's use of the limits that apply across its calls and scenes.
#include "server/limits/client_usage.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "server/errors.hpp"

namespace collided::server {

std::shared_ptr<void> ClientUsage::begin_stream(const Client& client, bool takes_over) {
  const size_t ending = takes_over ? 1 : 0;
  const std::lock_guard lock(mutex_);
  if (streams_ >= max_streams_ + ending)
    throw LimitExceeded::quota(
        "daemon", fmt::format("max_streams is {}, and {} streams are open on this daemon", max_streams_, streams_));
  Entry& entry = clients_[client->name];
  if (entry.streams >= client->limits.max_streams + ending)
    throw LimitExceeded::quota("client:" + client->name,
                               fmt::format("max_streams_per_client is {}, and client \"{}\" has {} open streams",
                                           client->limits.max_streams, client->name, entry.streams));
  std::shared_ptr<void> ticket(nullptr, [this, name = client->name](void*) { end_stream(name); });
  ++entry.streams;
  ++streams_;
  return ticket;
}

void ClientUsage::end_stream(const std::string& name) {
  const std::lock_guard lock(mutex_);
  --clients_[name].streams;
  --streams_;
}

void ClientUsage::count_frame(const Client& client) {
  const double rate = client->limits.max_frames_per_second, max = std::max(1.0, rate);
  const std::lock_guard lock(mutex_);
  auto& bucket = clients_[client->name].bucket;
  const auto now = now_();
  const double frames = bucket ? bucket->frames + seconds_between(bucket->filled, now) * rate : max;
  bucket = {std::min(max, frames), now};
  if (bucket->frames < 1)
    throw LimitExceeded::quota(
        "client:" + client->name,
        fmt::format("max_frames_per_second is {}, and client \"{}\" sent more", rate, client->name),
        (1 - bucket->frames) / rate);
  bucket->frames -= 1;
}

size_t ClientUsage::streams() const {
  const std::lock_guard lock(mutex_);
  return streams_;
}

std::shared_ptr<DeviceBytes> ClientUsage::device_bytes(const Client& client) {
  const uint64_t max = client->limits.max_device_bytes;
  const std::lock_guard lock(mutex_);
  auto& bytes = clients_[client->name].device_bytes;
  if (!bytes)
    bytes = std::make_shared<DeviceBytes>("client:" + client->name, "max_device_bytes_per_client", max, device_bytes_);
  bytes->set_max(max);
  return bytes;
}

std::shared_ptr<KnownLengths> ClientUsage::known_lengths(const Client& client) {
  const std::lock_guard lock(mutex_);
  return clients_[client->name].known_lengths;
}

void ClientUsage::set_limits(const Limits& limits) {
  device_bytes_->set_max(limits.max_device_bytes);
  const std::lock_guard lock(mutex_);
  max_streams_ = limits.max_streams;
}

}  // namespace collided::server
