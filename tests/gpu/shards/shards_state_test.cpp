// What parts of a scene hold, how they are refused, and that a frame counts in all of them or in none.

#include <map>
#include <set>

#include "tests/gpu/counted_quota.hpp"
#include "tests/gpu/shards/one_and_shards.hpp"
#include "tests/gpu/positions/owned_updates.hpp"
#include "tests/gpu/refused_field.hpp"
#include "tests/support/adversarial.hpp"

namespace collided::test {
namespace {

using PartsState = OnBackend<>;

SceneSpec certified(const Case& c) { return spec_for(c, settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF32)); }

/// Two soups: one that stays as thin as it is, and one of `size` large triangles in a corner of the scene.
Case thin_and_thick(double size) {
  Case c = soup(7, 400, 20, 0.5, 0.1);
  const Case other = soup(8, 1200, 2, 0.05, 0.1, {15, 15, 15});
  Case large = soup(8, 1200, 2, size, 0.1, {15, 15, 15});
  add_mesh(c, other.meshes[0].triangles, large.start[0], large.end[0]);
  return c;
}

/// Bytes of each part, by its name before the dot.
std::map<std::string, uint64_t> bytes_by_part(const Detector& detector) {
  std::map<std::string, uint64_t> bytes;
  for (const MemoryPart& part : detector.memory()) bytes[part.part.substr(0, part.part.find('.'))] += part.bytes;
  return bytes;
}

// Where one part has no room for what it finds the frame counts in none.
TEST_F(PartsState, OverflowOfOnePartRefusesTheFrame) {
  const Case thin = thin_and_thick(0.05), thick = thin_and_thick(1.5);
  SceneSpec spec = in_parts(certified(thin), 3);
  const auto roomy = Detector::create(spec);
  roomy->detect(Frame(thin, Mode::kCcd, Scalar::kF32).input());
  uint64_t most = 0;
  for (const auto& [part, bytes] : bytes_by_part(*roomy)) most = std::max(most, bytes);
  roomy->detect(Frame(thick, Mode::kCcd, Scalar::kF32).input());
  std::set<uint64_t> grown;
  for (const auto& [part, bytes] : bytes_by_part(*roomy)) grown.insert(bytes);

  spec.memory_budget = most + most / 8;
  const auto tight = Detector::create(spec);
  const auto one = Detector::create(certified(thin));
  const auto detect_in_both = [&](const Case& c, bool is_first) {
    const Frame frame(c, Mode::kCcd, Scalar::kF32, is_first);
    FrameInput input = frame.input();
    if (!is_first)
      for (MeshPositions& update : input.updates) update.start = {};  // begins where the last frame left it
    const FrameResult expected = one->detect(input);
    expect_same_frame(expected, tight->detect(input), Report::kAll);
  };
  detect_in_both(thin, true);
  EXPECT_THROW(tight->detect(Frame(thick, Mode::kCcd, Scalar::kF32).input()), ResourceExhausted);
  detect_in_both(thin_and_thick(0.06), false);
  EXPECT_GT(grown.size(), 1u);
}

class SharedQuota final : public MemoryQuota {
 public:
  void take(uint64_t bytes) override {
    const std::lock_guard lock(mutex_);
    counted_.take(bytes);
  }
  void give_back(uint64_t bytes) noexcept override {
    const std::lock_guard lock(mutex_);
    counted_.give_back(bytes);
  }
  uint64_t held() {
    const std::lock_guard lock(mutex_);
    return counted_.held();
  }
  void set_most(uint64_t most) {
    const std::lock_guard lock(mutex_);
    counted_.set_most(most);
  }

