// Frames of a session whose results go to functions: in order, on one thread, from which the session may be used.
#include <gtest/gtest.h>

#include <future>
#include <memory>
#include <mutex>
#include <set>
#include <thread>

#include "tests/integration/client_library/client_ways.hpp"
#include "tests/integration/client_library/session_calls.hpp"
#include "tests/integration/client_library/session_daemon.hpp"

namespace collided::test {
namespace {

using client::Error;
using client::FrameResult;

Session open_session(const Client& client, client::Local use = client::Local::kAutomatic) {
  return Session::open(client, session_spec(kMode), SessionMeshes().inputs,
                       {.stream = {.window = 3, .local = {.use = use}}});
}

void submit(Session& session, uint64_t id, std::function<void(FrameResult)> done) {
  const SessionFrame frame = session_frame(id, kMode);
  session.submit(frame.updates(), std::move(done), frame.options);
}

/// Results as they come, until there are `count` of them.
class Results {
 public:
  explicit Results(size_t count) : count_(count) {}
  std::function<void(FrameResult)> take() {
    return [this](FrameResult result) {
      const std::lock_guard lock(mutex_);
      threads_.insert(std::this_thread::get_id());
      results_.push_back(std::move(result));
      if (results_.size() == count_) all_.set_value();
    };
  }
  std::vector<FrameResult>& wait() {
    all_.get_future().wait();
    const std::lock_guard lock(mutex_);
    return results_;
  }
  const std::set<std::thread::id>& threads() const { return threads_; }

