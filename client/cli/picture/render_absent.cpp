// collidectl render, where Embree was left out of the build.

#include "client/cli/commands.hpp"
#include "client/cli/options/usage_error.hpp"

namespace collided::cli {

void add_render(CLI::App& app) {
  auto* const command = app.add_subcommand("render", "Draw steps and their contacts (not in this build)");
  command->allow_extras();
  command->callback([] {
    throw UsageError("this build draws no pictures: it was made without Embree, as the Python wheels are; the Debian package "
                     "collided and a build from source have render");
  });
}

}  // namespace collided::cli
