// The daemon under load.

#include "client/measure/load/daemon/target.hpp"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "client/app/output/progress.hpp"
#include "client/measure/load/daemon/limits.hpp"

namespace collided::cli::load {

Target::Target(const LoadSettings& settings) : address_(settings.server.server) {
  const StreamSettings& streams = settings.streams;
  allow_connections(streams.shares_connections ? streams.clients : streams.count());
  if (!settings.metrics_url.empty()) metrics_ = parse_url("--metrics-url", settings.metrics_url);
  if (address_.empty()) {
    daemon_.emplace(DaemonOptions{.backend = settings.server.backend,
                                  .threads = settings.server.threads,
                                  .streams = streams.count(),
                                  .metrics = true});
    address_ = daemon_->address();
    if (const std::string at = daemon_->metrics_address(); !at.empty()) metrics_ = parse_url("its own daemon", at);
  } else {
    options_ = cli::connect_options(settings.server);
  }
  if (metrics_) http_get(*metrics_);  // an address that is wrong is told before the work
  client_.emplace(client::Client::connect(address_, options_));
  const auto in_the_way = limits_in_the_way(client_->server_info().limits(), streams);
  if (!in_the_way.empty()) throw std::runtime_error(explain(in_the_way));
}

std::vector<std::shared_ptr<const SceneGuard>> Target::create_scenes(const v1::SceneSpec& spec,
                                                                     std::span<const client::MeshInput> meshes,
                                                                     uint32_t count) {
  constexpr double kLeaseSeconds = 600;  // until its stream opens, which takes long where there are many
  const double lease = std::min(kLeaseSeconds, client_->server_info().limits().max_lease_seconds());
  std::vector<std::shared_ptr<const SceneGuard>> scenes;
  Progress progress;
  for (uint32_t i = 0; i < count; ++i) {
    check_interrupt();
    scenes.push_back(
        std::make_shared<const SceneGuard>(*client_, client_->create_scene(spec, meshes, lease), is_own()));
    progress.show("scenes", static_cast<int>(i) + 1, static_cast<int>(count));
  }
  return scenes;
}

/// A frame is counted a moment after its answer has been sent.
std::optional<Samples> Target::samples() const {
  constexpr std::chrono::milliseconds kPause(20);
  constexpr int kTries = 10;
  if (!metrics_) return std::nullopt;
  const auto frames = [](const Samples& samples) {
    const auto at = samples.find("collided_frames_total");
    return at == samples.end() ? 0.0 : at->second;
  };
  Samples samples = parse_samples(http_get(*metrics_));
  for (int i = 0; i < kTries; ++i) {
    std::this_thread::sleep_for(kPause);
    Samples again = parse_samples(http_get(*metrics_));
    const bool is_same = frames(again) == frames(samples);
    samples = std::move(again);
    if (is_same) break;
  }
  return samples;
}

}  // namespace collided::cli::load