 private:
  const size_t count_;
  std::mutex mutex_;
  std::vector<FrameResult> results_;
  std::set<std::thread::id> threads_;
  std::promise<void> all_;
};

TEST(SessionCallbacks, ComeInTheOrderOfTheFramesOnOneThread) {
  constexpr uint64_t kFrames = 15;
  LocalDaemon daemon;
  for (const Way way : kEveryWay) {
    const Client client = client_by(way, daemon.process().address());
    Session session = open_session(client, use_of(way)), other = open_session(client, use_of(way));
    Results results(kFrames);
    for (uint64_t id = 1; id <= kFrames; ++id) submit(session, id, results.take());
    uint64_t id = 0;
    for (FrameResult& result : results.wait()) {
      EXPECT_EQ(result.frame_id(), ++id);
      EXPECT_EQ(result.error(), nullptr);
      EXPECT_EQ(digest(result.output()), digest(detect(other, id))) << "frame " << id;
    }
    EXPECT_EQ(results.threads().size(), 1u);
    EXPECT_FALSE(results.threads().contains(std::this_thread::get_id()));
  }
}

TEST(SessionCallbacks, ARefusedFrameHasItsErrorInItsTurn) {
  Session session = open_session(local());
  Results results(3);
  const std::string few = pack_points({{0, 0, 0}});
  const FrameUpdate update{.mesh = kCloth, .positions = bytes_of(few)};
  submit(session, 1, results.take());
  session.submit({&update, 1}, results.take());
  submit(session, 2, results.take());
  std::vector<FrameResult>& all = results.wait();
  EXPECT_TRUE(all[0].ok());
  ASSERT_FALSE(all[1].ok());
  EXPECT_EQ(all[1].frame_id(), 2u);
  EXPECT_EQ(all[1].error()->field(), "frame.updates[0].positions");
  EXPECT_THROW(all[1].output(), Error);
  EXPECT_TRUE(all[2].ok());
}

TEST(SessionCallbacks, MaySubmitTheNextFrameEvenWhileTheWindowIsFull) {
  constexpr uint64_t kChain = 12;
  Session session = open_session(local());
  detect(session, 1);
  std::promise<void> end;
  uint64_t answered = 0;
  std::function<void(FrameResult)> next = [&](const FrameResult& result) {
    EXPECT_TRUE(result.ok());
    if (++answered == kChain) return end.set_value();
    if (answered < kChain) submit(session, 4, next);
  };
  for (uint32_t i = 0; i < session.window(); ++i) submit(session, 4, next);  // and as many more from this thread
  for (int i = 0; i < 10; ++i) detect(session, 4);
  end.get_future().wait();
  detect(session, 4);  // those that were submitted last are answered before it
}

TEST(SessionCallbacks, CannotWaitForTheirOwnSession) {
  Session session = open_session(local());
  std::promise<int> code;
  submit(session, 1, [&](const FrameResult&) {
    try {
      detect(session, 2);
      code.set_value(0);
    } catch (const Error& error) {
      code.set_value(error.code());
    }
  });
  EXPECT_EQ(code.get_future().get(), grpc::FAILED_PRECONDITION);
  EXPECT_TRUE(detect(session, 2).frame_id > 1);
}

TEST(SessionCallbacks, MayDestroyTheSessionWhoseOtherFramesThenFail) {
  LocalDaemon daemon;
  for (const Way way : kEveryWay) {
    auto session = std::make_unique<Session>(open_session(client_by(way, daemon.process().address()), use_of(way)));
    Results results(2);
    std::promise<void> submitted;
    submit(*session, 1, [&](const FrameResult&) {
      submitted.get_future().wait();
      session.reset();
    });
    for (const uint64_t id : {4, 9}) submit(*session, id, results.take());
    submitted.set_value();
    for (const FrameResult& result : results.wait()) {
      ASSERT_FALSE(result.ok());
      EXPECT_EQ(result.error()->code(), grpc::CANCELLED) << result.error()->what();
    }
    EXPECT_EQ(results.threads().size(), 1u);
  }
}

TEST(SessionCallbacks, MayCloseTheSession) {
  Client client = local();
  Session session = open_session(client);
  const std::string scene = session.scene().scene_id();
  std::promise<void> closed;
  submit(session, 1, [&](const FrameResult&) {
    session.close();
    closed.set_value();
  });
  closed.get_future().wait();
  EXPECT_THROW(client.get_scene(scene), Error);
  EXPECT_THROW(detect(session, 2), Error);
}

TEST(SessionCallbacks, AreCalledOnceIfTheSessionGivesUpOrEnds) {
  MortalDaemon daemon;
  Results lost(3), withdrawn(2);
  {
    Session session = Session::open(daemon.address(), session_spec(kMode), SessionMeshes().inputs,
                                    {.connect = {.patience = std::chrono::seconds(1)},
                                     .stream = {.window = 3},
                                     .max_attempts = 1,
                                     .first_pause = std::chrono::milliseconds(0)});
    detect(session, 1);
    daemon.pause();
    for (int i = 0; i < 3; ++i) submit(session, 4, lost.take());
    daemon.kill();
    for (const FrameResult& result : lost.wait()) EXPECT_EQ(result.error()->code(), grpc::UNAVAILABLE);
    daemon.start();
    detect(session, 4);
    daemon.pause();
    for (int i = 0; i < 2; ++i) submit(session, 4, withdrawn.take());
  }
  for (const FrameResult& result : withdrawn.wait()) EXPECT_EQ(result.error()->code(), grpc::CANCELLED);
  daemon.process().signal(SIGCONT);
}

TEST(SessionCallbacks, ThereHasToBeOne) {
  Session session = open_session(local());
  try {
    submit(session, 1, nullptr);
    ADD_FAILURE() << "nothing to call";
  } catch (const Error& error) {
    EXPECT_EQ(error.field(), "done");
  }
}

TEST(SessionCallbacksDeathTest, MustNotThrow) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        Session session = open_session(local());
        submit(session, 1, [](const FrameResult&) { throw std::runtime_error("from a callback"); });
        detect(session, 2);
      },
      ::testing::KilledBySignal(SIGABRT), "from a callback");
}

}  // namespace
}  // namespace collided::test
