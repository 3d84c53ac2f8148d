// collidectl scenes: the procedural scenes.

#include <cstdio>
#include <memory>

#include "client/app/report/json.hpp"
#include "client/cli/commands.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli {

void add_scenes(CLI::App& app) {
  auto json = std::make_shared<bool>(false);
  CLI::App& command = *app.add_subcommand("scenes", "List the procedural scenes");
  command.add_flag("--json", *json, "Print an array of objects with name, description and triangles");
  command.callback([json] {
    Json out = Json::array();
    for (const scenes::SceneInfo& info : scenes::list_scenes()) {
      if (*json)
        out.push_back({{"name", info.name},
                       {"description", info.description},
                       {"triangles", scenes::make_scene(info.name)->triangle_count()}});
      else
        std::printf("%-18s%s\n", info.name.c_str(), info.description.c_str());
    }
    if (*json) std::printf("%s\n", json_text(out).c_str());
  });
}

}  // namespace collided::cli
