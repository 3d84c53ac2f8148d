// Contacts that stay in memory of the backend: the bytes, totals and order of those that come to the host.

#include <algorithm>
#include <cstring>
#include <numeric>

#include "gpu/stencil.hpp"
#include "tests/gpu/backend.hpp"
#include "tests/gpu/contacts/device_bytes.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

constexpr FieldSet kAllFields{ContactField::kElements, ContactField::kToi,     ContactField::kDistance,
                              ContactField::kWeights,  ContactField::kNormals, ContactField::kFlags,
                              ContactField::kFeatures};
constexpr uint64_t kPage = 4096, kAmple = 4 << 20;

using StencilIds = std::array<uint32_t, 4>;

template <class T>
std::vector<T> values_at(const std::vector<std::byte>& memory, const ArrayRange& range) {
  std::vector<T> out(range.bytes / sizeof(T));
  EXPECT_LE(range.offset + range.bytes, memory.size());
  EXPECT_EQ(range.bytes % sizeof(T), 0u);
  if (!out.empty()) std::memcpy(out.data(), memory.data() + range.offset, range.bytes);
  return out;
}

/// Both in one, the first before the second.
template <class T>
Column<T> joined(std::vector<T> first, const Column<T>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first.empty() ? Column<T>() : Column<T>(std::move(first));
}

/// A result as if all of its contacts had come to the host.
FrameResult brought(const FrameResult& result, const std::vector<std::byte>& memory) {
  FrameResult all = result;
  for_each_kind(
      [&](ContactKind, ContactSet& set, const PlacedContacts& placed) {
        for_each_field(
            [&](ContactField, auto& column, const ArrayRange& range) {
              using T = std::remove_cvref_t<decltype(column[0])>;
              EXPECT_TRUE(range.bytes == 0 || range.bytes == placed.count * sizeof(T));
              EXPECT_EQ(range.offset % ContactRoom::kAlignment, 0u);
              column = joined(values_at<T>(memory, range), column);
            },
            set, placed);
      },
      all, result.placed);
  return all;
}

uint64_t count_placed(const FrameResult& result) {
  uint64_t count = 0;
  for_each_kind([&](ContactKind, const PlacedContacts& placed) { count += placed.count; }, result.placed);
  return count;
}

StencilIds stencil_of(ContactKind kind, const std::array<uint32_t, 2>& ids, const Topology& topology) {
  if (kind == ContactKind::kVertexTriangle) {
    const auto& t = topology.triangles[ids[1]];
    return {ids[0], t[0], t[1], t[2]};
  }
  const auto &a = topology.edges[ids[0]], &b = topology.edges[ids[1]];
  return {a[0], a[1], b[0], b[1]};
}

void expect_stencils(const FrameResult& result, const std::vector<std::byte>& memory, const Topology& topology) {
  for_each_kind(
      [&](ContactKind kind, const PlacedContacts& placed) {
        const auto elements = values_at<std::array<uint32_t, 2>>(memory, placed.elements);
        const auto stencils = values_at<StencilIds>(memory, placed.stencils);
        ASSERT_EQ(stencils.size(), stencil_finder(kind) == nullptr ? 0 : elements.size());
        for (size_t i = 0; i < stencils.size(); ++i)
          ASSERT_EQ(stencils[i], stencil_of(kind, elements[i], topology)) << static_cast<int>(kind) << " " << i;
      },
      result.placed);
}

void expect_same_totals(const FrameResult& a, const FrameResult& b) {
  EXPECT_EQ(std::memcmp(&a.earliest_toi, &b.earliest_toi, sizeof(double)), 0)
      << a.earliest_toi << " " << b.earliest_toi;
  EXPECT_EQ(a.any_contact, b.any_contact);
  EXPECT_EQ(count_contacts(a), count_contacts(b));
  EXPECT_EQ(a.counts.contacts, b.counts.contacts);
  EXPECT_EQ(a.counts.exact_decisions, b.counts.exact_decisions);
  EXPECT_EQ(a.advanced, b.advanced);
}

struct Ask {
  SceneSpec spec;
  Case scene;
  FrameInput options = {};  ///< without updates
};

FrameInput frame_of(const Ask& ask, const Frame& positions) {
  FrameInput input = ask.options;
  input.updates = positions.input().updates;
  return input;
}

