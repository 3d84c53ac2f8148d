// All resident scenes: owners, request ids, limits, leases, and returned memory.
#include "server/scenes/scene_store.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <set>
#include <thread>

#include "server/devices/device_bytes.hpp"
#include "server/errors.hpp"
#include "tests/server/frames/session_test.hpp"

namespace collided::server {
namespace {

using std::chrono::seconds;
using Clock = std::chrono::steady_clock;

class SceneStoreTest : public testing::Test {
 protected:
  SceneRequest request(const std::string& id = "", uint64_t fingerprint = 1, double lease_seconds = 30) const {
    SceneRequest request{tip_plan(), id, fingerprint, lease_seconds};
    request.plan.quota = held_;
    return request;
  }
  std::string add_id(const Client& owner) { return bench_.scenes.add(owner, request()).scene->id(); }

  const std::shared_ptr<DeviceBytes> held_ = std::make_shared<DeviceBytes>("daemon", "limit", uint64_t{1} << 30);
  const Client ann_ = client("ann"), ben_ = client("ben");
  SceneBench bench_{8};
  SceneStore& store_ = bench_.scenes;
};

std::vector<std::string> ids(const std::vector<std::shared_ptr<Scene>>& scenes) {
  std::vector<std::string> out;
  for (const auto& scene : scenes) out.push_back(scene->id());
  return out;
}

TEST_F(SceneStoreTest, AnotherClientsSceneDoesNotExist) {
  const auto id = add_id(ann_);
  EXPECT_EQ(store_.find(ann_, id)->id(), id);
  EXPECT_THROW(store_.find(ben_, id), NotFound);
  EXPECT_THROW(store_.remove(ben_, id), NotFound);
  EXPECT_THROW(store_.find(ann_, id.substr(1)), NotFound);
  EXPECT_THROW(store_.find(ann_, ""), NotFound);
  EXPECT_EQ(store_.find(client("ann"), id)->id(), id);  // the same name on another connection
  store_.remove(ann_, id);
  EXPECT_THROW(store_.find(ann_, id), NotFound);
  EXPECT_THROW(store_.remove(ann_, id), NotFound);
}

TEST_F(SceneStoreTest, WhatAnIdThatIsTooLongWasIsNotToldInFull) {
  try {
    store_.find(ann_, std::string(100'000, 'x'));
    FAIL();
  } catch (const NotFound& e) {
    EXPECT_EQ(e.field(), "scene_id");
    EXPECT_LT(std::string(e.what()).size(), 200u);
  }
}

std::string why_not_found(const SceneStore& store, const Client& owner, const std::string& id) {
  try {
    store.find(owner, id);
  } catch (const NotFound& e) {
    return e.what();
  }
  return "found";
}

TEST_F(SceneStoreTest, ItsOwnerIsToldHowASceneEnded) {
  const auto deleted = add_id(ann_), expired = store_.add(ann_, request("", 1, 10)).scene->id();
  store_.remove(ann_, deleted);
  ASSERT_EQ(store_.remove_expired(Clock::now() + seconds(11)).size(), 1u);
  EXPECT_EQ(why_not_found(store_, ann_, deleted), "scene_id is \"" + deleted + "\", which was deleted");
  EXPECT_EQ(why_not_found(store_, ann_, expired),
            "scene_id is \"" + expired +
                "\", which was deleted, as its lease of 10 s ran out 0 s ago: create it again, or ask for a longer "
                "lease_seconds");
  for (const auto& id : {deleted, expired})
    EXPECT_EQ(why_not_found(store_, ben_, id), "scene_id is \"" + id + "\", which does not exist");
}

TEST(EndedScenes, TheOldestOfAClientIsForgotten) {
  EndedScenes ended;
  ended.add("ben", "his", {});
  for (size_t i = 0; i <= EndedScenes::kMaxPerClient; ++i) ended.add("ann", std::to_string(i), {});
  EXPECT_EQ(ended.find("ann", "0"), nullptr);
  EXPECT_NE(ended.find("ann", "1"), nullptr);
  EXPECT_NE(ended.find("ben", "his"), nullptr);
  EXPECT_EQ(ended.find("ann", "his"), nullptr);
}

TEST(EndedScenes, ALeaseTellsItsLengthAndItsEnd) {
  const SceneEnd end{true, 30, Clock::now()};
  EXPECT_EQ(end.text(end.when + seconds(12)),
            "was deleted, as its lease of 30 s ran out 12 s ago: create it again, or ask for a longer lease_seconds");
}

TEST_F(SceneStoreTest, ARepeatedRequestAnswersWithTheSameScene) {
  const auto first = store_.add(ann_, request("mine"));
  const auto again = store_.add(ann_, request("mine"));
  EXPECT_TRUE(first.is_new);
  EXPECT_FALSE(again.is_new);
  EXPECT_EQ(first.scene->id(), again.scene->id());
  EXPECT_EQ(store_.all().size(), 1u);
  EXPECT_THROW(store_.add(ann_, request("mine", 2)), AlreadyExists);
  const auto of_ben = store_.add(ben_, request("mine", 2));
  EXPECT_TRUE(of_ben.is_new);
  const auto nameless = store_.add(ann_, request()), other = store_.add(ann_, request());
  EXPECT_TRUE(nameless.is_new && other.is_new);
}

TEST_F(SceneStoreTest, ARequestIdIsFreeOnceItsSceneIsGone) {
  const auto id = store_.add(ann_, request("mine")).scene->id();
  store_.remove(ann_, id);
  const auto anew = store_.add(ann_, request("mine", 2));
  EXPECT_TRUE(anew.is_new);
  EXPECT_NE(anew.scene->id(), id);
}

TEST_F(SceneStoreTest, ARepeatedRequestPassesWhereNoNewOneDoes) {
  store_.set_max_scenes(1);
  const auto id = store_.add(ann_, request("mine")).scene->id();
  EXPECT_THROW(store_.add(ann_, request("another")), LimitExceeded);
  EXPECT_EQ(store_.add(ann_, request("mine")).scene->id(), id);
}

TEST_F(SceneStoreTest, LimitsAreTheDaemonsAndTheClients) {
  ClientLimits two;
  two.max_scenes = 2;
  const auto modest = client("modest", two);
  const auto refused_for = [&](const Client& owner) {
    try {
      store_.add(owner, request());
    } catch (const LimitExceeded& e) {
      return e.subject();
    }
    return std::string("nobody");
  };
  for (int i = 0; i < 2; ++i) EXPECT_EQ(refused_for(modest), "nobody");
  EXPECT_EQ(refused_for(modest), "client:modest");
  for (int i = 0; i < 6; ++i) EXPECT_EQ(refused_for(ann_), "nobody");
  EXPECT_EQ(refused_for(ann_), "daemon");
  store_.remove(modest, store_.page(modest, "", 1).at(0)->id());
  EXPECT_EQ(refused_for(modest), "nobody");
  store_.set_max_scenes(9);
  EXPECT_EQ(refused_for(ann_), "nobody");
  EXPECT_EQ(store_.all().size(), 9u);
}

TEST_F(SceneStoreTest, PagesHoldAClientsScenesInTheOrderOfTheirIds) {
  std::set<std::string> of_ann;
  for (int i = 0; i < 5; ++i) of_ann.insert(add_id(ann_));
  for (int i = 0; i < 3; ++i) add_id(ben_);
  const std::vector<std::string> sorted(of_ann.begin(), of_ann.end());
  EXPECT_EQ(ids(store_.page(ann_, "", 100)), sorted);
  EXPECT_EQ(ids(store_.page(ann_, "", 2)), std::vector(sorted.begin(), sorted.begin() + 2));
  EXPECT_EQ(ids(store_.page(ann_, sorted[1], 2)), std::vector(sorted.begin() + 2, sorted.begin() + 4));
  store_.remove(ann_, sorted[3]);  // the page after one that is gone
  EXPECT_EQ(ids(store_.page(ann_, sorted[3], 2)), std::vector{sorted[4]});
  EXPECT_TRUE(store_.page(ann_, sorted[4], 2).empty());
  EXPECT_TRUE(store_.page(ann_, "", 0).empty());
  EXPECT_EQ(store_.page(ben_, "", 100).size(), 3u);
}

TEST_F(SceneStoreTest, ADeletedScenesMemoryIsFreeAtOnceThoughItIsStillInUse) {
  const SceneUse use = bench_.add(ann_, request());
  const auto sink = std::make_shared<RecordingSink>();
  const auto session = FrameSession::open(use, "", Delivery::kLossless, sink);
  session->submit(tip_frame(1, 2));
  sink->wait_for(2);
  session->hold(true);
  for (uint64_t id = 2; id < 6; ++id) {  // that wait in slots
    auto frame = tip_frame(id, 2);
    frame.input.slot = use->engine().take_slot();
    frame.input.slot->room(1000);
    session->submit(std::move(frame));
  }
  EXPECT_GT(held_->held(), 5 * 1000u);
  const auto removed = store_.remove(ann_, use->id());
  removed->worker().post([&] { removed->release(); });
  removed->worker().flush();
  EXPECT_EQ(held_->held(), 0u);
  EXPECT_EQ(sink->events().back(), "ended: NotFound");
}

TEST_F(SceneStoreTest, ALeaseRunsWhileNobodyUsesTheScene) {
  SceneUse use = bench_.add(ann_, request("mine", 1, 10));
  const auto id = use->id();
  const auto later = [](int lease) { return Clock::now() + seconds(1 + lease); };
  EXPECT_TRUE(store_.remove_expired(later(1000)).empty());
  SceneUse second = use;
  use = {};
  EXPECT_TRUE(store_.remove_expired(later(1000)).empty());
  second = {};
  EXPECT_TRUE(store_.remove_expired(Clock::now()).empty());
  const auto expired = store_.remove_expired(later(10));
  ASSERT_EQ(ids(expired), std::vector{id});
  EXPECT_THROW(store_.find(ann_, id), NotFound);
  EXPECT_THROW(expired[0]->record().check_open(), NotFound);
  expired[0]->worker().flush();
  EXPECT_EQ(held_->held(), 0u);
  EXPECT_TRUE(store_.add(ann_, request("mine", 2)).is_new);
}

TEST_F(SceneStoreTest, AStreamKeepsItsSceneAndTheLeaseBeginsAnewAfterIt) {
  SceneUse use = bench_.add(ann_, request("", 1, 10));
  auto session = FrameSession::open(use, "", Delivery::kLossless, std::make_shared<RecordingSink>());
  use->worker().flush();
  use = {};
  EXPECT_TRUE(store_.remove_expired(Clock::now() + seconds(1000)).empty());
  session->close();
  session.reset();
  EXPECT_TRUE(store_.remove_expired(Clock::now()).empty());
  EXPECT_EQ(store_.remove_expired(Clock::now() + seconds(1000)).size(), 1u);
}

TEST_F(SceneStoreTest, ClearFreesAllScenes) {
  const auto use = bench_.add(ann_, request("mine"));
  bench_.add(ben_, request());
  store_.clear();
  EXPECT_TRUE(store_.all().empty());
  EXPECT_THROW(use->record().check_open(), NotFound);
  EXPECT_TRUE(store_.add(ann_, request("mine", 2)).is_new);
}

// Its jobs use what the daemon destroys next.
TEST_F(SceneStoreTest, ClearWaitsForTheWorkOfRemovedScenesToo) {
  std::atomic<int> done = 0;
  const auto add_busy = [&](double lease_seconds) {
    const auto scene = store_.add(ann_, request("", 1, lease_seconds)).scene.scene();
    scene->worker().post([scene, &done] {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      ++done;
    });
    return scene->id();
  };
  add_busy(1);
  store_.remove_expired(Clock::now() + seconds(5));
  store_.remove(ann_, add_busy(30));
  store_.clear();
  EXPECT_EQ(done, 2);
}

TEST_F(SceneStoreTest, OfRequestsAtOnceOneMakesTheScene) {
  std::vector<std::string> made(6);
  std::atomic<int> new_ones = 0;
  std::vector<std::thread> threads;
  for (auto& id : made)
    threads.emplace_back([&] {
      const auto added = store_.add(ann_, request("mine"));
      new_ones += added.is_new;
      id = added.scene->id();
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(new_ones, 1);
  EXPECT_EQ(std::set(made.begin(), made.end()).size(), 1u);
}

// As in the daemon: the job that builds the detector finds a scene that was deleted meanwhile.
void build(const SceneUse& scene) {
  scene->worker().post([scene] {
    try {
      scene->engine().build_if_complete();
    } catch (const NotFound&) {
    }
  });
}

TEST_F(SceneStoreTest, ManyThreadsMakeFindAndDelete) {
  std::atomic<int> made = 0;
  const auto churn = [&](const Client& owner, int begin) {
    for (int i = begin; i < begin + 20; ++i) try {
        const auto added = store_.add(owner, request(std::to_string(i % 3), 1, 0.001));
        made += added.is_new;
        if (added.is_new) build(added.scene);
        EXPECT_EQ(store_.find(owner, added.scene->id())->id(), added.scene->id());
        if (i % 2 == 0) store_.remove(owner, added.scene->id());
      } catch (const NotFound&) {  // another thread was faster
      }
  };
  std::atomic<bool> stop = false;
  std::thread watch([&] {
    while (!stop) {
      store_.remove_expired(Clock::now());
      for (const auto& scene : store_.all()) EXPECT_EQ(scene->snapshot().triangles, 2u);
      EXPECT_LE(store_.page(ann_, "", 100).size(), 8u);
    }
  });
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) threads.emplace_back([&, t] { churn(t % 2 == 0 ? ann_ : ben_, t); });
  for (auto& thread : threads) thread.join();
  stop = true;
  watch.join();
  EXPECT_GT(made, 0);
  store_.clear();
  EXPECT_TRUE(wait_until([&] { return held_->held() == 0; }));
}

}  // namespace
}  // namespace collided::server
