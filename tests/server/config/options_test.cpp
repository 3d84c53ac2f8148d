// The command line and the environment.
#include <gtest/gtest.h>

#include "server/config/address.hpp"
#include "tests/server/config/parse.hpp"

namespace collided::server {
namespace {

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
                                    {"--name", "a.b"},
                                    {"--name", "a b"},
                                    {"--name", "0123456789012345678901234567890123456789012345678901234567890123"},
                                    {"--threads", "-1"},
                                    {"--threads", "1.5"},
                                    {"--max-scenes", "0"},
                                    {"--max-scenes", "0x10"},
                                    {"--max-scenes", "18446744073709551617"},
                                    {"--max-vertices", "4294967295"},
                                    {"--log-level", "loud"},
                                    {"--log-format", "xml"},
                                    {"--http-address", "localhost:1"},
                                    {"--local-socket", "relative"},
                                    {"--allow-uid", "-1"},
                                    {"--cuda-ipc=2", "--check"},
                                    {"--tls-key", "k.pem"},
                                    {"--tls-client-ca", "ca.pem"},
                                    {"--lease-seconds", "3601"},
                                    {"--max-message-mb", "2048"}}) {
    const auto parsed = parse({flag, value});
    EXPECT_FALSE(parsed.run) << flag << " " << value;
    EXPECT_EQ(parsed.exit_code, 2) << flag;
    EXPECT_NE(parsed.text.find(std::string(flag).substr(0, std::string(flag).find('='))), std::string::npos)
        << parsed.text;
  }
}

TEST(Config, EveryNumberRefusesWhatIsNone) {
  for (const auto* flag : {"--grace-seconds",
                           "--keepalive-seconds",
                           "--keepalive-timeout-seconds",
                           "--max-idle-seconds",
                           "--lease-seconds",
                           "--max-lease-seconds",
                           "--max-frames-per-second",
                           "--max-frame-seconds",
                           "--threads",
                           "--concurrent-frames",
                           "--max-message-mb",
                           "--max-decode-mb",
                           "--max-silent-seconds",
                           "--max-vertices",
                           "--max-triangles",
                           "--max-scenes",
                           "--max-scene-mb",
                           "--max-device-mb",
                           "--max-window",
                           "--max-streams",
                           "--max-scenes-per-client",
                           "--max-device-mb-per-client",
                           "--max-streams-per-client",
                           "--allow-uid"})
    for (const auto* value : {"nan", "inf", "-1", "1e300", "5x", " 5", "99999999999999999999999"}) {
      const auto parsed = parse({flag, value});
      EXPECT_EQ(parsed.exit_code, 2) << flag << " " << value;
      EXPECT_NE(parsed.text.find(flag), std::string::npos) << parsed.text;
      EXPECT_NE(parsed.text.find(value), std::string::npos) << parsed.text;
    }
}

TEST(Config, ALeadingZeroIsNotOctal) { EXPECT_EQ(parse({"--max-scenes", "010"}).config.limits.max_scenes, 10u); }

TEST(Config, LimitsOfClientsAndTime) {
  const auto parsed =
      parse({"--max-scenes-per-client", "3", "--max-device-mb", "7", "--max-device-mb-per-client", "5",
             "--max-streams-per-client", "2", "--max-frames-per-second", "2.5", "--lease-seconds", "0.5"});
  ASSERT_TRUE(parsed.run) << parsed.text;
  const Limits& limits = parsed.config.limits;
  EXPECT_EQ(limits.client, (ClientLimits{3, 5u << 20, 2, 2.5}));
  EXPECT_EQ(limits.max_device_bytes, 7u << 20);
  EXPECT_EQ(limits.lease_seconds, 0.5);
}

TEST(Config, Switches) {
  EXPECT_TRUE(parse({"--cuda-ipc"}).config.cuda_ipc);
  EXPECT_FALSE(parse({"--cuda-ipc=false"}).config.cuda_ipc);
  EXPECT_TRUE(parse({"--check"}).check);
  setenv("COLLIDED_ALLOW_INSECURE", "true", 1);
  EXPECT_TRUE(parse({}).config.allow_insecure);
  unsetenv("COLLIDED_ALLOW_INSECURE");
}

TEST(Config, VersionAndHelpExitWithZero) {
  EXPECT_EQ(parse({"--version"}).exit_code, 0);
  EXPECT_EQ(parse({"--version"}).text, "collided " COLLIDED_VERSION "\n");
  EXPECT_NE(parse({"--help"}).text.find("--max-window"), std::string::npos);
}

TEST(Config, HelpTellsWhatASwitchIs) {
  for (const auto* flag : {"--cuda-ipc", "--open-reflection", "--allow-insecure"})
    EXPECT_NE(parse({"--help"}).text.find(std::string(flag) + " [=true|false] (default: false) (Env:"),
              std::string::npos)
        << flag;
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
