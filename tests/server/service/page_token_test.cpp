// Page tokens are ids of scenes, with the daemon's name.
#include "server/service/page_token.hpp"

#include <gtest/gtest.h>

namespace collided::server {
namespace {

const std::string kDigits = "0123456789abcdef0123456789abcdef";

TEST(PageToken, IsTheIdOfASceneOfTheDaemon) {
  EXPECT_NO_THROW(check_page_token("", ""));
  EXPECT_NO_THROW(check_page_token(kDigits, ""));
  EXPECT_NO_THROW(check_page_token("", "gpu0"));
  EXPECT_NO_THROW(check_page_token("gpu0." + kDigits, "gpu0"));
}

TEST(PageToken, OthersAreRefused) {
  for (const std::string& token : {std::string("zz"), kDigits + "0", kDigits.substr(1), std::string(32, 'G')})
    EXPECT_THROW(check_page_token(token, ""), InvalidInput) << token;
  for (const std::string& token : {kDigits, "gpu1." + kDigits, "gpu0" + kDigits, "gpu0." + kDigits.substr(1)})
    EXPECT_THROW(check_page_token(token, "gpu0"), InvalidInput) << token;
}

}  // namespace
}  // namespace collided::server
