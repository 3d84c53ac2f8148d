// Which frame the rest pairs are of, and what they are for: cloth whose thickness is not much less than its spacing.

#include <algorithm>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/counted_quota.hpp"
#include "tests/gpu/scene/sheets.hpp"
#include "tests/support/digest.hpp"
#include "tests/support/exclusions.hpp"

namespace collided::test {
namespace {

constexpr double kSpacing = 0.010, kThickness = 0.008;

/// One sheet, 10 mm wide cells, that goes from `start` to `end`.
Case cloth(Positions start, Positions end) {
  Case c;
  const auto side = static_cast<uint32_t>(std::lround(std::sqrt(start.size())));
  add_mesh(c, grid_triangles(side), std::move(start), std::move(end));
  return c;
}

SceneSpec cloth_spec(uint32_t side, Mode mode, bool excludes_rest_pairs, double rest_distance = kThickness) {
  const Case c = cloth(flat_grid(side, kSpacing), {});
  SceneSpec spec = spec_for(c, settings(mode, Accuracy::kCertified, Scalar::kF32, kThickness));
  spec.meshes[0].excludes_rest_pairs = excludes_rest_pairs;
  spec.rest_distance = excludes_rest_pairs ? rest_distance : 0;
  return spec;
}

FrameResult detect(Detector& detector, const SceneSpec& spec, const Case& c) {
  return detector.detect(Frame(c, spec.mode, spec.scalar).input());
}

using RestPairs = OnBackend<>;

// 8 mm of thickness on a grid of 10 mm: flat, it is in contact with itself all over.
TEST_F(RestPairs, AThickClothAtRestHasNoContacts) {
  constexpr uint32_t kSide = 128, kCells = kSide - 1;
  for (const Mode mode : {Mode::kDcd, Mode::kCcd}) {
    const Case rest = cloth(flat_grid(kSide, kSpacing), {});
    const SceneSpec full = cloth_spec(kSide, mode, false), spec = cloth_spec(kSide, mode, true);
    const auto all = Detector::create(full), left = Detector::create(spec);
    const FrameResult before = detect(*all, full, rest), after = detect(*left, spec, rest);
    // 7.1 mm: in each cell the corners off the diagonal from the other triangle, and edges on either side of a cell's.
    EXPECT_EQ(before.vertex_triangle.size(), 2 * kCells * kCells);
    EXPECT_EQ(before.edge_edge.size(), 6 * kCells * kCells - 6 * kCells);
    EXPECT_EQ(count_contacts(after), 0u);
    EXPECT_FALSE(after.any_contact);
    EXPECT_EQ(after.counts.contacts.vertex_triangle + after.counts.contacts.edge_edge, 0u);
    const Case later = cloth(flat_grid(kSide, kSpacing), flat_grid(kSide, 0.99 * kSpacing));
    EXPECT_EQ(count_contacts(detect(*left, spec, later)), 0u);
  }
}

// The cloth is folded: its halves touch, its cells do not.
TEST_F(RestPairs, AFoldIsFoundAmongThem) {
  constexpr uint32_t kSide = 20;
  const Positions folded = grid(kSide, [](double i, double j) {
    const bool is_below = i < kSide / 2;
    return Vec3d{(is_below ? i : kSide - 0.7 - i) * kSpacing, j * kSpacing, is_below ? 0 : 0.005};
  });
  for (const Mode mode : {Mode::kDcd, Mode::kCcd}) {
    const SceneSpec spec = cloth_spec(kSide, mode, true), full = cloth_spec(kSide, mode, false);
    const auto detector = Detector::create(spec), all = Detector::create(full);
    const Case rest = rounded(cloth(flat_grid(kSide, kSpacing), {}), spec.scalar);
    const Case fold = rounded(cloth(folded, folded), spec.scalar);
    detect(*detector, spec, rest);
    const FrameResult found = detect(*detector, spec, fold), every = detect(*all, full, fold);
    const Exclusions excluded(rest, spec);
    EXPECT_TRUE(
        same_bytes(found.vertex_triangle, excluded.left_of(ContactKind::kVertexTriangle, every.vertex_triangle)));
    EXPECT_TRUE(same_bytes(found.edge_edge, excluded.left_of(ContactKind::kEdgeEdge, every.edge_edge)));
    EXPECT_GT(found.vertex_triangle.size(), kSide * kSide / 3);
    EXPECT_LT(count_contacts(found), count_contacts(every));
  }
}

// Cells of 2^-7: corners of a cell are exactly so far from its opposite edges. At that distance they are excluded, and
// a hair less excludes none of them.
TEST_F(RestPairs, AreExactlyThoseWithinTheDistance) {
  constexpr double kCell = 0x1p-7;
  const Case rest = cloth(flat_grid(8, kCell), {});
  for (const double distance : {kCell, std::nextafter(kCell, 0.0), std::nextafter(kCell, 1.0)}) {
    SceneSpec spec = spec_for(rest, settings(Mode::kDcd, Accuracy::kExact, Scalar::kF64, kCell));
    const FrameResult all = detect(*Detector::create(spec), spec, rest);
    spec.meshes[0].excludes_rest_pairs = true;
    spec.rest_distance = distance;
    const FrameResult left = detect(*Detector::create(spec), spec, rest);
    const Exclusions excluded(rest, spec);
    EXPECT_TRUE(same_bytes(left.vertex_triangle, excluded.left_of(ContactKind::kVertexTriangle, all.vertex_triangle)));
    EXPECT_TRUE(same_bytes(left.edge_edge, excluded.left_of(ContactKind::kEdgeEdge, all.edge_edge)));
    EXPECT_LT(count_contacts(left), count_contacts(all));
    EXPECT_EQ(count_contacts(left) == 0, distance >= kCell);
  }
}

// The rest shape is where the first frame ends, not where its step begins.
TEST_F(RestPairs, AreThoseOfTheEndOfTheFirstFrame) {
  Positions spread = flat_grid(12, 3 * kSpacing);
  const SceneSpec spec = cloth_spec(12, Mode::kCcd, true);
  const auto detector = Detector::create(spec);
  const Case gathered = cloth(spread, flat_grid(12, kSpacing));
  EXPECT_EQ(count_contacts(detect(*detector, spec, gathered)), 0u);
  const auto other = Detector::create(spec);
  const Case dispersed = cloth(flat_grid(12, kSpacing), spread);
  EXPECT_GT(count_contacts(detect(*other, spec, dispersed)), 0u);
}

// Frames that fail, are cancelled or are trials fix nothing: the rest shape is that of the first that counts.
TEST_F(RestPairs, AreThoseOfTheFirstFrameThatCounts) {
  const Case wide = cloth(flat_grid(12, 3 * kSpacing), {}), rest = cloth(flat_grid(12, kSpacing), {});
  for (const Mode mode : {Mode::kDcd, Mode::kCcd}) {
    const SceneSpec spec = cloth_spec(12, mode, true), full = cloth_spec(12, mode, false);
    const auto detector = Detector::create(spec);
    const auto expect_no_rest_pairs = [&](const Case& first, size_t contacts_of_rest) {
      const auto fresh = Detector::create(spec);
      detect(*fresh, spec, first);
      EXPECT_EQ(count_contacts(detect(*fresh, spec, rest)), contacts_of_rest);
    };
    const size_t all = count_contacts(detect(*Detector::create(full), full, rest));
    EXPECT_GT(all, 0u);
    expect_no_rest_pairs(wide, all);
    expect_no_rest_pairs(rest, 0);

    // A trial answers as a first frame does, for its own positions.
    const Frame at_rest(rest, mode, spec.scalar), wide_frame(wide, mode, spec.scalar);
    FrameInput trial = at_rest.input();
    trial.trial = true;
    EXPECT_EQ(count_contacts(detector->detect(trial)), 0u);
    int asks = 0;
    FrameInput cancelled = at_rest.input();
    for (int last = 0; last < 40; ++last) {
      asks = 0;
      cancelled.cancelled = [&] { return asks++ >= last; };
      try {
        cancelled.trial = true;
        detector->detect(cancelled);
      } catch (const Cancelled&) {
      }
    }
    EXPECT_GT(asks, 4);
    Case bad = rest;
    bad.end[0].back()[1] = std::nan("");
    EXPECT_THROW(detector->detect(Frame(bad, mode, spec.scalar).input()), InvalidInput);

    detector->detect(wide_frame.input());
    EXPECT_EQ(count_contacts(detect(*detector, spec, rest)), all);
  }
}

// Wherever memory ends, the frame is refused as a whole, and the next one begins anew.
TEST_F(RestPairs, ATooSmallQuotaRefusesTheFrameAndNothingElse) {
  const Case rest = cloth(flat_grid(40, kSpacing), {}), wide = cloth(flat_grid(40, 3 * kSpacing), {});
  const SceneSpec full = cloth_spec(40, Mode::kDcd, false);
  const FrameResult all = detect(*Detector::create(full), full, rest);
  SceneSpec spec = cloth_spec(40, Mode::kDcd, true);
  const auto quota = std::make_shared<CountedQuota>();
  spec.memory_quota = quota;
  detect(*Detector::create(spec), spec, rest);
  const uint64_t need = quota->peak();
  for (int share = 1; share < 16; ++share) {
    const auto detector = Detector::create(spec);
    quota->set_most(quota->held() + (need - quota->held()) * share / 16);
    EXPECT_THROW(detect(*detector, spec, rest), ResourceExhausted) << share;
    quota->set_most(~uint64_t{0});
    EXPECT_EQ(count_contacts(detect(*detector, spec, wide)), 0u);
    EXPECT_TRUE(same_contacts(detect(*detector, spec, rest), all)) << "excludes pairs of the refused frame";
  }
  EXPECT_EQ(quota->held(), 0u);
}

// An advance asks for min_separation; pairs that are closer at rest neither stop it nor are certified.
TEST_F(RestPairs, DoNotStopAnAdvance) {
  constexpr uint32_t kSide = 12;
  const Case still = cloth(flat_grid(kSide, kSpacing), {});
  const Case shrinking = cloth(flat_grid(kSide, kSpacing), flat_grid(kSide, 0.95 * kSpacing));
  const auto advanced = [&](bool excludes_rest_pairs) {
    SceneSpec spec = cloth_spec(kSide, Mode::kCcd, excludes_rest_pairs);
    spec.thickness = spec.min_separation = kThickness;
    const auto detector = Detector::create(spec);
    detect(*detector, spec, still);
    const Frame frame(shrinking, spec.mode, spec.scalar);
    FrameInput input = frame.input();
    input.advance = true;
    return detector->detect(input).advanced.value();
  };
  EXPECT_EQ(advanced(true), 1);
  EXPECT_LT(advanced(false), 1);
}

}  // namespace
}  // namespace collided::test
