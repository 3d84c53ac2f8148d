// collidectl info: version, devices and limits of a daemon.

#include <cstdio>
#include <memory>

#include "client/cli/commands.hpp"
#include "client/cli/connection.hpp"
#include "client/cli/report.hpp"

namespace collided::cli {

namespace {

Json info_json(const v1::GetServerInfoResponse& info) {
  Json devices = Json::object();
  for (const v1::Device& d : info.devices())
    devices[name_of(d.backend())] = {{"name", d.name()}, {"memory_bytes", d.memory_bytes()}};
  const v1::ServerLimits& l = info.limits();
  const Json limits = {{"max_message_bytes", l.max_message_bytes()}, {"max_vertices", l.max_vertices()},
                       {"max_triangles", l.max_triangles()},         {"max_scenes", l.max_scenes()},
                       {"max_scene_bytes", l.max_scene_bytes()},     {"max_window", l.max_window()}};
  return {{"version", info.version()}, {"devices", devices}, {"limits", limits}};
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
    const Json info = info_json(connection->server_info());
    if (options->json)
      std::printf("%s\n", info.dump().c_str());
    else
      print_text(info);
  });
}

}  // namespace collided::cli
