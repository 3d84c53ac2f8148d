// Positions by slots: the same answers as positions in the frame, sent beside a frame in work, refused without harm.

#include <cmath>
#include <cstdlib>
#include <thread>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/positions/owned_updates.hpp"
#include "tests/gpu/refused_field.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

/// A motion in steps; all frames own their bytes.
struct Motion {
  explicit Motion(Scalar scalar, int steps = 6) {
    const auto scene = scenes::make_scene("funnel", 0.3);
    for (int step = 0; step < steps; ++step) {
      const Case c = rounded(case_of(*scene, 0.4 + 0.02 * step, 0.42 + 0.02 * step), scalar);
      frames.emplace_back(c, Mode::kCcd, scalar, step == 0);
      if (step == 0) spec = spec_for(c, settings(Mode::kCcd, Accuracy::kFast, scalar));
    }
    auto detector = Detector::create(spec);
    for (const Frame& frame : frames) expected.push_back(detector->detect(frame.input()));
  }

  SceneSpec spec;
  std::vector<Frame> frames;
  std::vector<FrameResult> expected;  ///< of each frame, its positions in the frame
};

class Slots : public OnBackend<::testing::TestWithParam<Scalar>> {};

TEST_P(Slots, GiveTheSameAnswers) {
  const Motion motion(GetParam());
  auto detector = Detector::create(motion.spec);
  const auto slot = detector->make_slot();
  for (size_t i = 0; i < motion.frames.size(); ++i)
    EXPECT_TRUE(same_contacts(motion.expected[i], detector->detect(sent(slot, motion.frames[i].input().updates)))) << i;
}

TEST_P(Slots, TakeBytesThatLieElsewhere) {
  const Motion motion(GetParam());
  auto detector = Detector::create(motion.spec);
  FrameInput input;
  input.slot = detector->make_slot();
  for (size_t i = 0; i < motion.frames.size(); ++i) {
    input.slot->send(motion.frames[i].input().updates);
    EXPECT_TRUE(same_contacts(motion.expected[i], detector->detect(input))) << i;
  }
}

// Also where no number is aligned.
TEST_P(Slots, TakeBytesAnywhereInTheirRoom) {
  const Motion motion(GetParam(), 3);
  auto detector = Detector::create(motion.spec);
  FrameInput input;
  input.slot = detector->make_slot();
  for (size_t i = 0; i < motion.frames.size(); ++i) {
    const std::vector<MeshPositions> updates = motion.frames[i].input().updates;
    input.slot->send(moved_to(input.slot->room(bytes_in(updates) + 1 + i), updates, 1 + i));
    EXPECT_TRUE(same_contacts(motion.expected[i], detector->detect(input))) << i;
  }
}

TEST_P(Slots, AreFilledBesideAFrameInWork) {
  const Motion motion(GetParam(), 12);
  auto detector = Detector::create(motion.spec);
  FrameInput now = sent(detector->make_slot(), motion.frames[0].input().updates), next;
  for (size_t i = 0; i < motion.frames.size(); ++i) {
    std::thread filler([&, i] {
      if (i + 1 == motion.frames.size()) return;
      if (next.slot == nullptr || i % 5 == 4) next.slot = detector->make_slot();
      next = sent(next.slot, motion.frames[i + 1].input().updates);
      detector->device();
    });
    const FrameResult result = detector->detect(now);
    filler.join();
    EXPECT_TRUE(same_contacts(motion.expected[i], result)) << i;
    std::swap(now, next);
  }
}

TEST_P(Slots, MixWithPositionsInTheFrame) {
  const Motion motion(GetParam());
  auto detector = Detector::create(motion.spec);
  const auto slot = detector->make_slot();
  for (size_t i = 0; i < motion.frames.size(); ++i) {
    const FrameInput plain = motion.frames[i].input();
    EXPECT_TRUE(same_contacts(motion.expected[i], detector->detect(i % 2 == 0 ? plain : sent(slot, plain.updates))))
        << i;
  }
}

TEST_P(Slots, WhatWasThereWhenItWasSentCounts) {
  const Motion motion(GetParam(), 1);
  auto detector = Detector::create(motion.spec);
  const std::vector<MeshPositions> updates = motion.frames[0].input().updates;
  std::vector<std::byte> shared(bytes_in(updates));
  FrameInput input;
  input.slot = detector->make_slot();
  input.slot->send(moved_to(shared, updates));
  std::fill(shared.begin(), shared.end(), std::byte{0xff});  // NaN everywhere
  EXPECT_TRUE(same_contacts(motion.expected[0], detector->detect(input)));
}

