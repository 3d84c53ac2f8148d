#pragma once
// A scene on one device, and the same in parts.

#include <memory>
#include <string>
#include <vector>

#include "tests/gpu/backend.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {

/// The first part on the scene's device, the next ones on the others of its backend in turn.
inline SceneSpec in_parts(SceneSpec spec, size_t parts) {
  std::vector<Device> devices{spec.device};
  for (const DeviceInfo& info : list_devices())
    if (info.device.backend == spec.device.backend && info.device != spec.device) devices.push_back(info.device);
  spec.part_devices.clear();
  for (size_t k = 0; k < parts; ++k) spec.part_devices.push_back(devices[k % devices.size()]);
  return spec;
}

/// How many contacts a part held for the earliest depends on what it knew of the others'.
inline void expect_same_work(const FrameCounts& expected, const FrameCounts& got, Report report) {
  EXPECT_EQ(expected.pairs, got.pairs);
  EXPECT_EQ(expected.candidates, got.candidates);
  EXPECT_EQ(expected.survivors, got.survivors);
  if (report == Report::kAll) {
    EXPECT_EQ(expected.contacts, got.contacts);
  }
}

/// `report`: of the frame.
inline void expect_same_frame(const FrameResult& expected, const FrameResult& got, Report report) {
  EXPECT_TRUE(same_contacts(expected, got)) << count_contacts(expected) << " against " << count_contacts(got);
  EXPECT_TRUE(same_bytes(expected.triangle_triangle, got.triangle_triangle));
  EXPECT_EQ(expected.earliest_toi, got.earliest_toi);
  EXPECT_EQ(expected.any_contact, got.any_contact);
  EXPECT_EQ(expected.input_resolution, got.input_resolution);
  EXPECT_EQ(expected.advanced, got.advanced);
  if (report != Report::kAnyHit) expect_same_work(expected.counts, got.counts, report);
  uint64_t pairs = 0, contacts = 0;
  double shares = 0;
  for (const ShardFacts& part : got.shards) pairs += part.pairs, contacts += part.contacts, shares += part.share;
  EXPECT_EQ(pairs, got.counts.pairs);
  EXPECT_DOUBLE_EQ(shares, 1);
  if (report == Report::kAll) {
    EXPECT_EQ(contacts, count_contacts(got));
  }
}

/// What a frame was refused with; "" if it was not.
template <class Action>
std::string refusal_of(const Action& action) {
  try {
    action();
  } catch (const InvalidInput& e) {
    return e.field() + ": " + e.what();
  } catch (const ResourceExhausted&) {
    return "ResourceExhausted";
  }
  return "";
}

class OneAndParts {
 public:
  explicit OneAndParts(SceneSpec spec, std::vector<size_t> parts = {1, 2, 3, 5}) : report_(spec.report) {
    spec.reuse = Reuse::kOff;
    one = Detector::create(spec);
    for (const size_t count : parts) in_parts.push_back(Detector::create(test::in_parts(spec, count)));
  }

  /// The same frame to all; whether it counts.
  bool detect(const FrameInput& input) {
    FrameResult expected;
    const std::string refusal = refusal_of([&] { expected = one->detect(input); });
    for (const auto& detector : in_parts) {
      FrameResult got;
      EXPECT_EQ(refusal, refusal_of([&] { got = detector->detect(input); }));
      if (refusal.empty()) expect_same_frame(expected, got, input.report.value_or(report_));
    }
    contacts += count_contacts(expected);
    return refusal.empty();
  }

  std::unique_ptr<Detector> one;
  std::vector<std::unique_ptr<Detector>> in_parts;
  uint64_t contacts = 0;  ///< of all frames

 private:
  Report report_;
};

}  // namespace collided::test