/// The frame's contacts in a room of so many bytes, and on the host, in two scenes. Returns how many had room.
uint64_t expect_same(const Ask& ask, uint64_t bytes = kAmple) {
  const Frame positions(ask.scene, ask.spec.mode, ask.spec.scalar);
  FrameInput input = frame_of(ask, positions);
  const FrameResult expected = Detector::create(spec_for(ask.scene, ask.spec))->detect(input);
  const DeviceBytes memory(bytes + kPage);  // nothing may be written after the room
  input.room = {memory.bytes().first(bytes), kAllFields, true};
  const auto detector = Detector::create(spec_for(ask.scene, ask.spec));
  const FrameResult placed = detector->detect(input);
  const std::vector<std::byte> written = memory.read();
  const FrameResult all = brought(placed, written);
  EXPECT_TRUE(same_contacts(expected, all));
  EXPECT_TRUE(same_bytes(expected.triangle_triangle, all.triangle_triangle));
  EXPECT_TRUE(same_bytes(expected.edge_triangle, all.edge_triangle));
  expect_same_totals(expected, placed);
  expect_stencils(placed, written, detector->topology());
  EXPECT_TRUE(std::all_of(written.begin() + static_cast<std::ptrdiff_t>(bytes), written.end(),
                          [](std::byte b) { return b == DeviceBytes::kPoison; }));
  return count_placed(placed);
}

SceneSpec full(Mode mode, Accuracy accuracy, Scalar scalar = Scalar::kF32, double thickness = 0) {
  SceneSpec spec = settings(mode, accuracy, scalar, thickness);
  spec.fields = kAllFields;
  return spec;
}

class Room : public OnBackend<::testing::TestWithParam<Accuracy>> {
 protected:
  const Case case_ = rounded(soup(411, 400, 0.5, 0.2, 0.1), Scalar::kF32);
};

TEST_P(Room, HoldsWhatTheHostWouldGet) {
  for (const Scalar scalar : {Scalar::kF32, Scalar::kF64})
    for (const Mode mode : {Mode::kCcd, Mode::kDcd}) {
      const SceneSpec spec = full(mode, GetParam(), scalar, mode == Mode::kDcd ? 0.01 : 0);
      EXPECT_GT(expect_same({spec, case_}), 100u);
    }
}

TEST_P(Room, IsOfBothModes) {
  SceneSpec spec = full(Mode::kBoth, GetParam(), Scalar::kF32, 0.01);
  for (const Mode mode : {Mode::kCcd, Mode::kDcd}) {
    Ask ask{spec, case_};
    ask.options.mode = mode;
    const Frame ends(case_, Mode::kDcd, spec.scalar), both(case_, Mode::kCcd, spec.scalar);
    FrameInput input = frame_of(ask, mode == Mode::kDcd ? ends : both);
    const FrameResult expected = Detector::create(spec_for(case_, spec))->detect(input);
    const DeviceBytes memory(kAmple);
    input.room = {memory.bytes(), kAllFields, false};
    const FrameResult placed = Detector::create(spec_for(case_, spec))->detect(input);
    EXPECT_TRUE(same_contacts(expected, brought(placed, memory.read())));
    expect_same_totals(expected, placed);
  }
}

TEST_P(Room, OfAnyReport) {
  if (GetParam() == Accuracy::kCandidates) return;  // which has no others
  for (const uint32_t seed : {412u, 413u})
    for (const Report report : {Report::kEarliestOnly, Report::kAnyHit})
      for (const bool ignores : {false, true}) {
        if (GetParam() == Accuracy::kFast && (ignores || report == Report::kEarliestOnly)) continue;
        Ask ask{full(Mode::kCcd, GetParam(), Scalar::kF64), lattice(seed, 40, 8)};  // many at the same times
        ask.options.report = report;
        ask.options.ignore_separating = ignores;
        EXPECT_EQ(expect_same(ask), report == Report::kEarliestOnly ? 1u : 0u);
      }
}

TEST_P(Room, SeparatingContactsDoNotCountIfTheyAreIgnored) {
  if (GetParam() < Accuracy::kGuarded) return;
  Ask ask{full(Mode::kCcd, GetParam(), Scalar::kF64, 0.25), lattice(414, 40, 8)};
  for (const bool ignores : {false, true}) {
    ask.options.ignore_separating = ignores;
    expect_same(ask);
  }
}

TEST_P(Room, WhatDoesNotFitComesToTheHost) {
  for (const Mode mode : {Mode::kCcd, Mode::kDcd}) {
    const Ask ask{full(mode, GetParam(), Scalar::kF32, mode == Mode::kDcd ? 0.01 : 0), case_};
    const uint64_t all = expect_same(ask);
    uint64_t last = 0;
    for (const uint64_t bytes : {uint64_t{64}, kPage, 2 * kPage, 5 * kPage, 16 * kPage, 1024 * kPage}) {
      const uint64_t count = expect_same(ask, bytes);
      EXPECT_GE(count, last);
      EXPECT_EQ(count == 0, bytes == 64);
      last = count;
    }
    EXPECT_EQ(last, all);
  }
}

