// Transformations of the input that leave answers the same, as proto/ACCURACY.md lists them, on random scenes: in
// general position, on a coarse grid (features touch, coincide and are coplanar), and with motion in planes.

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <random>

#include "tests/gpu/backend.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/brute_force.hpp"

namespace collided::test {
namespace {

/// A kind (0: vertex-triangle) and the vertices of both features, in no order of theirs.
using Pair = std::array<uint32_t, 5>;
struct Contact {
  double toi;
  uint8_t flags;

  bool operator==(const Contact&) const = default;
};
using Answer = std::map<Pair, Contact>;

/// A case whose vertices have other numbers: `original` of each.
struct Renumbered {
  Case c;
  std::vector<uint32_t> original;

  explicit Renumbered(Case given) : c(std::move(given)) {
    size_t vertices = 0;
    for (const MeshSpec& mesh : c.meshes) vertices += mesh.vertex_count;
    original.resize(vertices);
    std::iota(original.begin(), original.end(), 0);
  }
};

Pair pair_of(ContactKind kind, std::vector<uint32_t> first, std::vector<uint32_t> second) {
  std::ranges::sort(first), std::ranges::sort(second);
  if (kind == ContactKind::kEdgeEdge && second < first) std::swap(first, second);
  Pair pair{kind == ContactKind::kEdgeEdge};
  std::ranges::copy(first, pair.begin() + 1);
  std::ranges::copy(second, pair.begin() + 1 + static_cast<std::ptrdiff_t>(first.size()));
  return pair;
}

Answer answer_of(const Renumbered& input, const SceneSpec& settings) {
  const FrameResult result = run_case(input.c, settings);
  const Features features = features_of(input.c);
  const auto originals = [&](const auto& vertices) {
    std::vector<uint32_t> out;
    for (const uint32_t v : vertices) out.push_back(input.original[v]);
    return out;
  };
  Answer answer;
  const auto add = [&](const ContactSet& set, size_t i, const Pair& pair) {
    answer[pair] = {set.toi.empty() ? 0 : set.toi[i], set.flags[i]};
  };
  const ContactSet &faces = result.vertex_triangle, &edges = result.edge_edge;
  for (size_t i = 0; i < faces.size(); ++i)
    add(faces, i, pair_of(ContactKind::kVertexTriangle, originals(std::array{faces.elements[i][0]}),
                          originals(features.triangles[faces.elements[i][1]])));
  for (size_t i = 0; i < edges.size(); ++i)
    add(edges, i, pair_of(ContactKind::kEdgeEdge, originals(features.edges[edges.elements[i][0]]),
                          originals(features.edges[edges.elements[i][1]])));
  return answer;
}

Case moved(Case c, const std::function<Vec3d(const Vec3d&)>& to) {
  for (std::vector<Positions>* all : {&c.start, &c.end})
    for (Positions& positions : *all)
      for (Vec3d& p : positions) p = to(p);
  return c;
}

/// Two meshes; coordinates have few bits, so that a translation rounds nothing.
Case scene(uint32_t seed) {
  Case c = soup(100 + seed, 40, 1, 0.4, 0.4);
  const Case other = soup(200 + seed, 40, 1, 0.4, 0.4);
  add_mesh(c, other.meshes[0].triangles, other.start[0], other.end[0]);
  const double cells = seed % 3 == 1 ? 8 : 0x1p16;
  return moved(std::move(c), [&](Vec3d p) {
    for (double& x : p) x = std::round(x * cells) / cells;
    if (seed % 3 == 2) p[2] = std::round(p[2] * 4) / 4;
    return p;
  });
}

struct Changed {
  const char* name;
  Renumbered input;
  double scale = 1;  ///< of all lengths
};

Renumbered with_other_numbers(const Case& c, std::mt19937& random) {
  Renumbered out(c);
  uint32_t first = 0;
  for (size_t m = 0; m < c.meshes.size(); ++m) {
    std::vector<uint32_t> to(c.meshes[m].vertex_count);
    std::iota(to.begin(), to.end(), 0);
    std::ranges::shuffle(to, random);
    for (uint32_t v = 0; v < to.size(); ++v) {
      out.c.start[m][to[v]] = c.start[m][v], out.c.end[m][to[v]] = c.end[m][v];
      out.original[first + to[v]] = first + v;
    }
    for (auto& corners : out.c.meshes[m].triangles)
      for (uint32_t& v : corners) v = to[v];
    first += static_cast<uint32_t>(to.size());
  }
  return out;
}
Renumbered with_meshes_swapped(const Case& c) {
  Renumbered out(c);
  std::ranges::reverse(out.c.meshes), std::ranges::reverse(out.c.start), std::ranges::reverse(out.c.end);
  std::ranges::rotate(out.original, out.original.begin() + c.meshes[0].vertex_count);
  return out;
}

/// Those that leave times the same bit for bit at GUARDED and above.
std::vector<Changed> same_at_all_levels(const Case& c, std::mt19937& random) {
  std::vector<Changed> out;
  for (const int exponent : {-40, 37})
    out.push_back({"scaled", Renumbered(moved(c, [&](Vec3d p) {
                     for (double& x : p) x = std::ldexp(x, exponent);
                     return p;
                   })),
                   std::ldexp(1, exponent)});
  for (size_t axis = 0; axis < 3; ++axis)
    out.push_back({"mirrored", Renumbered(moved(c, [&](Vec3d p) {
                     p[axis] = -p[axis];
                     return p;
                   }))});
  Case shuffled = c;
  for (MeshSpec& mesh : shuffled.meshes) std::ranges::shuffle(mesh.triangles, random);
  out.push_back({"triangles in another order", Renumbered(shuffled)});
  return out;
}
/// Those that do so at EXACT.
Changed translated(const Case& c) {
  const auto along = [](const Vec3d& p) { return Vec3d{p[0] + 3, p[1] - 17.125, p[2] + 1.5}; };
  return {"translated", Renumbered(moved(c, along))};
}
/// Those that leave sets the same at EXACT, and times to the precision that they have.
std::vector<Changed> same_sets(const Case& c, std::mt19937& random) {
  std::vector<Changed> out;
  out.push_back({"axes", Renumbered(moved(c, [](const Vec3d& p) { return Vec3d{p[1], p[2], p[0]}; }))});
  Case corners = c;
  for (MeshSpec& mesh : corners.meshes)
    for (auto& t : mesh.triangles) std::ranges::rotate(t, t.begin() + 1);
  out.push_back({"corners", Renumbered(corners)});
  out.push_back({"vertices", with_other_numbers(c, random)});
  out.push_back({"meshes", with_meshes_swapped(c)});
  return out;
}

class Invariance : public OnBackend<::testing::TestWithParam<Accuracy>> {
 protected:
  /// check(answer, settings, case, generator) of scenes of both formats and modes, with and without a thickness.
  template <class Check>
  void for_each_scene(const Check& check) {
    std::mt19937 random(5);
    size_t contacts = 0;
    for (uint32_t seed = 0; seed < 6; ++seed)
      for (const Scalar scalar : {Scalar::kF32, Scalar::kF64})
        for (const Mode mode : {Mode::kCcd, Mode::kDcd})
          for (const double thickness : {0.0, 0x1p-6}) {
            const Case c = scene(seed);
            const SceneSpec spec = settings(mode, GetParam(), scalar, thickness);
            const Answer expected = answer_of(Renumbered(c), spec);
            contacts += expected.size();
            check(expected, spec, c, random);
          }
    EXPECT_GT(contacts, 1000u);
  }
  static Answer after(const Changed& change, SceneSpec spec) {
    spec.thickness *= change.scale;
    return answer_of(change.input, spec);
  }
};

TEST_P(Invariance, PowersOfTwoMirrorsAndTheOrderOfTrianglesChangeNoBit) {
  for_each_scene([](const Answer& expected, const SceneSpec& spec, const Case& c, std::mt19937& random) {
    for (const Changed& change : same_at_all_levels(c, random)) EXPECT_EQ(expected, after(change, spec)) << change.name;
  });
}

INSTANTIATE_TEST_SUITE_P(Levels, Invariance,
                         ::testing::Values(Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact));

using InvarianceAtExact = Invariance;

TEST_P(InvarianceAtExact, TranslationsThatRoundNothingChangeNoBit) {
  for_each_scene([](const Answer& expected, const SceneSpec& spec, const Case& c, std::mt19937&) {
    EXPECT_EQ(expected, after(translated(c), spec));
  });
}

TEST_P(InvarianceAtExact, OtherOrdersAndNumbersChangeNoSet) {
  for_each_scene([](const Answer& expected, const SceneSpec& spec, const Case& c, std::mt19937& random) {
    for (const Changed& change : same_sets(c, random)) {
      const Answer got = after(change, spec);
      ASSERT_EQ(expected.size(), got.size()) << change.name;
      const double precision = spec.thickness == 0 ? 0x1p-50 : 0x1p-40;
      for (const auto& [pair, contact] : expected) {
        const auto found = got.find(pair);
        ASSERT_NE(found, got.end()) << change.name;
        EXPECT_EQ(contact.flags, found->second.flags) << change.name;
        EXPECT_LT(std::abs(contact.toi - found->second.toi), precision) << change.name;
      }
    }
  });
}

INSTANTIATE_TEST_SUITE_P(Levels, InvarianceAtExact, ::testing::Values(Accuracy::kExact));

}  // namespace
}  // namespace collided::test