 private:
  std::mutex mutex_;
  CountedQuota counted_;
};

// The contacts of all parts together may be too many, when each part has found its own.
TEST_F(PartsState, AnswerWithoutRoomLeavesTheSceneAsItWas) {
  const Case c = soup(9, 400, 6, 1, 0.5);
  const auto quota = std::make_shared<SharedQuota>();
  SceneSpec spec = in_parts(certified(c), 2);
  spec.memory_quota = quota;
  auto detector = Detector::create(spec);
  const Frame frame(c, Mode::kCcd, Scalar::kF32);
  const FrameResult first = detector->detect(frame.input());
  ASSERT_GT(count_contacts(first), 0u);
  FrameInput next = frame.input();
  next.bytes_beside_contact = 1u << 20;
  quota->set_most(quota->held() + (1u << 20));
  EXPECT_THROW(detector->detect(next), ResourceExhausted);
  std::vector<std::byte> positions(12 * detector->topology().vertex_count);
  detector->read_positions({.count = detector->topology().vertex_count}, positions);
  EXPECT_EQ(positions, pack(c.end[0], Scalar::kF32));
  EXPECT_TRUE(same_contacts(first, detector->detect(frame.input())));
  detector = nullptr;
  EXPECT_GT(quota->held(), 0u);  // of the answer
}

TEST_F(PartsState, AnswersGiveTheirMemoryBack) {
  const Case c = soup(9, 200, 6, 1, 0.5);
  const auto quota = std::make_shared<SharedQuota>();
  SceneSpec spec = in_parts(certified(c), 3);
  spec.memory_quota = quota;
  {
    auto detector = Detector::create(spec);
    FrameResult result = detector->detect(Frame(c, Mode::kCcd, Scalar::kF32).input());
    detector = nullptr;
    EXPECT_GT(quota->held(), 0u);
  }
  EXPECT_EQ(quota->held(), 0u);
}

TEST_F(PartsState, PositionsComeBySlots) {
  const Case c = soup(10, 300, 6, 1, 0.5), larger = soup(11, 300, 6, 1, 0.5);
  const auto one = Detector::create(certified(c));
  const auto parts = Detector::create(in_parts(certified(c), 3));
  const auto slot = parts->make_slot(), other = parts->make_slot();
  const Frame first(c, Mode::kCcd, Scalar::kF32), second(larger, Mode::kCcd, Scalar::kF32);
  FrameInput ends = first.input();
  for (MeshPositions& update : ends.updates) update.start = {};
  for (const FrameInput& frame : {ends, second.input(), ends}) {
    const FrameInput by_slot = sent(frame.updates.size() % 2 == 0 ? slot : other, frame.updates);
    expect_same_frame(one->detect(frame), parts->detect(by_slot), Report::kAll);
  }
  // Sent again into more room while the bytes of before may still be on their way.
  sent(slot, ends.updates);
  expect_same_frame(one->detect(second.input()), parts->detect(sent(slot, second.input().updates)), Report::kAll);
  EXPECT_EQ("slot", refused_field([&] { parts->detect({.updates = {}, .slot = one->make_slot()}); }));
  EXPECT_EQ("slot", refused_field([&] { one->detect({.updates = {}, .slot = slot}); }));
  EXPECT_EQ("slot", refused_field([&] { parts->detect({.updates = {}, .slot = parts->make_slot()}); }));
}

TEST_F(PartsState, WhatDoesNotGoWithPartsIsNamed) {
  const Case c = soup(12, 20, 6, 1, 0.5);
  const auto field = [&](auto change) {
    SceneSpec spec = in_parts(certified(c), 2);
    change(spec);
    return refused_field([&] { Detector::create(spec); });
  };
  EXPECT_EQ("", field([](SceneSpec&) {}));
  EXPECT_EQ("part_devices", field([](SceneSpec& spec) { spec.worlds = 2; }));
  EXPECT_EQ("reuse", field([](SceneSpec& spec) { spec.reuse = Reuse::kOn; }));
  EXPECT_EQ("part_devices", field([](SceneSpec& spec) { spec.part_devices.assign(kMaxShards + 1, spec.device); }));
  EXPECT_EQ("part_devices[1]", field([](SceneSpec& spec) {
              spec.part_devices[1].backend = kBackend == Backend::kCpu ? Backend::kCuda : Backend::kCpu;
            }));
  EXPECT_EQ("part_devices[0]", field([](SceneSpec& spec) { spec.part_devices[0].ordinal = -1; }));
  const auto detector = Detector::create(in_parts(certified(c), 2));
  alignas(64) std::byte memory[64];
  const Frame frame(c, Mode::kCcd, Scalar::kF32);
  FrameInput input = frame.input();
  input.room.memory = memory;
  EXPECT_EQ("room", refused_field([&] { detector->detect(input); }));
}

TEST_F(PartsState, EstimateTellsWhatEachDeviceHolds) {
  const Case c = soup(90, 300, 1e6, 0.1, 0);
  const SceneSpec spec = certified(c);
  const auto estimate = [&](const SceneSpec& of) { return estimate_scene(of, 900, 300); };
  const auto one = estimate(spec), three = estimate(in_parts(spec, 3));
  uint64_t bytes_of_one = 0;
  for (const MemoryPart& part : one.memory) bytes_of_one += part.bytes;
  std::map<std::string, uint64_t> parts;
  for (const MemoryPart& part : three.memory) parts[part.part.substr(0, part.part.find('.'))] += part.bytes;
  ASSERT_EQ(parts.size(), 3u);
  for (const auto& [name, bytes] : parts) {
    EXPECT_GE(bytes, bytes_of_one) << name;
    EXPECT_LE(bytes, bytes_of_one + sizeof(uint64_t) * 8) << name;  // and its share
  }
  EXPECT_EQ(three.stages.back(), "merge");
  const auto detector = Detector::create(in_parts(spec, 3));
  detector->detect(Frame(c, Mode::kCcd, Scalar::kF32).input());
  const auto held = bytes_by_part(*detector);
  for (const auto& [name, bytes] : parts) EXPECT_GE(held.at(name), bytes);
  EXPECT_GE(min_scene_bytes(in_parts(spec, 3), 900, 300), 3 * min_scene_bytes(spec, 900, 300));
}

}  // namespace
}  // namespace collided::test
