// collidectl completion, and the hidden 'manual': what the options say of themselves, for shells and for man.

#include "client/cli/manual/completion.hpp"

#include <cstdio>
#include <memory>

#include "client/cli/commands.hpp"
#include "client/cli/manual/describe.hpp"
#include "client/cli/manual/files.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli {

namespace {

using manual::Program;

constexpr auto kFooter =
    "An installed collidectl has these scripts where shells find them. For one in a build tree, the shell's\n"
    "configuration needs one line:\n"
    "\n"
    "  source <(collidectl completion bash)    # ~/.bashrc\n"
    "  source <(collidectl completion zsh)     # ~/.zshrc, after compinit\n"
    "  collidectl completion fish | source     # ~/.config/fish/config.fish\n"
    "\n"
    "Exit codes: 0 done, 1 failure, 2 bad usage.";

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const auto& scenes : {scenes::list_scenes(), scenes::list_variants()})
    for (const scenes::SceneInfo& scene : scenes) names.push_back(scene.name);
  return names;
}

/// What no option tells.
std::vector<manual::Section> sections() {
  return {
      {"ENVIRONMENT",
       {{"COLLIDED_DAEMON",
         "The daemon that a command starts without --server. Otherwise it is collided beside collidectl, in ../bin, "
         "in the build tree or on PATH."},
        {"GRPC_VERBOSITY", "Shows gRPC's own log, which is silent otherwise."}}}};
}

Program program_of(const CLI::App& app) {
  Program program = manual::describe(app, {{"SCENE", scene_names()}});
  program.version = COLLIDED_VERSION;
  program.sections = sections();
  program.see_also = {"collided(8)"};
  return program;
}

std::string script_for(const std::string& shell, const Program& program) {
  if (shell == "bash") return bash_completion(program);
  return shell == "zsh" ? zsh_completion(program) : fish_completion(program);
}

}  // namespace

void add_completion(CLI::App& app) {
  auto shell = std::make_shared<std::string>();
  CLI::App& command = *app.add_subcommand("completion", "Print a script that completes words in a shell");
  command.footer(kFooter);
  command.add_option("SHELL", *shell, "The shell")->required()->check(CLI::IsMember({"bash", "zsh", "fish"}));
  command.callback([&app, shell] {
    const std::string script = script_for(*shell, program_of(app));
    std::fwrite(script.data(), 1, script.size(), stdout);
  });
}

void add_manual(CLI::App& app) {
  struct Options {
    std::string share, date;
  };
  auto options = std::make_shared<Options>();
  CLI::App& command = *app.add_subcommand("manual", "Write man pages and completions as they are installed");
  command.group("");  // for builds and packages
  command.add_option("SHARE", options->share, "Folder, such as /usr/share")->required()->type_name("FOLDER");
  command.add_option("--date", options->date, "Date of the pages")->type_name("DATE")->required();
  command.callback([&app, options] {
    Program program = program_of(app);
    program.date = options->date;
    write_files(program, options->share);
  });
}

}  // namespace collided::cli
