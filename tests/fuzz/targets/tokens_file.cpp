// The daemon's file of tokens: clients, or a refusal that never quotes the file.

#include <spdlog/spdlog.h>

#include "server/auth/tokens.hpp"
#include "server/config/config.hpp"
#include "tests/fuzz/targets/memory_file.hpp"

namespace collided::fuzz {
namespace {

constexpr std::string_view kSecret = "0123456789abcdef";  // in the corpus and the dictionary

void check(const server::Token& token) {
  const std::string& name = token.client->name;
  const server::ClientLimits& limits = token.client->limits;
  require(!name.empty() && name.size() <= 64 && name != "anonymous", "clients have names of their own");
  require(limits.max_frame_seconds > 0 && limits.max_frames_per_second > 0, "limits are above 0");
}

void read(const std::string& text) {
  static const MemoryFile file;
  file.write(text);
  try {
    for (const server::Token& token : server::read_tokens(file.path(), {})) check(token);
  } catch (const server::ConfigError& e) {
    const std::string what = e.what();
    require(what.starts_with(file.path()), "a refusal names the file");
    require(what.find(kSecret) == std::string::npos, "a refusal has no token");
  }
}

}  // namespace

void run(Input input) {
  static const bool is_quiet = (spdlog::set_level(spdlog::level::off), true);
  require(is_quiet, "the log is off");
  read(input.rest());
}

}  // namespace collided::fuzz
