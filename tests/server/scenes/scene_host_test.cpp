// All scenes: limits, leases, idle streams, the stop.
#include "server/scenes/scene_host.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "tests/server/frames/session_test.hpp"

namespace collided::server {
namespace {

Config config_with(const Limits& limits) {
  Config config;
  config.backend = "cpu";
  config.threads = 1;
  config.limits = limits;
  return config;
}

// Creates a scene as the daemon does: one that cannot be built is deleted.
SceneUse make_scene(SceneHost& host, const Client& owner = client(), double lease_seconds = 30) {
  const auto added = host.add_scene(owner, {tip_plan(), "", 0, lease_seconds});
  std::exception_ptr failure;
  added.scene->worker().post([&] {
    try {
      added.scene->engine().build_if_complete();
    } catch (...) {
      failure = std::current_exception();
    }
  });
  added.scene->worker().flush();
  if (!failure) return added.scene;
  host.scenes().remove(owner, added.scene->id());
  std::rethrow_exception(failure);
}

struct Stream {
  explicit Stream(const SceneUse& scene) : session(FrameSession::open(scene, "", Delivery::kLossless, sink)) {}
  std::shared_ptr<RecordingSink> sink = std::make_shared<RecordingSink>();
  std::shared_ptr<FrameSession> session;
};

template <class Body>
std::string refused_subject(const Body& body) {
  try {
    body();
  } catch (const LimitExceeded& e) {
    return e.subject();
  }
  return "nobody";
}

TEST(SceneHost, AClientOverItsDeviceBytesGetsNoScene) {
  CountingObserver observer;
  SceneHost host(config_with({}), observer);
  ClientLimits little;
  little.max_device_bytes = 100;
  const auto owner = client("little", little);
  EXPECT_EQ(refused_subject([&] { make_scene(host, owner); }), "client:little");
  EXPECT_TRUE(host.scenes().all().empty());
  EXPECT_TRUE(wait_until([&] { return host.usage().device_bytes(owner)->held() == 0; }));
  EXPECT_EQ(refused_subject([&] { make_scene(host); }), "nobody");
}

TEST(SceneHost, AllScenesTogetherStayWithinTheDaemonsBytes) {
  CountingObserver observer;
  SceneHost host(config_with({}), observer);
  make_scene(host);
  const uint64_t one = host.totals().device_bytes;
  EXPECT_GT(one, 0u);
  EXPECT_EQ(host.usage().device_bytes(client())->held(), one);
  Limits limits;
  limits.max_device_bytes = 2 * one + one / 2;  // creating a scene takes some temporarily
  host.set_limits(limits);
  EXPECT_EQ(host.limits(), limits);
  const auto second = make_scene(host, client("another"));
  EXPECT_EQ(refused_subject([&] { make_scene(host, client("third")); }), "daemon");
  host.scenes().remove(client("another"), second->id());
  second->worker().post([&] { second->release(); });
  second->worker().flush();
  EXPECT_EQ(refused_subject([&] { make_scene(host, client("third")); }), "nobody");
}

TEST(SceneHost, AFramePastTheClientsBytesIsRefusedAndTheSceneGoesOn) {
  CountingObserver observer;
  SceneHost host(config_with({}), observer);
  const auto scene = make_scene(host);
  const auto bytes = host.usage().device_bytes(client());
  bytes->set_max(bytes->held());
  const Stream stream(scene);
  stream.session->submit(tip_frame(1, 2));
  EXPECT_EQ(stream.sink->wait_for(2).back(), "refused 1: RESOURCE_EXHAUSTED");
  bytes->set_max(ClientLimits{}.max_device_bytes);
  stream.session->submit(tip_frame(1, 2));
  EXPECT_EQ(stream.sink->wait_for(3).back(), "answered 1");
}

TEST(SceneHost, NewLimitsHoldForNewScenes) {
  CountingObserver observer;
  SceneHost host(config_with({}), observer);
  make_scene(host), make_scene(host);
  Limits limits;
  limits.max_scenes = 2;
  host.set_limits(limits);
  EXPECT_EQ(refused_subject([&] { make_scene(host); }), "daemon");
  EXPECT_EQ(host.totals().scenes, 2u);
}

TEST(SceneHost, ASceneWhoseLeaseRanOutIsDeleted) {
  CountingObserver observer;
  const HandClock clock;
  SceneHost host(config_with({}), observer, clock.now());
  const auto kept = make_scene(host, client(), 10);
  const auto id = make_scene(host, client(), 10)->id();
  make_scene(host, client(), 20);
  clock.move(std::chrono::seconds(9));
  host.watch_once();
  EXPECT_EQ(host.totals().scenes, 3u);
  clock.move(std::chrono::seconds(2));
  EXPECT_TRUE(wait_until([&] { return observer.expiries > 0; }));
  EXPECT_THROW(host.scenes().find(client(), id), NotFound);
  EXPECT_EQ(host.scenes().find(client(), kept->id())->id(), kept->id());
  EXPECT_EQ(observer.expiries, 1);
  EXPECT_EQ(host.totals().scenes, 2u);
  const auto held = [&] { return host.usage().device_bytes(client())->held(); };
  EXPECT_TRUE(wait_until([&] { return held() == host.totals().device_bytes; }));
}

TEST(SceneHost, AStreamThatIsIdleForTooLongEnds) {
  CountingObserver observer;
  const HandClock clock;
  Limits limits;
  limits.max_idle_seconds = 5;
  SceneHost host(config_with(limits), observer, clock.now());
  const auto slow = make_scene(host), deaf = make_scene(host), idle = make_scene(host);
  const Stream takes_a_little(slow), takes_nothing(deaf), says_nothing(idle);
  for (const auto* stream : {&takes_a_little, &takes_nothing}) {
    stream->session->hold(true);
    stream->session->submit(tip_frame(1, 2));
  }
  for (const auto* stream : {&takes_a_little, &takes_nothing, &says_nothing}) stream->sink->wait_for(1);
  clock.move(std::chrono::seconds(4));
  takes_a_little.session->hold(true);
  host.watch_once();
  EXPECT_FALSE(says_nothing.session->is_closed());
  clock.move(std::chrono::seconds(2));
  host.watch_once();
  const RecordingSink::Events ended{"opened after 0", "ended: LimitExceeded"};
  EXPECT_EQ(says_nothing.sink->wait_for(2), ended);
  EXPECT_EQ(takes_nothing.sink->wait_for(2), ended);
  EXPECT_EQ(idle->record().stream(), nullptr);
  EXPECT_FALSE(takes_a_little.session->is_closed());
  takes_a_little.session->hold(false);
  EXPECT_EQ(takes_a_little.sink->wait_for(2).back(), "answered 1");
}

TEST(SceneHost, TheStopIsToldAndNothingNewBegins) {
  CountingObserver observer;
  SceneHost host(config_with({}), observer);
  const auto first = make_scene(host), second = make_scene(host), silent = make_scene(host);
  const Stream a(first), b(second);
  host.check_serving();
  host.announce_stop(1.5);
  for (const Stream* stream : {&a, &b}) {
    const auto events = stream->sink->wait_for(2);
    EXPECT_EQ(std::count(events.begin(), events.end(), "draining 1.5"), 1);
    stream->session->submit(tip_frame(1, 2));
    EXPECT_EQ(stream->sink->wait_for(3).back(), "answered 1");  // open streams continue
  }
  EXPECT_THROW(host.check_serving(), Stopping);
  EXPECT_THROW(host.add_scene(client(), {tip_plan(), "", 0, 30}), Stopping);
}

// A stream that the client already sees as open is drained like any other, however late it became the scene's.
TEST(SceneHost, AStreamThatOpensDuringTheStopIsToldOfItOnce) {
  CountingObserver observer;
  SceneHost host(config_with({}), observer);
  const auto before = make_scene(host), after = make_scene(host);
  const Stream told(before);
  host.announce_stop(1.5);
  const Stream late(after);
  for (const Stream* stream : {&told, &late}) {
    host.tell_of_stop(*stream->session);
    stream->session->submit(tip_frame(1, 2));
    EXPECT_EQ(stream->sink->wait_for(3), (RecordingSink::Events{"opened after 0", "draining 1.5", "answered 1"}));
  }
  host.end_streams();
  EXPECT_EQ(late.sink->wait_for(4).back(), "ended: Stopping");
  EXPECT_THROW(host.tell_of_stop(*late.session), Stopping);
}

TEST(SceneHost, TotalsAreOfAllScenes) {
  CountingObserver observer;
  SceneHost host(config_with({}), observer);
  const auto first = make_scene(host), second = make_scene(host, client("another"));
  const auto place = host.usage().begin_stream(client());
  const Stream a(first), b(second);
  a.session->hold(true), b.session->hold(true);
  for (uint64_t id = 1; id <= 3; ++id) a.session->submit(tip_frame(id, 2));
  b.session->submit(tip_frame(1, 2));
  const HostTotals totals = host.totals();
  EXPECT_EQ(totals.scenes, 2u);
  EXPECT_EQ(totals.streams, 1u);
  EXPECT_EQ(totals.waiting_frames, 4u);
  EXPECT_EQ(totals.device_bytes,
            host.usage().device_bytes(client())->held() + host.usage().device_bytes(client("another"))->held());
}

TEST(SceneHost, ItsEndEndsEverything) {
  CountingObserver observer;
  std::optional<SceneHost> host(std::in_place, config_with({}), observer);
  const auto sink = std::make_shared<RecordingSink>();
  {
    const auto scene = make_scene(*host);
    FrameSession::open(scene, "", Delivery::kLossless, sink)->submit(tip_frame(1, 2));
  }
  host.reset();
  EXPECT_EQ(sink->events().back(), "ended: NotFound");
}

TEST(SceneHost, ManyThreadsAtOnceAndTheStopAmongThem) {
  CountingObserver observer;
  SceneHost host(config_with({}), observer);
  std::vector<std::thread> threads;
  std::atomic<int> made = 0;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&, owner = client("c" + std::to_string(t % 2))] {
      for (int i = 0; i < 8; ++i) try {  // as many scenes as a client may have
          const auto scene = make_scene(host, owner, 1e-3);
          const auto place = host.usage().begin_stream(owner);
          const Stream stream(scene);
          stream.session->submit(tip_frame(1, 2));
          ++made;
          host.set_limits(host.limits());
          EXPECT_GE(host.totals().scenes, 1u);
          if (i % 2 == 0) stream.session->close();
        } catch (const Stopping&) {
        }
    });
  wait_until([&] { return made >= 10; });
  host.announce_stop(1);
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(host.usage().streams(), 0u);
}

}  // namespace
}  // namespace collided::server
