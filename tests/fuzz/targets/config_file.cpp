// The daemon's TOML file: the configuration that it is, or a refusal.

#include "server/config/config.hpp"
#include "tests/fuzz/targets/memory_file.hpp"

namespace collided::fuzz {
namespace {

void parse(const std::string& text) {
  static const MemoryFile file;
  static const std::string path = file.path();
  file.write(text);
  const char* const line[] = {"collided", "--config", path.c_str()};
  const server::ParsedConfig parsed = server::parse_config(3, line);
  require(parsed.run || parsed.exit_code == 2, "a bad file ends the daemon with exit code 2");
  require(parsed.run == parsed.text.empty(), "a refusal says why");
}

}  // namespace

void run(Input input) { parse(input.rest()); }

}  // namespace collided::fuzz
