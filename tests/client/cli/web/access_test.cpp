// Who may read a scene through collidectl view.

#include "client/cli/web/access.hpp"

#include <gtest/gtest.h>

#include <set>

#include "client/app/options/usage_error.hpp"
#include "client/cli/web/demo.hpp"

namespace collided::cli {
namespace {

TEST(ListenAddress, IsHostAndPort) {
  const auto parsed = [](const std::string& text) {
    const ListenAddress address = parse_listen_address(text);
    return address.host + " " + address.port;
  };
  EXPECT_EQ(parsed("127.0.0.1:8080"), "127.0.0.1 8080");
  EXPECT_EQ(parsed("localhost"), "localhost 0");
  EXPECT_EQ(parsed("[::1]:0"), "::1 0");
  EXPECT_EQ(parsed("::1"), "::1 0");
  for (const char* wrong : {"", ":80", "host:", "host:x", "host:65536", "host:-1", "[::1", "[::1]80", "[]:1"})
    EXPECT_THROW(parse_listen_address(wrong), UsageError) << wrong;
}

TEST(Host, IsOwnWhereNoNameOfOthersCanLeadToIt) {
  for (const char* own :
       {"127.0.0.1:8080", "127.0.0.1", "localhost:1", "LOCALHOST", "[::1]:80", "10.0.0.7:80", "gpu-host:80"})
    EXPECT_TRUE(is_own_host(own, "gpu-host")) << own;
  for (const char* other : {"", "evil.example", "evil.example:80", "127.0.0.1.evil.example", "localhost.evil.example",
                            "[::1", "gpu-host.evil.example", "[evil]:80", "127.0.0.1@evil.example"})
    EXPECT_FALSE(is_own_host(other, "gpu-host")) << other;
}

TEST(Origin, IsOwnOnlyWithTheSameHostAndPort) {
  EXPECT_TRUE(is_own_origin("http://127.0.0.1:80", "127.0.0.1:80"));
  EXPECT_TRUE(is_own_origin("https://LocalHost:80", "localhost:80"));
  for (const char* other :
       {"", "null", "http://127.0.0.1:81", "http://evil.example", "127.0.0.1:80", "http://127.0.0.1:80/"})
    EXPECT_FALSE(is_own_origin(other, "127.0.0.1:80")) << other;
}

TEST(Secret, IsLongAndNeverTheSame) {
  std::set<std::string> secrets;
  for (int i = 0; i < 100; ++i) secrets.insert(make_secret());
  EXPECT_EQ(secrets.size(), 100u);
  for (const std::string& secret : secrets) EXPECT_EQ(secret.size(), 32u);
  EXPECT_TRUE(is_equal_secret("abc", "abc"));
  EXPECT_FALSE(is_equal_secret("abc", "abd"));
  EXPECT_FALSE(is_equal_secret("abc", "abcd"));
}

TEST(Demo, GoesToTheLastFrameAndBack) {
  std::vector<int> frames;
  for (uint64_t step = 0; step < 9; ++step) frames.push_back(frame_to_and_fro(step, 4));
  EXPECT_EQ(frames, (std::vector<int>{0, 1, 2, 3, 2, 1, 0, 1, 2}));
  EXPECT_EQ(frame_to_and_fro(5, 1), 0);
  EXPECT_EQ(frame_to_and_fro(5, 2), 1);
}

}  // namespace
}  // namespace collided::cli
