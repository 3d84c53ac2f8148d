// The file of bearer tokens.
#include "server/auth/tokens.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "server/ops/log.hpp"
#include "tests/server/config/parse.hpp"

namespace collided::server {
namespace {

std::vector<Token> read(const std::string& text) { return read_tokens(TextFile(text).path(), ClientLimits()); }

constexpr auto* kHeader = "[[tokens]]\nname = \"a\"\n";
constexpr auto* kToken = "token = \"0123456789abcdef\"\n";

TEST(Tokens, NamesTokensDigestsAndLimits) {
  const auto tokens = read(
      "[[tokens]]\nname = \"a\"\ntoken = \"0123456789abcdef\"\nmax-scenes = 2\nmax-device-mb = 3\n"
      "[[tokens]]\nname = \"b\"\nsha256 = \"F95DB7A3A36B44DF7AA39D1E868EDF53452E8B2CFC5B303916EC442C33EEFE05\"\n"
      "max-streams = 4\nmax-frames-per-second = 0.5\nmax-frame-seconds = 0.25\nmax-accuracy = \"fast\"\n");
  ASSERT_EQ(tokens.size(), 2u);
  EXPECT_EQ(tokens[0].digest, digest_of("0123456789abcdef"));
  EXPECT_EQ(tokens[0].client->name, "a");
  ClientLimits expected;
  expected.max_scenes = 2;
  expected.max_device_bytes = 3 << 20;
  EXPECT_EQ(tokens[0].client->limits, expected);
  EXPECT_EQ(tokens[1].digest, digest_of("0123456789abcdeg")) << "sha256 of another program";
  EXPECT_EQ(tokens[1].client->limits.max_streams, 4u);
  EXPECT_EQ(tokens[1].client->limits.max_frames_per_second, 0.5);
  EXPECT_EQ(tokens[1].client->limits.max_frame_seconds, 0.25);
  EXPECT_EQ(tokens[1].client->limits.max_accuracy, Accuracy::kFast);
}

TEST(Tokens, ATokenCanBeExchangedWithoutAGap) {
  EXPECT_EQ(read(std::string(kHeader) + kToken + kHeader + "token = \"another-token-of-a\"\n").size(), 2u);
}

TEST(Tokens, RefusesWithTheLineAndNeverTellsTheToken) {
  const std::string header = kHeader, good = header + kToken;
  for (const auto& [text, named] : std::vector<std::pair<std::string, std::string>>{
           {"", "has no [[tokens]]"},
           {"tokens = 5", "has no [[tokens]]"},
           {"tokens = [5]", "must be tables"},
           {"other = 5", ":1: has a key that is not one of the file's"},
           {"[[0123456789abcdef]]", "has a key that is not one of the file's"},
           {header, ":1: one of token and sha256"},
           {good + "sha256 = \"00\"", ":1: one of token and sha256"},
           {good + "max_scenes = 1", ":1: has a key that no token has; there are name, token"},
           {header + "0123456789abcdef = 1", ":1: has a key that no token has"},
           {good + "max-scenes = 0", ":1: max-scenes is 0, not 1 to 1e+06"},
           {good + "max-scenes = 1.5", ":1: max-scenes is not a whole number"},
           {good + "max-scenes = \"1\"", ":1: max-scenes is not a number"},
           {good + "max-streams = -1", ":1: max-streams is -1"},
           {good + "max-device-mb = 1e300", ":1: max-device-mb"},
           {good + "max-frames-per-second = nan", ":1: max-frames-per-second is nan"},
           {good + "max-frames-per-second = inf", ":1: max-frames-per-second is inf"},
           {good + "max-frame-seconds = 0", ":1: max-frame-seconds is 0, not 0.001 to 1e+06"},
           {good + "max-accuracy = \"best\"", ":1: max-accuracy must be candidates"},
           {good + "max-accuracy = 4", ":1: max-accuracy is not a string"},
           {header + "token = \"fifteen-letters\"", "token has 15 bytes, not 16 to 512"},
           {header + "token = 1234567890123456", "token is not a string"},
           {header + "token = \"with blanks in it 0123\"", "printable"},
           {header + "sha256 = \"" + std::string(64, 'g') + "\"", "hexadecimal"},
           {header + "sha256 = \"00\"", "sha256 has 2 bytes"},
           {header + "sha256 = \"e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855\"",
            ":1: sha256 is that of an empty string"},
           {"[[tokens]]\n" + std::string(kToken), ":1: name is not a string"},
           {"[[tokens]]\nname = \"\"\n" + std::string(kToken), "name has 0 bytes"},
           {"[[tokens]]\nname = \"anonymous\"\n" + std::string(kToken), "anonymous"},
           {good + "[[tokens]]\nname = \"b\"\n" + kToken, ":4: the token of b appears twice"},
           {good + header + "token = \"0123456789abcdefg\"\nmax-scenes = 1",
            ":4: the tokens of a have different limits"},
           {header + "token = \"0123456789abcdef", "is not valid TOML"},
           {good + kToken, "is not valid TOML"}}) {
    try {
      read(text);
      FAIL() << text;
    } catch (const ConfigError& error) {
      const std::string what = error.what();
      EXPECT_NE(what.find(named), std::string::npos) << text << "\n" << what;
      EXPECT_NE(what.find("file.toml"), std::string::npos) << what;
      EXPECT_EQ(what.find("0123456789abcdef"), std::string::npos) << what;
      EXPECT_EQ(what.find("fifteen-letters"), std::string::npos) << what;
    }
  }
}

TEST(Tokens, RefusesFilesThatCannotBeRead) {
  for (const auto* path : {"/nowhere/tokens.toml", "/tmp", "/dev/zero"})
    EXPECT_THROW(read_tokens(path, ClientLimits()), ConfigError) << path;
  EXPECT_THROW(read(std::string((4 << 20) + 1, '#')), ConfigError);
  std::string many;
  for (int i = 0; i < 1001; ++i) many += kHeader + ("token = \"" + std::to_string(1'000'000'000'000'000 + i) + "\"\n");
  EXPECT_THROW(read(many), ConfigError);
}

// The parser recurses for each level.
TEST(Tokens, RefusesWhatNestsTooDeep) {
  for (const std::string& deep : {std::string(100'000, '['), "x = " + std::string(100'000, '{')}) try {
      read(std::string(kHeader) + kToken + deep);
      FAIL() << "no error";
    } catch (const ConfigError& error) {
      EXPECT_NE(std::string(error.what()).find("file.toml:4: nests deeper than 16 levels"), std::string::npos)
          << error.what();
    }
}

TEST(Tokens, WarnsWhenOthersCanReadThem) {
  namespace fs = std::filesystem;
  const TextFile file(std::string(kHeader) + kToken);
  const auto logged = [&](fs::perms perms) {
    set_up_log("text", "info");
    fs::permissions(file.path(), perms);
    testing::internal::CaptureStderr();
    read_tokens(file.path(), ClientLimits());
    flush_log();
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(logged(fs::perms::owner_read), "");
  EXPECT_NE(logged(fs::perms::owner_read | fs::perms::others_read).find(file.path()), std::string::npos);
}

}  // namespace
}  // namespace collided::server