// The memory of others stays mapped where it is; the backend reads it there.
TEST_P(Slots, TakeRegisteredMemory) {
  const Motion motion(GetParam());
  auto detector = Detector::create(motion.spec);
  constexpr uint64_t kPage = 4096;
  const uint64_t bytes = (bytes_in(motion.frames[0].input().updates) / kPage + 2) * kPage;
  const std::unique_ptr<std::byte, void (*)(void*)> memory(static_cast<std::byte*>(std::aligned_alloc(kPage, bytes)),
                                                           std::free);
  const auto registered = register_host_memory({kBackend}, {memory.get(), bytes});
  ASSERT_EQ(registered->bytes().data(), memory.get());
  ASSERT_EQ(registered->bytes().size(), bytes);
  FrameInput input;
  input.slot = detector->make_slot();
  for (size_t i = 0; i < motion.frames.size(); ++i) {
    input.slot->send(moved_to(registered->bytes(), motion.frames[i].input().updates, i % 3));
    EXPECT_TRUE(same_contacts(motion.expected[i], detector->detect(input))) << i;
  }
}

TEST_P(Slots, MayBeTriedAgainAfterACancelledFrame) {
  const Motion motion(GetParam(), 2);
  auto detector = Detector::create(motion.spec);
  detector->detect(motion.frames[0].input());
  FrameInput input = sent(detector->make_slot(), motion.frames[1].input().updates);
  for (int answers = 0; answers < 3; ++answers) {
    int asked = 0;
    input.cancelled = [&] { return asked++ == answers; };
    EXPECT_THROW(detector->detect(input), Cancelled);
  }
  input.cancelled = {};
  EXPECT_TRUE(same_contacts(motion.expected[1], detector->detect(input)));
}

INSTANTIATE_TEST_SUITE_P(Scalars, Slots, ::testing::Values(Scalar::kF32, Scalar::kF64),
                         [](const auto& test) { return test.param == Scalar::kF32 ? "F32" : "F64"; });

class SlotRules : public OnBackend<> {
 protected:
  static Case moving_and_wall() {
    Case c = soup(80, 300, 1, 0.2, 0.1);
    const Case wall = soup(81, 50, 1, 0.3, 0);
    add_mesh(c, wall.meshes[0].triangles, wall.start[0], {}, true);
    return rounded(c, Scalar::kF32);
  }
  void SetUp() override {
    OnBackend::SetUp();
    if (IsSkipped()) return;
    detector_ = Detector::create(spec_);
    slot_ = detector_->make_slot();
  }
  std::vector<MeshPositions> first() const { return all_.input().updates; }

  const Case case_ = moving_and_wall();
  const SceneSpec spec_ = spec_for(case_, settings(Mode::kCcd, Accuracy::kFast, Scalar::kF32));
  const Frame all_{case_, Mode::kCcd, Scalar::kF32}, moving_{case_, Mode::kCcd, Scalar::kF32, false};
  std::unique_ptr<Detector> detector_;
  std::shared_ptr<FrameSlot> slot_;
};

