#pragma once
// The daemon under load: a running one, or one that collidectl starts with limits that fit.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/app/daemon/connection.hpp"
#include "client/measure/load/daemon/counters.hpp"
#include "client/measure/load/daemon/http_get.hpp"
#include "client/measure/load/settings.hpp"

namespace collided::cli::load {

class Target {
 public:
  /// Throws Error or std::runtime_error if there is no daemon, or if its limits are in the way.
  explicit Target(const LoadSettings& settings);

  const std::string& address() const { return address_; }
  const client::ConnectOptions& connect_options() const { return options_; }
  client::Client& client() { return *client_; }
  bool is_own() const { return daemon_.has_value(); }

  /// A scene for each stream. Each is deleted when the last copy of what is returned is gone.
  std::vector<std::shared_ptr<const SceneGuard>> create_scenes(const v1::SceneSpec& spec,
                                                               std::span<const client::MeshInput> meshes,
                                                               uint32_t count);
  /// The daemon's counters once they no longer change; nothing if it is not known where they are served.
  std::optional<Samples> samples() const;

 private:
  std::optional<OwnDaemon> daemon_;  // made before the client and stopped after it
  std::string address_;
  client::ConnectOptions options_;
  std::optional<HttpUrl> metrics_;
  std::optional<client::Client> client_;
};

}  // namespace collided::cli::load
