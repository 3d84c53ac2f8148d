// Ids and secrets that nobody can guess.
#include "server/auth/secrets.hpp"

#include <gtest/gtest.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <set>
#include <string>
#include <system_error>

namespace collided::server {
namespace {

TEST(RandomId, Has128BitsThatAllVary) {
  constexpr int kIds = 1000, kBits = 128;
  std::set<std::string> ids;
  std::array<int, kBits> ones{};
  for (int i = 0; i < kIds; ++i) {
    const std::string id = random_id();
    ASSERT_EQ(id.size(), 32u);
    ASSERT_EQ(id.find_first_not_of("0123456789abcdef"), id.npos) << id;
    for (int bit = 0; bit < kBits; ++bit) {
      const int digit = std::stoi(id.substr(static_cast<size_t>(bit / 4), 1), nullptr, 16);
      ones[static_cast<size_t>(bit)] += digit >> (bit % 4) & 1;
    }
    ids.insert(id);
  }
  EXPECT_EQ(ids.size(), size_t{kIds});
  // Half of a thousand, by less than eight standard deviations.
  for (const int count : ones) EXPECT_NEAR(count, kIds / 2, 126);
}

// In a child of its own whose getrandom() fails: no other source takes its place.
TEST(RandomId, ComesFromTheOperatingSystem) {
  sock_filter rules[] = {BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
                         BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_getrandom, 0, 1),
                         BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EIO),
                         BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)};
  const sock_fprog program{std::size(rules), rules};
  enum { kFailed = 1, kOther = 2, kNoFilter = 3 };
  const pid_t child = fork();
  if (child == 0) {
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 || prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) != 0)
      _exit(kNoFilter);
    try {
      random_id();
    } catch (const std::system_error& error) {
      _exit(error.code().value() == EIO ? kFailed : kOther);
    }
    _exit(kOther);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == kNoFilter) GTEST_SKIP() << "the system filters no calls";
  EXPECT_EQ(WEXITSTATUS(status), kFailed);
}

TEST(Secrets, AreEqualIfAllTheirBytesAre) {
  const std::string secret = random_id();
  EXPECT_TRUE(is_equal_secret(secret, std::string(secret)));
  EXPECT_TRUE(is_equal_secret("", ""));
  EXPECT_FALSE(is_equal_secret(secret, ""));
  EXPECT_FALSE(is_equal_secret(secret, secret + "0"));
  EXPECT_FALSE(is_equal_secret(secret, secret.substr(1)));
  for (size_t i = 0; i < secret.size(); ++i) {
    std::string other = secret;
    other[i] = static_cast<char>(other[i] ^ 1);
    EXPECT_FALSE(is_equal_secret(secret, other)) << i;
  }
}

}  // namespace
}  // namespace collided::server
