#pragma once
// Turns events of scenes and frames into metrics, log lines and the daemon's state.

#include "server/frames/frame.hpp"
#include "server/ops/lifecycle.hpp"
#include "server/ops/metrics.hpp"
#include "server/scenes/scene.hpp"

namespace collided::server {

class ServiceObserver final : public SceneObserver {
 public:
  /// Both outlive it.
  ServiceObserver(Metrics& metrics, Lifecycle& lifecycle) : metrics_(metrics), lifecycle_(lifecycle) {}

  void answered(const Scene& scene, const AnsweredFrame& frame) override;
  void refused(const Scene& scene, uint64_t frame_id, const std::exception_ptr& error) override;
  void counted(const Scene& scene, CounterId id, uint64_t times) override;
  void expired(const Scene& scene) override;
  /// Ends the daemon if the device no longer responds.
  void device_failed(const Scene& scene, const std::string& why) override;

 private:
  Metrics& metrics_;
  Lifecycle& lifecycle_;
};

}  // namespace collided::server
