// The command line.
#include "server/config/options.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <functional>
#include <memory>
#include <sstream>

#include "deploy/help/help.hpp"
#include "server/config/memory_limits.hpp"
#include "server/config/private.hpp"
#include "server/config/rules.hpp"

namespace collided::server {
namespace {

constexpr int kBadConfig = 2;

// Visits all options, also those of groups.
void for_each_option(CLI::App& app, const std::function<void(CLI::Option&)>& visit) {
  for (CLI::Option* option : app.get_options()) visit(*option);
  for (CLI::App* group : app.get_subcommands([](CLI::App*) { return true; })) for_each_option(*group, visit);
}

// The flag acts as soon as it is parsed. CLI11 reads variables and stores the values of options only afterwards, so
// that the flag may stand anywhere on the command line.
void add_private_flag(CLI::App& app, Config& config, Switches& switches) {
  const auto make_private = [&] {
    switches.is_private = true;
    for_each_option(app, [](CLI::Option& option) { option.envname(""); });
    set_private_defaults(config);
  };
  app.add_flag_callback("--private", make_private,
                        "Serve the process that starts it alone: on sockets in a temporary folder, with limits of a "
                        "single client, without COLLIDED_* variables, until standard input closes")
      ->trigger_on_parse()
      ->disable_flag_override()
      ->configurable(false);
}

}  // namespace

void define_options(CLI::App& app, Config& config, Switches& switches) {
  config.limits = underived_limits();
  app.set_version_flag("--version", switches.version)->configurable(false);
  app.get_help_ptr()->configurable(false);
  app.footer(
      "Each option comes from its flag, else the environment (--max-scenes is COLLIDED_MAX_SCENES), else the --config\n"
      "file (key max-scenes), else its default. SIGHUP reads them again.");
  add(app, "--config", switches.config_file, "TOML file with options; deploy/collided.toml documents it")
      ->type_name("FILE")
      ->configurable(false);
  app.add_flag("--check", switches.check, "Check the configuration and exit")->configurable(false);
  add_private_flag(app, config, switches);
  add_serve_options(app, config);
  add_limit_options(app, config.limits);
}

namespace {

ParsedConfig stop(const CLI::App& app, const CLI::ParseError& error) {
  std::ostringstream out, err;
  ParsedConfig parsed;
  parsed.run = false;
  parsed.exit_code = app.exit(error, out, err) == 0 ? 0 : kBadConfig;
  parsed.text = out.str() + err.str();
  return parsed;
}

ParsedConfig stop(const ConfigError& error) {
  ParsedConfig parsed;
  parsed.run = false;
  parsed.exit_code = kBadConfig;
  parsed.text = std::string("collided: ") + error.what() + "\n";
  return parsed;
}

void take_variable(CLI::Option& option) {
  if (option.get_envname().empty() || option.count() > 0) return;
  const char* const value = std::getenv(option.get_envname().c_str());
  if (value == nullptr || *value == 0) return;
  option.add_result(value);
  option.run_callback();
}

// Gives options without a flag the values of their variables. CLI11 2.4 does not do that in a group of options of which
// none has a flag, and passes over a value that the option refuses. Throws CLI::ParseError.
void take_environment(CLI::App& app) { for_each_option(app, take_variable); }

}  // namespace

std::string variable_of(const std::string& flag) {
  std::string name = "COLLIDED_" + flag.substr(2);
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return c == '-' ? '_' : std::toupper(c); });
  return name;
}

ParsedConfig parse_config(int argc, const char* const* argv, const std::string& version) {
  ParsedConfig parsed;
  Switches switches{.version = version};
  CLI::App app(kSummary, kProgram);
  app.formatter(std::make_shared<FittedFormatter>());
  define_options(app, parsed.config, switches);
  try {
    app.parse(argc, argv);
    take_environment(app);
    // Not by CLI11's own set_config, which lets the file override the environment.
    if (!switches.config_file.empty()) take_file(app, switches.config_file);
    check_rules(parsed.config);
  } catch (const CLI::ParseError& error) {
    return stop(app, error);
  } catch (const ConfigError& error) {
    return stop(error);
  }
  parsed.check = switches.check;
  parsed.is_private = switches.is_private;
  return parsed;
}

}  // namespace collided::server
