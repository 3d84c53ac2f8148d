// The TOML file: its keys, its precedence between environment and defaults, and the documented example.
#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <sstream>
#include <toml.hpp>

#include "tests/server/config/parse.hpp"

namespace collided::server {
namespace {

ParsedConfig parse_file(const std::string& text, std::vector<const char*> more = {}) {
  const TextFile file(text);
  const auto path = file.path();
  more.insert(more.end(), {"--config", path.c_str()});
  return parse(more);
}

TEST(ConfigFile, SetsOptions) {
  const auto parsed = parse_file(
      "address = [\"[::1]:1\",  # one\n  'unix:/tmp/s'] # two\nmax-scenes = 1_0\ngrace-seconds = 2.5\n"
      "cuda-ipc = true\nallow-uid = [0, 1000]\nlog-format = \"json\"\n");
  ASSERT_TRUE(parsed.run) << parsed.text;
  EXPECT_EQ(parsed.config.addresses, (std::vector<std::string>{"[::1]:1", "unix:/tmp/s"}));
  EXPECT_EQ(parsed.config.limits.max_scenes, 10u);
  EXPECT_EQ(parsed.config.grace_seconds, 2.5);
  EXPECT_TRUE(parsed.config.cuda_ipc);
  EXPECT_EQ(parsed.config.allowed_uids, (std::vector<uint32_t>{0, 1000}));
  EXPECT_EQ(parsed.config.log_format, "json");
}

TEST(ConfigFile, YieldsToEnvironmentAndFlags) {
  setenv("COLLIDED_MAX_SCENES", "7", 1);
  const auto parsed = parse_file("max-scenes = 5\nmax-window = 5\nmax-streams = 5", {"--max-window", "9"});
  unsetenv("COLLIDED_MAX_SCENES");
  EXPECT_EQ(parsed.config.limits.max_scenes, 7u) << parsed.text;
  EXPECT_EQ(parsed.config.limits.max_window, 9u);
  EXPECT_EQ(parsed.config.limits.max_streams, 5u);
}

TEST(ConfigFile, ItsPathCanComeFromTheEnvironment) {
  const TextFile file("max-scenes = 5");
  setenv("COLLIDED_CONFIG", file.path().c_str(), 1);
  EXPECT_EQ(parse({}).config.limits.max_scenes, 5u);
  unsetenv("COLLIDED_CONFIG");
}

#if TOML11_VERSION_MAJOR >= 4  // says other things of what it refuses itself
constexpr const char* kTwice = ":2: [error]";
constexpr const char* kTooLarge = ":1: [error]";
constexpr const char* kTooSmall = kTooLarge;
#else
constexpr const char* kTwice = "max-scenes";
constexpr const char* kTooLarge = ":1: max-scenes is 9223372036854775807 or more";
constexpr const char* kTooSmall = "is -9223372036854775808 or less";
#endif

TEST(ConfigFile, RefusesWithTheKeyAndTheLine) {
  for (const auto& [text, named] : {std::pair{"\nmax-scene = 5", ":2: max-scene is not an option"},
                                    {"max-scenes = nan", "max-scenes"},
                                    {"max-scenes = -1", "--max-scenes"},
                                    {"\n\nmax-scenes = \"many\"", ":3: --max-scenes"},
                                    {"max-scenes = 1.5", "--max-scenes"},
                                    {"max-scenes = [1, 2]", "--max-scenes"},
                                    {"max-scenes = 1979-05-27", "max-scenes"},
                                    {"[limits]\nmax-scenes = 5", "limits is not an option"},
                                    {"check = true", "check is not an option"},
                                    {"config = \"x\"", "config is not an option"},
                                    {"help = true", "help is not an option"},
                                    {"max-scenes = 1\nmax-scenes = 2", kTwice},
                                    {"max-scenes", "file.toml"},
                                    {"cuda-ipc = 2", "--cuda-ipc"},
                                    {"max-scenes = 99999999999999999999", kTooLarge},
                                    {"max-scenes = -99999999999999999999", kTooSmall},
                                    {"address = \"0.0.0.0:1\"", "--address 0.0.0.0:1"}}) {
    const auto parsed = parse_file(text);
    EXPECT_EQ(parsed.exit_code, 2) << text;
    EXPECT_NE(parsed.text.find(named), std::string::npos) << text << "\n" << parsed.text;
  }
}

TEST(ConfigFile, RefusesFilesThatCannotBeRead) {
  for (const auto* path : {"/nowhere/collided.toml", "/tmp", "/dev/zero"}) {
    const auto parsed = parse({"--config", path});
    EXPECT_EQ(parsed.exit_code, 2) << path;
    EXPECT_NE(parsed.text.find(path), std::string::npos) << parsed.text;
  }
}

std::set<std::string> matches(const std::string& text, const std::regex& pattern) {
  std::set<std::string> found;
  for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end; ++match)
    found.insert((*match)[1]);
  return found;
}

// deploy/collided.toml documents every option, and nothing else, with its default.
TEST(ConfigFile, TheDocumentedOneIsComplete) {
  const auto parsed = parse({"--config", COLLIDED_TOML});
  ASSERT_TRUE(parsed.run) << parsed.text;
  EXPECT_EQ(parsed.config, parse({}).config);
  std::ostringstream text;
  text << std::ifstream(COLLIDED_TOML).rdbuf();
  auto options = matches(parse({"--help"}).text, std::regex("\n +(?:-h,)?--([a-z-]+)"));
  for (const auto* switch_only : {"help", "version", "config", "check", "private"})
    EXPECT_EQ(options.erase(switch_only), 1u);
  EXPECT_GT(options.size(), 30u);
  EXPECT_EQ(matches(text.str(), std::regex("(?:^|\n)([a-z-]+) = ")), options);
}

}  // namespace
}  // namespace collided::server
