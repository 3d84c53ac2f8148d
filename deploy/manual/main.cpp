// Writes the man pages and completions of the daemon, made from its options.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "client/cli/manual/describe.hpp"
#include "client/cli/manual/files.hpp"
#include "client/cli/manual/man_page.hpp"
#include "server/config/options.hpp"

namespace {

using namespace collided;
using manual::Section;

/// What no option tells.
std::vector<Section> sections() {
  return {
      {"SIGNALS",
       {{"SIGTERM, SIGINT",
         "Stop: health turns to NOT_SERVING, open streams are told and get --grace-seconds. A second one ends them at "
         "once."},
        {"SIGHUP",
         "Reads the configuration again. If it is invalid, the previous one stays. The log names options that take "
         "effect only after a restart."}}},
      {"EXIT STATUS",
       {{"", "0 stopped, 1 the daemon could not serve, or a GPU failed for good, 2 bad configuration."}}},
      {"FILES",
       {{"/etc/collided/collided.toml", "What the service of the Debian packages reads; each option, explained."},
        {"PREFIX/share/doc/collided/examples/collided.toml", "Each option with its default, explained."}}}};
}

manual::Program daemon_program(const std::string& date) {
  server::Config config;
  server::Switches switches;
  CLI::App app(server::kSummary, server::kProgram);
  server::define_options(app, config, switches);
  manual::Program program = manual::describe(app);
  program.self.summary = program.self.summary.substr(program.self.summary.find(": ") + 2);
  program.version = COLLIDED_VERSION;
  program.date = date;
  program.section = 8;
  program.sections = sections();
  program.see_also = {"collidectl(1)", "collided.toml(5)"};
  return program;
}

const manual::ConfigFile kConfigFile{
    .name = "collided.toml",
    .summary = "configuration of collided",
    .intro =
        "A TOML file that --config names, and SIGHUP reads again. Each key is an option of collided without its "
        "dashes. Flags and variables override the file; an empty value counts as unset. Keys that are not known, "
        "and values out of range, are errors that name the line: --check finds them. The example in "
        "PREFIX/share/doc/collided/examples marks with (R) the keys that take effect at SIGHUP, without a restart.",
    .example =
        "address = [\"127.0.0.1:50551\", \"unix:/run/collided/socket\"]\n"
        "http-address = \"127.0.0.1:9464\"\n"
        "max-scenes = 16\n"
        "log-format = \"json\"\n"};

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::fputs("usage: collided_manual_files SHARE DATE\n", stderr);
    return 2;
  }
  const std::string share = argv[1];
  const manual::Program program = daemon_program(argv[2]);
  manual::write_files(program, share);
  manual::write_file(share + "/man/man5/collided.toml.5", manual::config_page(program, kConfigFile));
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "collided_manual_files: %s\n", error.what());
  return 1;
}
