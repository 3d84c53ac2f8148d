// Positions in 16 bits: what was encoded is as near as is promised, and what its error means for contacts.

#include "gpu/positions/quantized.hpp"

#include <cmath>
#include <map>
#include <set>

#include "gpu/base/deviations.hpp"
#include "tests/gpu/backend.hpp"
#include "tests/gpu/positions/owned_updates.hpp"
#include "tests/gpu/refused_field.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/case_queries.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

const PositionBox kBox{{-1.5, -1.25, -2}, {1.5, 1.75, 2}};

Positions decoded(const std::vector<std::byte>& bytes, const PositionBox& box) {
  Positions out;
  const auto* q = reinterpret_cast<const Vec3<uint16_t>*>(bytes.data());
  for (size_t i = 0; i < bytes.size() / 6; ++i) {
    const Vec3<float> p = Quantization(box).decode(q[i]);
    out.push_back({double{p.x}, double{p.y}, double{p.z}});
  }
  return out;
}

FrameResult detect(const Case& c, const SceneSpec& spec) {
  std::vector<OwnedUpdate> updates;
  for (uint32_t mesh = 0; mesh < c.meshes.size(); ++mesh) {
    updates.push_back({mesh, false, {}, {}, encoded(c.end[mesh], *spec.quantized_in)});
    if (spec.mode == Mode::kCcd) updates.back().start = encoded(c.start[mesh], *spec.quantized_in);
  }
  return Detector::create(spec)->detect(frame_of(updates));
}
Case as_decoded(Case c, const PositionBox& box) {
  for (auto* all : {&c.start, &c.end})
    for (Positions& positions : *all) positions = decoded(encoded(positions, box), box);
  return c;
}
SceneSpec spec_of(const Case& c, Mode mode, Accuracy accuracy, double thickness) {
  SceneSpec spec = spec_for(c, settings(mode, accuracy, Scalar::kF32, thickness));
  spec.quantized_in = kBox;
  return spec;
}

TEST(Quantization, IsAsNearAsItSays) {
  const Case c = soup(5, 400, 1, 0.3, 0.1);
  const double error = Quantization(kBox).error();
  EXPECT_LT(error, 5e-5);
  double largest = 0;
  const Positions back = decoded(encoded(c.start[0], kBox), kBox);
  for (size_t i = 0; i < back.size(); ++i) {
    const Vec3d &p = c.start[0][i], &q = back[i];
    largest = std::max(largest, std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]));
  }
  EXPECT_LE(largest, error);
  EXPECT_GT(largest, error / 2) << "the bound is too wide";
}

TEST(Quantization, HoldsABoxThatIsFlatOrFarAway) {
  const PositionBox flat{{3, 3, 3}, {3, 4, 3}};
  EXPECT_EQ(3, Quantization(flat).decode({65535, 0, 7}).x);
  EXPECT_EQ(4, Quantization(flat).decode({0, 65535, 0}).y);
  const PositionBox far{{1e6, 1e6, 1e6}, {1e6 + 1, 1e6 + 1, 1e6 + 1}};
  EXPECT_GT(Quantization(far).error(), 0.05) << "there, binary32 is coarser than the steps";
}

class Quantized : public OnBackend<::testing::Test> {};

TEST_F(Quantized, FindsWhatAThicknessGrownByTheErrorFinds) {
  const Case c = soup(21, 300, 1, 0.2, 0.1);
  const double grown = Deviations::widened(0x1p-8, 2 * Quantization(kBox).error());
  for (const Mode mode : {Mode::kDcd, Mode::kCcd})
    for (const Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kCertified}) {
      const FrameResult expected = run_case(as_decoded(c, kBox), settings(mode, accuracy, Scalar::kF32, grown));
      const FrameResult got = detect(c, spec_of(c, mode, accuracy, 0x1p-8));
      EXPECT_GT(got.edge_edge.size(), 0u);
      EXPECT_TRUE(std::ranges::equal(expected.vertex_triangle.elements, got.vertex_triangle.elements));
      EXPECT_TRUE(std::ranges::equal(expected.edge_edge.elements, got.edge_edge.elements));
      EXPECT_TRUE(std::ranges::equal(expected.edge_edge.toi, got.edge_edge.toi));
    }
}

TEST_F(Quantized, CandidatesAndFastTakePositionsAsDecoded) {
  const Case c = soup(22, 300, 1, 0.2, 0.1);
  EXPECT_TRUE(same_contacts(run_case(as_decoded(c, kBox), settings(Mode::kCcd, Accuracy::kFast, Scalar::kF32, 0x1p-8)),
                            detect(c, spec_of(c, Mode::kCcd, Accuracy::kFast, 0x1p-8))));
}

