// A private daemon's defaults, and what overrides them.
#include "server/config/private.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "server/config/host_limits.hpp"
#include "server/config/memory_limits.hpp"
#include "server/config/reload.hpp"
#include "tests/server/config/parse.hpp"

namespace collided::server {
namespace {

TEST(PrivateConfig, ItsClientMayUseEverything) {
  const auto parsed = parse({"--private"});
  ASSERT_TRUE(parsed.run) << parsed.text;
  EXPECT_TRUE(parsed.is_private);
  EXPECT_FALSE(parse({}).is_private);
  // The highest values that options accept.
  const auto most = parse({"--max-message-mb", "2047", "--max-scenes-per-client", "1000000", "--max-streams-per-client",
                           "1000000", "--max-device-mb-per-client", "16777216", "--max-frame-seconds", "1000000",
                           "--max-frames-per-second", "1000000000"});
  EXPECT_EQ(parsed.config.limits, most.config.limits);
  EXPECT_EQ(parsed.config.log_level, "warning");
}

TEST(PrivateConfig, OptionsOverrideItsDefaultsOnBothSidesOfTheFlag) {
  const auto parsed = parse({"--max-frame-seconds", "3", "--private", "--log-level", "debug"});
  ASSERT_TRUE(parsed.run) << parsed.text;
  EXPECT_EQ(parsed.config.limits.client.max_frame_seconds, 3);
  EXPECT_EQ(parsed.config.limits.client.max_scenes, 1'000'000u);
  EXPECT_EQ(parsed.config.log_level, "debug");
}

TEST(PrivateConfig, SoDoesAFileThatIsNamed) {
  const TextFile file("max-frame-seconds = 3\n");
  const auto path = file.path();
  EXPECT_EQ(parse({"--private", "--config", path.c_str()}).config.limits.client.max_frame_seconds, 3);
}

// Every option has one, also those that CLI11 reads by itself.
TEST(PrivateConfig, NoVariableDoes) {
  std::vector<std::string> names;
  std::istringstream help(parse({"--help"}).text);
  for (std::string word; help >> word;)
    if (const size_t at = word.find("Env:COLLIDED_"); at != std::string::npos)
      names.push_back(word.substr(at + 4, word.find(')') - at - 4));
  EXPECT_GT(names.size(), 30u);
  for (const auto& name : names) setenv(name.c_str(), "no value of any option", 1);
  const auto parsed = parse({"--private", "--threads", "2"});
  const bool is_refused = !parse({}).run;
  for (const auto& name : names) unsetenv(name.c_str());
  EXPECT_TRUE(is_refused);
  EXPECT_TRUE(parsed.run) << parsed.text;
  EXPECT_EQ(parsed.config, parse({"--private", "--threads", "2"}).config);
}

TEST(PrivateConfig, ItsSocketsAreInItsFolder) {
  Config config = parse({"--private"}).config;
  add_private_sockets(config, "/tmp/mine");
  EXPECT_EQ(config.addresses, std::vector<std::string>{"unix:/tmp/mine/socket"});
  EXPECT_EQ(config.local_socket, overcommits_memory() ? "/tmp/mine/local" : "");

  Config named = parse({"--private", "--address", "[::1]:0", "--local-socket", "/tmp/local"}).config;
  add_private_sockets(named, "/tmp/mine");
  EXPECT_EQ(named.addresses, (std::vector<std::string>{"unix:/tmp/mine/socket", "[::1]:0"}));
  EXPECT_EQ(named.local_socket, "/tmp/local");
}

TEST(PrivateConfig, AnOptionOfItsSocketsIsCheckedWithThem) {
  const std::vector<const char*> tls = {"--private", "--local-socket",  "", "--tls-certificate", "a", "--tls-key",
                                        "b",         "--tls-client-ca", "c"};
  auto parsed = parse(tls);
  ASSERT_TRUE(parsed.run) << parsed.text;
  EXPECT_THROW(add_private_sockets(parsed.config, "/tmp/mine"), ConfigError);
}

TEST(PrivateConfig, AReloadKeepsItsSockets) {
  const auto line = command_line({"--private"});
  Config config = parse({"--private"}).config;
  add_private_sockets(config, "/tmp/mine");
  derive_limits(config.limits, {});
  const auto [now, restart] = reload_config(static_cast<int>(line.size()), line.data(), config, {});
  EXPECT_EQ(now, config);
  EXPECT_TRUE(restart.empty());
}

}  // namespace
}  // namespace collided::server