TEST_F(SlotRules, RoomIsAlignedAndKept) {
  const std::span<std::byte> room = slot_->room(100'000);
  EXPECT_GE(room.size(), 100'000u);
  EXPECT_EQ(reinterpret_cast<uintptr_t>(room.data()) % 64, 0u);
  std::fill(room.begin(), room.end(), std::byte{1});
  EXPECT_EQ(slot_->room(10).data(), room.data());
  EXPECT_GE(slot_->room(300'000).size(), 300'000u);
}

TEST_F(SlotRules, WhatTheMeshesCannotHaveIsRefusedWhenItIsSent) {
  std::vector<MeshPositions> updates = first();
  updates[0].mesh = 2;
  EXPECT_EQ("updates[0].mesh", refused_field([&] { slot_->send(updates); }));
  updates[0].mesh = 1;
  updates[0].start = {};
  EXPECT_EQ("updates[0].end", refused_field([&] { slot_->send(updates); }));
  updates = first();
  updates[1].start = updates[1].end;
  EXPECT_EQ("updates[1].start", refused_field([&] { slot_->send(updates); }));
  updates = first();
  updates.push_back(updates[0]);
  EXPECT_EQ("updates[2].mesh", refused_field([&] { slot_->send(updates); }));
  FrameInput input;
  input.slot = slot_;
  EXPECT_EQ("slot", refused_field([&] { detector_->detect(input); })) << "nothing of it was sent";
}

TEST_F(SlotRules, OnlyWhatWasSentIsTaken) {
  FrameInput input;
  input.slot = slot_;
  EXPECT_EQ("slot", refused_field([&] { detector_->detect(input); }));
  slot_->send(first());
  slot_->room(1);
  EXPECT_EQ("slot", refused_field([&] { detector_->detect(input); })) << "what was there is lost";
  slot_->send(first());
  input.updates = first();
  EXPECT_EQ("updates", refused_field([&] { detector_->detect(input); }));
  input.updates.clear();
  auto other = Detector::create(spec_);
  EXPECT_EQ("slot", refused_field([&] { other->detect(input); }));
  EXPECT_TRUE(same_contacts(run_case(case_, spec_), detector_->detect(input)));
}

TEST_F(SlotRules, WhatDependsOnEarlierFramesIsRefusedInItsTurn) {
  EXPECT_EQ("updates", refused_field([&] { detector_->detect(sent(slot_, {first()[0]})); })) << "a mesh is missing";
  detector_->detect(sent(slot_, first()));
  EXPECT_EQ("updates[1].mesh", refused_field([&] { detector_->detect(sent(slot_, first())); })) << "it is static";
}

TEST_F(SlotRules, ABadCoordinateIsNamedAndHarmsNothing) {
  detector_->detect(sent(slot_, first()));
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL, 3e38}) {
    for (const bool at_start : {false, true}) {
      Case broken = case_;
      (at_start ? broken.start : broken.end)[0][7][1] = bad;
      const Frame frame(broken, Mode::kCcd, Scalar::kF32, false);
      try {
        detector_->detect(sent(slot_, frame.input().updates));
        ADD_FAILURE() << bad << " was taken";
      } catch (const InvalidInput& e) {
        EXPECT_EQ(e.field(), at_start ? "updates[0].start" : "updates[0].end");
        EXPECT_NE(std::string(e.what()).find("mesh 0, vertex 7, coordinate y is "), std::string::npos) << e.what();
      }
    }
  }
  auto twin = Detector::create(spec_);
  twin->detect(all_.input());
  FrameInput rest = moving_.input();
  rest.updates[0].start = {};  // from where the good frame left the mesh
  EXPECT_TRUE(same_contacts(twin->detect(rest), detector_->detect(sent(slot_, rest.updates))));
}

TEST_F(SlotRules, ASlotMayOutliveItsScene) {
  detector_->detect(sent(slot_, first()));
  detector_.reset();
  EXPECT_EQ("updates[0].mesh", refused_field([&] { slot_->send({{~0u, {}, {}}}); }));
  EXPECT_NO_THROW(slot_->send(moved_to(slot_->room(bytes_in(first())), first())));
  auto other = Detector::create(spec_);
  FrameInput input;
  input.slot = slot_;
  EXPECT_EQ("slot", refused_field([&] { other->detect(input); }));
}

TEST_F(SlotRules, MemoryIsThatOfTheScene) {
  slot_->send(first());
  EXPECT_GE(staging_bytes(*detector_), bytes_in(first()));
  const auto second = detector_->make_slot();
  const uint64_t before = staging_bytes(*detector_);
  second->send(first());
  EXPECT_GE(staging_bytes(*detector_), before + bytes_in(first()));
  slot_.reset();
  EXPECT_LT(staging_bytes(*detector_), before + bytes_in(first()));
}

TEST_F(SlotRules, TheBudgetHoldsForSlotsToo) {
  detector_->detect(sent(slot_, first()));
  uint64_t bytes = 0;
  for (const MemoryPart& part : detector_->memory()) bytes += part.bytes;
  SceneSpec spec = spec_;
  spec.memory_budget = bytes + bytes_in(first()) / 2;
  auto bounded = Detector::create(spec);
  const FrameResult expected = bounded->detect(sent(bounded->make_slot(), first()));
  std::vector<std::shared_ptr<FrameSlot>> slots;
  EXPECT_THROW(
      for (int i = 0; i < 1000; ++i) {
        slots.push_back(bounded->make_slot());
        slots.back()->send(first());
      },
      ResourceExhausted);
  slots.clear();
  EXPECT_TRUE(same_contacts(expected, run_case(case_, spec_)));
  EXPECT_NO_THROW(bounded->detect(sent(bounded->make_slot(), moving_.input().updates)));
}

using SharedMemoryOf = OnBackend<>;

TEST_F(SharedMemoryOf, NothingIsRegisteredToo) { EXPECT_TRUE(register_host_memory({kBackend}, {})->bytes().empty()); }

TEST_F(SharedMemoryOf, AHandleThatNamesNothingIsRefused) {
  const std::vector<std::byte> zero(64);
  for (const size_t size : {0, 3, 64})
    EXPECT_EQ("handle", refused_field([&] { open_device_memory({kBackend}, std::span(zero).first(size)); })) << size;
  EXPECT_TRUE(device_works({kBackend})) << "a bad handle harms no device";
}

TEST(Devices, ThatAreThereWork) {
  EXPECT_TRUE(device_works({Backend::kCpu}));
  EXPECT_EQ(device_works({Backend::kCuda}), cuda_available());
}

}  // namespace
}  // namespace collided::test