/// What the judge finds of the positions before they were encoded.
void expect_nothing_missed(const Case& c, const SceneSpec& spec) {
  const FrameResult result = detect(c, spec);
  const CaseQueries queries(c);
  size_t hits = 0, certified = 0;
  const auto check = [&](QueryKind kind, const ContactSet& contacts, const PairSet& near) {
    std::map<PairKey, size_t> found;
    std::set<PairKey> pairs(near.may.begin(), near.may.end());
    for (size_t i = 0; i < contacts.size(); ++i) {
      const PairKey pair = key_of(contacts.elements[i][0], contacts.elements[i][1]);
      found[pair] = i;
      pairs.insert(pair);
    }
    for (const PairKey pair : pairs) {
      const Query query = queries.of_pair(kind, pair);
      ExactImpact truth;
      if (spec.mode == Mode::kCcd)
        truth = judge_ccd(query, spec.thickness);
      else
        truth.hit = judge_proximity(kind, {query.p[4], query.p[5], query.p[6], query.p[7]}, spec.thickness);
      const auto at = found.find(pair);
      if (truth.hit) {
        ++hits;
        ASSERT_NE(found.end(), at) << (kind == QueryKind::kEdgeEdge ? "edges " : "vertex ") << (pair >> 32) << " "
                                   << static_cast<uint32_t>(pair);
        if (spec.mode == Mode::kCcd) {
          EXPECT_LE(contacts.toi[at->second], truth.upper);
        }
      }
      if (at == found.end() || (contacts.flags[at->second] & kFlagCertified) == 0) continue;
      ++certified;
      EXPECT_TRUE(truth.hit) << "certain of what is not so";
    }
  };
  const ExpectedPairs near = brute_force(c, spec.mode, Scalar::kF64, spec.thickness);
  check(QueryKind::kVertexTriangle, result.vertex_triangle, near.vertex_triangle);
  check(QueryKind::kEdgeEdge, result.edge_edge, near.edge_edge);
  EXPECT_GT(hits, 20u);
  EXPECT_EQ(spec.thickness > 0, certified > 0) << "of positions that are not known exactly none cross for certain";
}

TEST_F(Quantized, NothingIsMissedOfThePositionsThatWereEncoded) {
  for (const Case& c : {soup(23, 90, 1, 0.4, 0.3), loosened(soup(23, 150, 1, 0.4, 0.3))})
    for (const Mode mode : {Mode::kDcd, Mode::kCcd})
      for (const double thickness : {0.0, 0.01})
        for (const Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kCertified})
          if (mode == Mode::kCcd || thickness > 0) expect_nothing_missed(c, spec_of(c, mode, accuracy, thickness));
}

TEST_F(Quantized, SparseUpdatesAreEncodedToo) {
  const Case c = soup(24, 60, 1, 0.3, 0.1);
  const SceneSpec spec = spec_of(c, Mode::kDcd, Accuracy::kCertified, 0.01);
  const auto scene = Detector::create(spec);
  const OwnedUpdate first{0, false, {}, {}, encoded(c.start[0], kBox)},
      whole{0, false, {}, {}, encoded(c.end[0], kBox)};
  scene->detect(frame_of({first}));
  std::vector<uint32_t> indices(c.end[0].size());
  for (uint32_t i = 0; i < indices.size(); ++i) indices[i] = i;
  const OwnedUpdate sparse{0, true, bytes_of(indices), {}, whole.end};
  const FrameResult got = scene->detect(frame_of({sparse}));
  EXPECT_TRUE(same_contacts(detect(c, spec), got));
}

TEST_F(Quantized, RigidMeshesStayNearTheBox) {
  const Case c = soup(26, 10, 1, 0.3, 0.1);
  SceneSpec spec = spec_of(c, Mode::kDcd, Accuracy::kCertified, 0.01);
  spec.meshes[0].motion = MeshMotion::kRigid;
  const auto scene = Detector::create(spec);
  const auto go = [&](double x, bool first) {
    const double rows[12] = {1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0};
    const auto* bytes = reinterpret_cast<const std::byte*>(rows);
    OwnedUpdate update;
    if (first) update.end = encoded(c.start[0], kBox);
    update.transform = {bytes, bytes + sizeof(rows)};
    scene->detect(frame_of({update}));
  };
  go(0, true);
  go(10, false);
  EXPECT_EQ("updates[0].transform", refused_field([&] { go(20, false); })) << "binary32 is too coarse there";
}

TEST_F(Quantized, WhatItCannotDoIsRefused) {
  const Case c = soup(25, 10, 1, 0.3, 0.1);
  const auto field_of = [&](const std::function<void(SceneSpec&)>& set) {
    SceneSpec spec = spec_of(c, Mode::kDcd, Accuracy::kCertified, 0.01);
    set(spec);
    return refused_field([&] { Detector::create(spec); });
  };
  EXPECT_EQ("quantized_in", field_of([](SceneSpec& s) { s.accuracy = Accuracy::kExact; }));
  EXPECT_EQ("quantized_in", field_of([](SceneSpec& s) { s.scalar = Scalar::kF64; }));
  EXPECT_EQ("quantized_in", field_of([](SceneSpec& s) { s.quantized_in->lower[1] = NAN; }));
  EXPECT_EQ("quantized_in", field_of([](SceneSpec& s) { s.quantized_in->upper[2] = 1e38; }));
  EXPECT_EQ("quantized_in", field_of([](SceneSpec& s) { s.quantized_in->upper[0] = -2; }));
  EXPECT_EQ("triangle_triangle", field_of([](SceneSpec& s) { s.kinds.triangle_triangle = true; }));
  const auto scene = Detector::create(spec_of(c, Mode::kDcd, Accuracy::kCertified, 0.01));
  const OwnedUpdate floats{0, false, {}, {}, pack(c.end[0], Scalar::kF32)};
  EXPECT_EQ("updates[0].end", refused_field([&] { scene->detect(frame_of({floats})); }));
}

}  // namespace
}  // namespace collided::test
