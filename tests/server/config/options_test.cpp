// The command line and the environment.
#include "server/config/config.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace collided::server {
namespace {

ParsedConfig parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "collided");
  return parse_config(static_cast<int>(arguments.size()), arguments.data());
}

TEST(Config, Defaults) {
  const auto parsed = parse({});
  EXPECT_TRUE(parsed.run) << parsed.text;
  EXPECT_EQ(parsed.config.addresses, std::vector<std::string>{"127.0.0.1:50551"});
  EXPECT_EQ(parsed.config.limits.max_message_bytes, 64u << 20);
  EXPECT_EQ(parsed.config.limits.max_scenes, 64u);
}

TEST(Config, Flags) {
  const auto parsed = parse({"--address", "unix:/tmp/a", "--address", "[::1]:0", "--backend", "cpu", "--threads", "3",
                             "--max-scene-mb", "5", "--log-level", "debug"});
  ASSERT_TRUE(parsed.run) << parsed.text;
  EXPECT_EQ(parsed.config.addresses, (std::vector<std::string>{"unix:/tmp/a", "[::1]:0"}));
  EXPECT_EQ(parsed.config.backend, "cpu");
  EXPECT_EQ(parsed.config.threads, 3);
  EXPECT_EQ(parsed.config.limits.max_scene_bytes, 5u << 20);
}

TEST(Config, EnvironmentYieldsToFlags) {
  setenv("COLLIDED_MAX_SCENES", "7", 1);
  setenv("COLLIDED_ADDRESS", "127.0.0.1:1,127.0.0.1:2", 1);
  const auto from_environment = parse({}), from_flag = parse({"--max-scenes", "9"});
  unsetenv("COLLIDED_MAX_SCENES");
  unsetenv("COLLIDED_ADDRESS");
  EXPECT_EQ(from_environment.config.limits.max_scenes, 7u);
  EXPECT_EQ(from_environment.config.addresses.size(), 2u);
  EXPECT_EQ(from_flag.config.limits.max_scenes, 9u);
}

TEST(Config, RefusesBadValuesByName) {
  for (const auto& [flag, value] : {std::pair{"--address", "nowhere"},
                                    {"--address", "a:70000"},
                                    {"--backend", "tpu"},
                                    {"--threads", "-1"},
                                    {"--max-scenes", "0"},
                                    {"--log-level", "loud"},
                                    {"--grace-seconds", "nan"},
                                    {"--max-message-mb", "2048"}}) {
    const auto parsed = parse({flag, value});
    EXPECT_FALSE(parsed.run) << flag;
    EXPECT_NE(parsed.exit_code, 0) << flag;
    EXPECT_NE(parsed.text.find(flag), std::string::npos) << parsed.text;
  }
}

TEST(Config, VersionAndHelpExitWithZero) {
  EXPECT_EQ(parse({"--version"}).exit_code, 0);
  EXPECT_EQ(parse({"--version"}).text, "collided " COLLIDED_VERSION "\n");
  EXPECT_NE(parse({"--help"}).text.find("--max-window"), std::string::npos);
}

TEST(Config, Addresses) {
  EXPECT_EQ(check_address("unix:/run/collided.sock"), "");
  EXPECT_EQ(check_address("localhost:0"), "");
  EXPECT_NE(check_address("unix:relative"), "");
  EXPECT_NE(check_address("unix:/" + std::string(200, 'a')), "");
  EXPECT_NE(check_address("host:"), "");
  EXPECT_NE(check_address(":1"), "");
}

}  // namespace
}  // namespace collided::server