TEST_P(Room, TrianglePairs) {
  for (const Mode mode : {Mode::kDcd, Mode::kCcd}) {
    if (mode == Mode::kCcd && GetParam() != Accuracy::kCandidates) continue;
    SceneSpec spec = full(mode, GetParam(), Scalar::kF64, mode == Mode::kDcd ? 0.01 : 0);
    spec.kinds.triangle_triangle = true;
    for (const uint64_t bytes : {kAmple, 3 * kPage}) EXPECT_GT(expect_same({spec, case_}, bytes), 0u);
    spec.kinds = {.triangle_triangle = true};
    EXPECT_GT(expect_same({spec, case_}), 0u);
  }
}

TEST_P(Room, Crossings) {
  if (GetParam() == Accuracy::kCandidates) return;  // which decides of none
  SceneSpec spec = full(Mode::kDcd, GetParam(), Scalar::kF64, 0.01);
  spec.kinds.triangle_triangle = spec.kinds.edge_triangle = true;
  for (const uint64_t bytes : {kAmple, 3 * kPage}) EXPECT_GT(expect_same({spec, case_}, bytes), 0u);
  spec.kinds = {.edge_triangle = true};
  EXPECT_GT(expect_same({spec, case_}), 0u);
}

TEST_P(Room, OneKindAlone) {
  for (const bool vertices : {false, true}) {
    SceneSpec spec = full(Mode::kCcd, GetParam());
    (vertices ? spec.kinds.edge_edge : spec.kinds.vertex_triangle) = false;
    EXPECT_GT(expect_same({spec, case_}), 0u);
  }
}

// Counts change, frames take turns in two rooms, and some have none; a scene's first lists are too short for them.
TEST_P(Room, FramesTakeTurns) {
  const SceneSpec spec = spec_for(case_, full(Mode::kCcd, GetParam()));
  const auto detector = Detector::create(spec), other = Detector::create(spec);
  const DeviceBytes memory(2 * kAmple);
  uint64_t counts[3] = {};
  for (int i = 0; i < 12; ++i) {
    const int size = i % 3;
    Case moved = case_;
    for (Positions& positions : moved.end)
      for (Vec3d& p : positions) p[2] += size == 0 ? 0.0 : p[0] * (size == 1 ? 0.5 : -2.0);
    const Frame positions(rounded(moved, Scalar::kF32), Mode::kCcd, Scalar::kF32);
    FrameInput input = positions.input();
    const FrameResult expected = other->detect(input);
    if (i % 5 != 4) input.room = {memory.bytes().subspan(i % 2 * kAmple, kAmple), kAllFields, i % 4 < 2};
    const FrameResult placed = detector->detect(input);
    std::vector<std::byte> written = memory.read();
    written.erase(written.begin(), written.begin() + static_cast<std::ptrdiff_t>(i % 2 * kAmple));
    EXPECT_TRUE(same_contacts(expected, brought(placed, written))) << i;
    expect_same_totals(expected, placed);
    EXPECT_EQ(count_placed(placed) > 0, i % 5 != 4);
    counts[size] = count_contacts(placed);
  }
  EXPECT_TRUE(counts[0] != counts[1] && counts[1] != counts[2]);
}

TEST_P(Room, OnlyFieldsThatAreAskedForAreThere) {
  const SceneSpec spec = spec_for(case_, full(Mode::kCcd, GetParam()));
  const Frame positions(case_, Mode::kCcd, Scalar::kF32);
  const DeviceBytes memory(kAmple);
  FrameInput input = positions.input();
  input.room = {memory.bytes(), {ContactField::kToi, ContactField::kWeights}, false};
  const FrameResult placed = Detector::create(spec)->detect(input);
  const PlacedContacts& contacts = placed.placed.vertex_triangle;
  ASSERT_GT(contacts.count, 0u);
  const bool has_values = GetParam() != Accuracy::kCandidates;
  EXPECT_EQ(contacts.toi.bytes, has_values ? contacts.count * 8 : 0);
  EXPECT_EQ(contacts.weights.bytes, has_values ? contacts.count * 16 : 0);
  for (const ArrayRange& none :
       {contacts.elements, contacts.distance, contacts.normals, contacts.flags, contacts.stencils})
    EXPECT_EQ(none.bytes, 0u);
}

