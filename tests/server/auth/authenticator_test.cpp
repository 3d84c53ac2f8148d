// Identifying callers.
#include "server/auth/authenticator.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "server/errors.hpp"
#include "tests/server/config/parse.hpp"

namespace collided::server {
namespace {

std::string tokens(const std::string& name, const std::string& token) {
  return "[[tokens]]\nname = \"" + name + "\"\ntoken = \"" + token + "\"\n";
}

const std::string kTwo = tokens("a", "token-of-client-a") + tokens("b", "token-of-client-b") + "max-scenes = 3\n";

Config with_tokens(const TextFile& file) {
  Config config;
  config.tokens_file = file.path();
  return config;
}

std::string refusal(const Authenticator& authenticator, std::string_view authorization, std::string_view name = "") {
  try {
    authenticator.identify(authorization, name);
  } catch (const Unauthenticated& error) {
    return error.what();
  }
  return "";
}

TEST(Authenticator, EverybodyIsAnonymousWhereNothingIsAsked) {
  Config config;
  config.limits.client.max_scenes = 5;
  const Authenticator authenticator(config);
  for (const auto* authorization : {"", "Bearer x", "nonsense"}) {
    EXPECT_EQ(authenticator.identify(authorization, "cert")->name, "anonymous");
    EXPECT_EQ(authenticator.identify(authorization, "")->limits.max_scenes, 5u);
  }
}

// Anonymous callers have one name: without origins a long frame of one would never yield to another's.
TEST(Authenticator, AnonymousCallersTakeTurnsByTheirOrigin) {
  const Authenticator authenticator{Config()};
  EXPECT_EQ(authenticator.identify("", "", {"uid:7", "pid:9"})->turn_path(), (TurnPath{"uid:7", "pid:9"}));
  EXPECT_EQ(authenticator.identify("", "")->turn_path(), TurnPath{"anonymous"});
}

TEST(Authenticator, ATokenTakesTurnsByItsNameWhereverItComesFrom) {
  const TextFile file(kTwo);
  const Authenticator authenticator(with_tokens(file));
  EXPECT_EQ(authenticator.identify("Bearer token-of-client-a", "", {"uid:7", "pid:9"})->turn_path(), TurnPath{"a"});
}

TEST(Authenticator, ATokenIsItsClient) {
  const TextFile file(kTwo);
  const Authenticator authenticator(with_tokens(file));
  EXPECT_EQ(authenticator.identify("Bearer token-of-client-a", "")->name, "a");
  EXPECT_EQ(authenticator.identify("bearer   token-of-client-b", "cert")->name, "b");
  EXPECT_EQ(authenticator.identify("BEARER token-of-client-b", "")->limits.max_scenes, 3u);
}

TEST(Authenticator, RefusesWhatIsNoToken) {
  const TextFile file(kTwo);
  const Authenticator authenticator(with_tokens(file));
  EXPECT_NE(refusal(authenticator, "").find("missing"), std::string::npos);
  for (const std::string& sent :
       {std::string("Bearer"), std::string("Bearer "), std::string("Basic token-of-client-a"),
        std::string("token-of-client-a"), std::string("Bearer token-of-client-"),
        std::string("Bearer token-of-client-ab"), std::string("Bearer token-of-client-a "),
        std::string("Bearer Token-of-client-a"), std::string("Bearer\0x", 8), "Bearer " + std::string(100'000, 'x')}) {
    const auto what = refusal(authenticator, sent, "cert");
    EXPECT_NE(what, "") << sent.substr(0, 50);
    EXPECT_EQ(what.find("oken-of"), std::string::npos) << what;
  }
}

// An empty token is never valid, whatever the tokens file says.
TEST(Authenticator, AnEmptyTokenIsNone) {
  const TextFile file(kTwo);
  const Authenticator authenticator(with_tokens(file));
  for (const auto* sent : {"Bearer ", "bearer   "})
    EXPECT_EQ(refusal(authenticator, sent), "authorization has no token after \"Bearer\"");
}

TEST(Authenticator, ACertificateIsItsClientWhereThereAreNoTokens) {
  Config config;
  config.tls = {"c", "k", "ca"};
  const Authenticator authenticator(config);
  EXPECT_EQ(authenticator.identify("", "sim-1")->name, "sim-1");
  EXPECT_NE(refusal(authenticator, "Bearer x").find("certificate"), std::string::npos);
}

TEST(Authenticator, ReloadTakesNewTokensAndKeepsTheOldIfTheFileIsBad) {
  const TextFile file(kTwo);
  const auto config = with_tokens(file);
  Authenticator authenticator(config);
  const auto held = authenticator.identify("Bearer token-of-client-a", "");
  file.write("[[tokens]]\nname = \"c\"");
  EXPECT_THROW(authenticator.reload(config), ConfigError);
  EXPECT_EQ(authenticator.identify("Bearer token-of-client-a", "")->name, "a");
  file.write(tokens("c", "token-of-client-c"));
  authenticator.reload(config);
  EXPECT_EQ(authenticator.identify("Bearer token-of-client-c", "")->name, "c");
  EXPECT_NE(refusal(authenticator, "Bearer token-of-client-a"), "");
  EXPECT_EQ(held->name, "a");
}

TEST(Authenticator, ThrowsAtItsStartIfTheFileIsBad) {
  const TextFile file("nonsense");
  EXPECT_THROW(Authenticator(with_tokens(file)), ConfigError);
}

TEST(Authenticator, CallsGoOnDuringAReload) {
  const TextFile file(kTwo);
  const auto config = with_tokens(file);
  Authenticator authenticator(config);
  std::thread calls([&] {
    for (int i = 0; i < 500; ++i) EXPECT_EQ(authenticator.identify("Bearer token-of-client-a", "")->name, "a");
  });
  for (int i = 0; i < 50; ++i) authenticator.reload(config);
  calls.join();
}

}  // namespace
}  // namespace collided::server
