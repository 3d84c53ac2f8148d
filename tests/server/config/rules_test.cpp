// Rules across options, who can reach the daemon, and what may change while it runs.
#include "server/config/rules.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "server/config/address.hpp"
#include "server/config/memory_limits.hpp"
#include "server/config/reload.hpp"
#include "tests/server/config/parse.hpp"

namespace collided::server {
namespace {

TEST(Address, WhoCanReachIt) {
  for (const auto* address :
       {"127.0.0.1:1", "127.9.9.9:1", "localhost:1", "[::1]:1", "[::ffff:127.0.0.1]:1", "unix:/run/s"})
    EXPECT_FALSE(is_public(address)) << address;
  for (const auto* address :
       {"0.0.0.0:1", "[::]:1", "10.0.0.1:1", "example.org:1", "[::ffff:10.0.0.1]:1", "localhost.example.org:1"})
    EXPECT_TRUE(is_public(address)) << address;
}

TEST(Rules, PlainTextOnANetworkMustBeAskedFor) {
  EXPECT_EQ(parse({"--address", "0.0.0.0:1"}).exit_code, 2);
  EXPECT_EQ(parse({"--address", "127.0.0.1:1", "--address", "[::]:1"}).exit_code, 2);
  EXPECT_TRUE(parse({"--address", "0.0.0.0:1", "--allow-insecure"}).run);
  EXPECT_TRUE(parse({"--address", "0.0.0.0:1", "--tls-certificate", "c", "--tls-key", "k"}).run);
}

TEST(Rules, WarnOfWhatIsExposed) {
  const auto warnings = [](const std::vector<const char*>& arguments) {
    return exposure_warnings(parse(arguments).config);
  };
  EXPECT_TRUE(warnings({}).empty());
  EXPECT_TRUE(warnings({"--http-address", "127.0.0.1:1"}).empty());
  EXPECT_EQ(warnings({"--address", "0.0.0.0:1", "--allow-insecure"}).size(), 3u);
  EXPECT_EQ(warnings({"--address", "0.0.0.0:1", "--allow-insecure", "--tokens-file", "t"}).size(), 2u);
  EXPECT_EQ(warnings({"--address", "0.0.0.0:1", "--tls-certificate", "c", "--tls-key", "k"}).size(), 2u);
  const auto best =
      warnings({"--address", "0.0.0.0:1", "--tls-certificate", "c", "--tls-key", "k", "--tokens-file", "t"});
  ASSERT_EQ(best.size(), 1u);
  EXPECT_NE(best[0].find("0.0.0.0:1 is open to other hosts: "), std::string::npos);
  EXPECT_NE(best[0].find("deploy/entrance"), std::string::npos);
  EXPECT_EQ(warnings({"--http-address", "0.0.0.0:1"}).size(), 1u);
}

TEST(Rules, AUnixSocketHasNoCertificates) {
  for (const auto& [option, value] : {std::pair{"--address", "unix:/s"}, {"--local-socket", "/s"}}) {
    const std::vector<const char*> line = {option,      value, "--tls-certificate", "c",
                                           "--tls-key", "k",   "--tls-client-ca",   "a"};
    EXPECT_EQ(parse(line).exit_code, 2);
    EXPECT_NE(parse(line).text.find(std::string(option) + " " + value + ": "), std::string::npos) << parse(line).text;
    auto with_tokens = line;
    with_tokens.insert(with_tokens.end(), {"--tokens-file", "t"});
    EXPECT_TRUE(parse(with_tokens).run) << option;
  }
}

TEST(Reload, TakesWhatMayChangeAndNamesTheRest) {
  const TextFile file("max-scenes = 5\nthreads = 1\nmax-message-mb = 8");
  const auto path = file.path();
  const auto line = command_line({"--config", path.c_str(), "--max-window", "3"});
  auto before = parse_config(static_cast<int>(line.size()), line.data()).config;
  derive_limits(before.limits, {});
  file.write(
      "max-scenes = 6\nthreads = 2\nmax-message-mb = 9\nmax-window = 4\nlog-level = \"debug\"\ntokens-file = \"t\"\n"
      "max-scenes-per-client = 2\naddress = \"127.0.0.1:9\"\n");
  const auto [now, restart] = reload_config(static_cast<int>(line.size()), line.data(), before, {});
  auto expected = before;
  expected.limits.max_scenes = 6;
  expected.limits.client.max_scenes = 2;
  expected.log_level = "debug";
  expected.tokens_file = "t";
  EXPECT_EQ(now, expected);
  EXPECT_EQ(restart, (std::vector<std::string>{"address", "threads", "max-message-mb"}));
}

TEST(Reload, NamesNothingIfNothingHasChanged) {
  const auto line = command_line({"--max-scenes", "5"});
  auto before = parse_config(static_cast<int>(line.size()), line.data()).config;
  const Memory memory{uint64_t{3} << 30, 0};
  derive_limits(before.limits, memory);
  const auto [now, restart] = reload_config(static_cast<int>(line.size()), line.data(), before, memory);
  EXPECT_EQ(now, before);
  EXPECT_EQ(restart, std::vector<std::string>());
}

// The stream limit itself applies at once.
TEST(Reload, NamesStreamsThatOneConnectionCannotCarryBeforeARestart) {
  for (const auto& [streams, is_named] : {std::pair("128", false), {"2000", true}}) {
    const auto line = command_line({"--max-streams", streams});
    Config before;
    before.limits.max_streams = 64;
    const auto [now, restart] = reload_config(static_cast<int>(line.size()), line.data(), before, {});
    EXPECT_EQ(now.limits.max_streams, static_cast<uint32_t>(std::stoi(streams)));
    EXPECT_EQ(std::ranges::any_of(restart, [](const auto& name) { return name.starts_with("max-streams, "); }),
              is_named);
  }
}

// A file that was cut off, or is empty, would open the daemon to everyone.
TEST(Reload, TokensAreReplacedButNotGivenUp) {
  const TextFile file("tokens-file = \"t\"\nmax-scenes = 5\n");
  const auto path = file.path();
  const auto line = command_line({"--config", path.c_str()});
  const auto before = parse_config(static_cast<int>(line.size()), line.data()).config;
  file.write("");
  const auto emptied = reload_config(static_cast<int>(line.size()), line.data(), before, {});
  EXPECT_EQ(emptied.config.tokens_file, "t");
  EXPECT_NE(std::find(emptied.restart.begin(), emptied.restart.end(), "tokens-file"), emptied.restart.end());
  file.write("tokens-file = \"u\"\n");
  EXPECT_EQ(reload_config(static_cast<int>(line.size()), line.data(), before, {}).config.tokens_file, "u");
}

TEST(Reload, ABadFileThrowsWithItsText) {
  const TextFile file("");
  const auto path = file.path();
  const auto line = command_line({"--config", path.c_str()});
  file.write("max-scenes = 0");
  try {
    reload_config(static_cast<int>(line.size()), line.data(), Config(), {});
    FAIL() << "no error";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("--max-scenes"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace collided::server
