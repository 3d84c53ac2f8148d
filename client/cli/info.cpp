// collidectl info: version, devices and limits of a daemon.

#include <cstdio>
#include <memory>

#include "client/app/daemon/connection.hpp"
#include "client/app/options/options.hpp"
#include "client/app/report/json.hpp"
#include "client/app/report/text.hpp"
#include "client/cli/commands.hpp"

namespace collided::cli {

namespace {

Json limits_json(const v1::ServerLimits& limits) {
  return {{"max_message_bytes", limits.max_message_bytes()},
          {"max_vertices", limits.max_vertices()},
          {"max_triangles", limits.max_triangles()},
          {"max_scene_bytes", limits.max_scene_bytes()},
          {"max_window", limits.max_window()},
          {"max_idle_seconds", limits.max_idle_seconds()},
          {"max_lease_seconds", limits.max_lease_seconds()},
          {"max_scenes", limits.max_scenes()},
          {"max_device_bytes", limits.max_device_bytes()},
          {"max_streams", limits.max_streams()},
          {"max_scenes_per_client", limits.max_scenes_per_client()},
          {"max_device_bytes_per_client", limits.max_device_bytes_per_client()},
          {"max_streams_per_client", limits.max_streams_per_client()},
          {"max_frames_per_second", limits.max_frames_per_second()},
          {"max_frame_seconds", limits.max_frame_seconds()},
          {"max_accuracy", name_of(limits.max_accuracy())},
          {"min_ping_seconds", limits.min_ping_seconds()}};
}

Json device_json(const v1::Device& device) {
  return {{"name", device.name()},
          {"memory_bytes", device.memory_bytes()},
          {"uuid", device.uuid()},
          {"max_bytes", device.max_bytes()},
          {"free_bytes", device.free_bytes()},
          {"scenes", device.scenes()},
          {"load", device.load()}};
}

Json unusable_json(const v1::GetServerInfoResponse& info) {
  Json unusable = Json::object();
  for (const v1::UnusableDevice& d : info.unusable_devices())
    unusable[d.id().empty() ? name_of(d.backend()) : d.id()] = {{"name", d.name()}, {"reason", d.reason()}};
  return unusable;
}

Json info_json(const v1::GetServerInfoResponse& info) {
  Json devices = Json::object();
  for (const v1::Device& d : info.devices()) devices[d.id().empty() ? name_of(d.backend()) : d.id()] = device_json(d);
  return {{"version", info.version()},
          {"devices", devices},
          {"unusable_devices", unusable_json(info)},
          {"limits", limits_json(info.limits())},
          {"local_socket", info.local_socket()}};
}

}  // namespace

void add_info(CLI::App& app) {
  struct Options {
    ServerOptions server;
    bool json = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App& command = *app.add_subcommand("info", "Version, devices and limits of a daemon");
  add_server_options(command, options->server);
  command.add_flag("--json", options->json, "Print one JSON object");
  command.callback([options] {
    Connection connection(options->server);
    Json info = info_json(connection->server_info());
    if (!options->json && info["unusable_devices"].empty()) info.erase("unusable_devices");
    if (options->json)
      std::printf("%s\n", json_text(info).c_str());
    else
      std::printf("%s", report_text(info).c_str());
  });
}

}  // namespace collided::cli