TEST_P(Room, TheFirstAreOnTheHostIfTheyAreWanted) {
  const SceneSpec spec = spec_for(case_, full(Mode::kCcd, GetParam()));
  const Frame positions(case_, Mode::kCcd, Scalar::kF32);
  const FrameResult expected = Detector::create(spec)->detect(positions.input());
  for (const uint64_t first : {uint64_t{0}, uint64_t{1}, uint64_t{10}, uint64_t{1} << 40}) {
    const DeviceBytes memory(kAmple);
    FrameInput input = positions.input();
    input.room = {memory.bytes().first(8 * kPage), kAllFields, false, first};
    const FrameResult placed = Detector::create(spec)->detect(input);
    EXPECT_TRUE(same_contacts(expected, brought(placed, memory.read())));
    for_each_kind(
        [&](ContactKind, ContactSet all, const ContactSet& shown) {
          for_each_field([&](ContactField, auto& column) { column.truncate(first); }, all);
          EXPECT_TRUE(same_bytes(all, shown)) << first;
        },
        expected, placed.first);
  }
}

TEST_P(Room, NoColumnComesToTheHost) {
  if (GetParam() == Accuracy::kExact) return;  // where the host decides
  const SceneSpec spec = spec_for(case_, full(Mode::kCcd, GetParam()));
  const Frame positions(case_, Mode::kCcd, Scalar::kF32);
  const DeviceBytes memory(kAmple);
  FrameInput input = positions.input();
  input.room = {memory.bytes(), kAllFields, true};
  const auto detector = Detector::create(spec);
  const FrameResult placed = detector->detect(input);
  EXPECT_GT(count_placed(placed), 0u);
  EXPECT_EQ(placed.held, nullptr);
  const auto parts = detector->memory();
  EXPECT_TRUE(std::ranges::none_of(parts, [](const MemoryPart& part) { return part.part == "answers"; }));
  EXPECT_TRUE(std::ranges::none_of(placed.stages, [](const StageTime& s) { return s.stage == "download"; }));
  const auto times_placed = std::ranges::count(placed.stages, "place", &StageTime::stage);
  EXPECT_GE(times_placed, 1);
  EXPECT_LE(times_placed, 1 + placed.replays);
}

INSTANTIATE_TEST_SUITE_P(Levels, Room,
                         ::testing::Values(Accuracy::kCandidates, Accuracy::kFast, Accuracy::kGuarded,
                                           Accuracy::kCertified, Accuracy::kExact),
                         [](const auto& info) { return level_name(info.param); });

class RoomOfOneFrame : public OnBackend<> {};

TEST_F(RoomOfOneFrame, ThatAdvances) {
  SceneSpec spec = full(Mode::kCcd, Accuracy::kCertified);
  spec.min_separation = 1e-3;
  for (const uint32_t seed : {415u, 416u}) {
    Ask ask{spec, rounded(soup(seed, 200, 1, 0.1, 0.1), Scalar::kF32)};
    ask.options.advance = true;
    expect_same(ask);
  }
}

TEST_F(RoomOfOneFrame, WithoutContacts) {
  Case apart;
  add_mesh(apart, {{0, 1, 2}}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  add_mesh(apart, {{0, 1, 2}}, {{0, 0, 9}, {1, 0, 9}, {0, 1, 9}}, {{0, 0, 8}, {1, 0, 8}, {0, 1, 8}});
  for (const Accuracy accuracy : {Accuracy::kCandidates, Accuracy::kCertified, Accuracy::kExact})
    EXPECT_EQ(expect_same({full(Mode::kCcd, accuracy), apart}), 0u);
}

TEST_F(RoomOfOneFrame, BeginsAtAnAlignedAddress) {
  const Case scene = soup(417, 50, 1, 0.2, 0.1);
  const Frame positions(scene, Mode::kCcd, Scalar::kF64);
  const DeviceBytes memory(2 * kPage);
  const auto detector = Detector::create(spec_for(scene, settings(Mode::kCcd, Accuracy::kCertified)));
  FrameInput input = positions.input();
  input.room.memory = memory.bytes().subspan(8, kPage);
  try {
    detector->detect(input);
    ADD_FAILURE() << "taken";
  } catch (const InvalidInput& e) {
    EXPECT_EQ(e.field(), "room");
    EXPECT_STREQ(e.what(), "room begins at an address that is 8 above a multiple of 64");
  }
  input.room.memory = memory.bytes();
  EXPECT_NO_THROW(detector->detect(input));
}

}  // namespace
}  // namespace collided::test
