// A host that gives the daemon no more threads: calls are told so, and served again once it does.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "tests/integration/bystander.hpp"

namespace collided::test {
namespace {

constexpr rlim_t kNone = 1;  // one process or thread, which the user has

/// While it lives the daemon gets no further thread.
class WithoutThreads {
 public:
  WithoutThreads(pid_t daemon, uid_t user) : daemon_(daemon), user_(user) {
    getrlimit(RLIMIT_NPROC, &before_);  // the daemon has inherited it
    set({kNone, before_.rlim_max});
  }
  ~WithoutThreads() { set(before_); }
  WithoutThreads(const WithoutThreads&) = delete;
  WithoutThreads& operator=(const WithoutThreads&) = delete;

 private:
  // By a process of the same user: root may not everywhere.
  void set(const rlimit& limit) const {
    const pid_t child = fork();
    if (child == 0) {
      if (user_ && (setgid(user_) != 0 || setuid(user_) != 0)) _exit(1);
      _exit(prlimit(daemon_, RLIMIT_NPROC, &limit, nullptr) == 0 ? 0 : 1);
    }
    int status = -1;
    EXPECT_EQ(waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0) << "the limit is not set";
  }

  const pid_t daemon_;
  const uid_t user_;
  rlimit before_{};
};

TEST(NoThreads, ACallThatNeedsOneIsToldAndTheDaemonGoesOn) {
  constexpr uid_t kSomebody = 64'815;  // root has no such limit
  const uid_t user = getuid() == 0 ? kSomebody : 0;
  DaemonProcess daemon({}, "cpu", 0, user);
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  const Bystander bystander(connect_by(daemon.address()));
  {
    const WithoutThreads without(daemon.pid(), user);
    for (int i = 0; i < 8; ++i) {
      const auto status = create_scene(*stub, tip_request());
      expect_quota(status, "out of threads", "daemon");
    }
    bystander.expect_served();
    EXPECT_EQ(list_scenes(*stub).size(), 1u);  // the bystander's
  }
  expect_new_client_served(daemon.address());
}

}  // namespace
}  // namespace collided::test
