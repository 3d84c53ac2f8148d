#include "tests/gpu/solids/judged_solids.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <sstream>

#include "tests/gpu/judged_case.hpp"

namespace collided::test {
namespace {

using Place = std::array<long double, 3>;

long double length(const Place& p) { return std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]); }

/// The place with these weights, as seen from a vertex, and how far the farthest corner is.
std::pair<Place, long double> seen_place(const Vec3d& from, const std::array<Vec3d, 3>& corners,
                                         const std::array<double, 2>& weights) {
  const std::array<long double, 3> of{1 - static_cast<long double>(weights[0]) - weights[1], weights[0], weights[1]};
  Place sum{};
  long double size = 0;
  for (size_t i = 0; i < 3; ++i) {
    Place corner;
    for (size_t k = 0; k < 3; ++k) {
      corner[k] = static_cast<long double>(corners[i][k]) - from[k];
      sum[k] += of[i] * corner[k];
    }
    size = std::max(size, length(corner));
  }
  return {sum, size};
}

template <class Range>
uint32_t place_in(const Range& ends, uint32_t id) {
  return static_cast<uint32_t>(std::ranges::upper_bound(ends, id) - ends.begin());
}

}  // namespace

SceneSpec looking_into_solids(Accuracy accuracy, Scalar scalar) {
  SceneSpec spec = settings(Mode::kDcd, accuracy, scalar);
  spec.kinds = {.vertex_solid = true};
  spec.fields = {ContactField::kElements, ContactField::kDistance, ContactField::kWeights, ContactField::kNormals,
                 ContactField::kFlags};
  spec.pair_states = true;
  return spec;
}
SceneSpec spec_of(const SolidsScene& scene, SceneSpec settings) {
  settings.excluded_meshes = scene.excluded;
  return spec_for(scene.c, std::move(settings));
}
FrameResult run_solids(const SolidsScene& scene, const SceneSpec& settings) {
  const Frame frame(scene.c, Mode::kDcd, settings.scalar);
  return Detector::create(spec_of(scene, settings))->detect(frame.input());
}

SolidsScene placed(SolidsScene scene, double scale, double by) {
  const auto move = [&](Positions& positions) {
    for (Vec3d& p : positions)
      for (double& x : p) x = scale * (x + by);
  };
  for (auto* all : {&scene.c.start, &scene.c.end})
    for (Positions& mesh : *all) move(mesh);
  for (Pieces& pieces : scene.pieces)
    for (auto* some : {&pieces.within, &pieces.inside_out})
      for (Shape& piece : *some) move(piece.positions);
  return scene;
}

void Tally::print(const char* of) const {
  std::cout << of << ": touching " << states[0] << ", overlapping " << states[1] << ", first inside " << states[2]
            << ", second inside " << states[3] << ", apart " << apart << ", open " << open << "; vertices inside "
            << inside << " (with rivals " << rivals << "), on " << on << ", in twice or more " << deep
            << ", inside out " << inside_out << "; depths within " << static_cast<double>(ulps) << " ulp, places "
            << static_cast<double>(std::log2(place)) << ", normals " << static_cast<double>(std::log2(normal))
            << " (log2)\n";
}
void Tally::expect_all() const {
  for (const uint64_t count : states) EXPECT_GT(count, 0u);
  for (const uint64_t count : {apart, inside, on, deep, inside_out, rivals}) EXPECT_GT(count, 0u);
}

JudgedScene::JudgedScene(SolidsScene scene)
    : scene_(std::move(scene)), judge_(make_solids_judge(scene_)), truth_(judge_->judge()) {
  for (size_t m = 0; m < scene_.c.meshes.size(); ++m) {
    const MeshSpec& mesh = scene_.c.meshes[m];
    const auto first = static_cast<uint32_t>(positions_.size());
    positions_.insert(positions_.end(), scene_.c.end[m].begin(), scene_.c.end[m].end());
    for (const auto& t : mesh.triangles) triangles_.push_back({first + t[0], first + t[1], first + t[2]});
    triangles_.resize(triangles_.size() + mesh.edges.size() + mesh.points.size());
    vertex_end_.push_back(static_cast<uint32_t>(positions_.size()));
    triangle_end_.push_back(static_cast<uint32_t>(triangles_.size()));
  }
}

uint32_t JudgedScene::mesh_of_triangle(uint32_t triangle) const { return place_in(triangle_end_, triangle); }
uint32_t JudgedScene::mesh_of_vertex(uint32_t vertex) const { return place_in(vertex_end_, vertex); }

bool JudgedScene::expect(const FrameResult& result, Accuracy accuracy, Tally& tally) const {
  EXPECT_EQ(result.counts.inside_out, truth_.inside_out);
  const bool is_right = result.counts.inside_out == truth_.inside_out && expect_states(result) &&
                        expect_inside(result, accuracy, tally) && expect_deepest(result);
  for (const JudgedPair& pair : truth_.pairs)
    ++(pair.is_open ? tally.open : tally.states[static_cast<size_t>(pair.state)]);
  tally.apart += truth_.apart, tally.on += truth_.on, tally.deep += truth_.deep;
  tally.inside += truth_.inside.size(), tally.inside_out += truth_.inside_out;
  for (const JudgedInside& inside : truth_.inside) tally.rivals += inside.nearest.size() > 1;
  return is_right;
}
bool JudgedScene::expect_at(Accuracy accuracy, Scalar scalar, Tally& tally) const {
  SCOPED_TRACE(level_name(accuracy) + (scalar == Scalar::kF32 ? " F32" : " F64"));
  return expect(run_solids(scene_, looking_into_solids(accuracy, scalar)), accuracy, tally);
}

std::string JudgedScene::text_of(std::initializer_list<uint32_t> meshes) const {
  std::ostringstream out;
  out.precision(17);
  for (const uint32_t m : meshes) {
    out << "\nmesh " << m << (scene_.c.meshes[m].solid ? " solid" : "") << " {{";
    for (const Vec3d& p : scene_.c.end[m]) out << "{" << p[0] << "," << p[1] << "," << p[2] << "},";
    out << "}, {";
    for (const auto& t : scene_.c.meshes[m].triangles) out << "{" << t[0] << "," << t[1] << "," << t[2] << "},";
    out << "}} edges";
    for (const auto& e : scene_.c.meshes[m].edges) out << " " << e[0] << "-" << e[1];
    out << " points";
    for (const uint32_t v : scene_.c.meshes[m].points) out << " " << v;
  }
  return out.str();
}

bool JudgedScene::expect_states(const FrameResult& result) const {
  const auto key = [](const auto& pair) { return std::array{pair.first, pair.second}; };
  const auto& found = result.pair_states;
  for (size_t i = 0, k = 0; i < truth_.pairs.size() || k < found.size(); ++i, ++k) {
    const bool is_missing = k == found.size() || (i < truth_.pairs.size() && key(truth_.pairs[i]) < key(found[k]));
    const bool is_wrong = i == truth_.pairs.size() || (!is_missing && key(found[k]) < key(truth_.pairs[i]));
    if (is_missing || is_wrong) {
      const auto of = is_missing ? key(truth_.pairs[i]) : key(found[k]);
      ADD_FAILURE() << (is_missing ? "missing pair, state " : "wrong pair, state ")
                    << static_cast<int>(is_missing ? truth_.pairs[i].state : found[k].state) << text_of({of[0], of[1]});
      return false;
    }
    const JudgedPair& pair = truth_.pairs[i];
    const bool is_either =
        pair.is_open && (found[k].state == PairState::kOverlapping || found[k].state == PairState::kTouching);
    if ((is_either || found[k].state == pair.state) && found[k].first_inside == pair.first_inside &&
        found[k].second_inside == pair.second_inside)
      continue;
    ADD_FAILURE() << "state " << static_cast<int>(found[k].state) << " inside " << found[k].first_inside << " "
                  << found[k].second_inside << ", judged " << static_cast<int>(pair.state) << " inside "
                  << pair.first_inside << " " << pair.second_inside << text_of({pair.first, pair.second});
    return false;
  }
  return true;
}

/// By the depths that the answer has; these are judged by themselves.
bool JudgedScene::expect_deepest(const FrameResult& result) const {
  for (const MeshPairState& pair : result.pair_states) {
    uint32_t deepest = MeshPairState::kNoVertex;
    double depth = 0;
    for (size_t i = 0; i < result.vertex_solid.size(); ++i) {
      const auto [v, t] = result.vertex_solid.elements[i];
      const uint32_t own = mesh_of_vertex(v), solid = mesh_of_triangle(t);
      if (std::min(own, solid) != pair.first || std::max(own, solid) != pair.second) continue;
      const double of_v = -result.vertex_solid.distance[i];
      if (of_v > depth || (of_v == depth && v < deepest)) depth = of_v, deepest = v;
    }
    EXPECT_EQ(pair.deepest, deepest);
    EXPECT_EQ(pair.depth, depth);
    if (pair.deepest != deepest || pair.depth != depth) return false;
  }
  return true;
}

bool JudgedScene::expect_inside(const FrameResult& result, Accuracy accuracy, Tally& tally) const {
  const ContactSet& set = result.vertex_solid;
  EXPECT_EQ(result.counts.contacts.vertex_solid, truth_.inside.size());
  EXPECT_EQ(result.any_contact, !truth_.inside.empty());
  EXPECT_EQ(set.size(), truth_.inside.size());
  if (set.size() != truth_.inside.size()) return false;
  for (size_t i = 0; i < set.size(); ++i) {
    const JudgedInside& inside = truth_.inside[i];
    const auto [v, t] = set.elements[i];
    const auto fail = [&](const char* what) {
      ADD_FAILURE() << what << ": vertex " << v << " triangle " << t << ", judged " << inside.vertex << " in mesh "
                    << inside.mesh << " triangle " << inside.nearest.front()
                    << text_of({mesh_of_vertex(v), inside.mesh});
      return false;
    };
    if (v != inside.vertex || mesh_of_triangle(t) != inside.mesh) return fail("vertex inside");
    if (accuracy == Accuracy::kExact && t != inside.nearest.front()) return fail("nearest triangle");
    if (!std::ranges::binary_search(inside.nearest, t) && judge_->distance(v, t) > inside.depth * (1 + 0x1p-40L))
      return fail("far triangle");
    const long double ulp = std::ldexp(1.0L, std::max(std::ilogb(inside.depth) - 52, -1074)),
                      off = std::abs(set.distance[i] + inside.depth) / ulp;
    tally.ulps = std::max(tally.ulps, off);
    if (!(off <= 4)) return fail("depth");
    if (set.flags[i] != kFlagCertified) return fail("flags");
    if (!expect_place(set, i, tally)) return fail("place");
  }
  return true;
}
/// Weights are of a place at that depth, and the normal leads there.
bool JudgedScene::expect_place(const ContactSet& set, size_t i, Tally& tally) const {
  const auto [v, t] = set.elements[i];
  const auto& of = triangles_[t];
  const auto& w = set.weights[i];
  const auto [place, size] = seen_place(positions_[v], {positions_[of[0]], positions_[of[1]], positions_[of[2]]}, w);
  const long double depth = length(place), off = std::abs(depth + set.distance[i]) / size;
  long double turn = 0, unit = 0;
  for (size_t k = 0; k < 3; ++k) {
    turn = std::max(turn, std::abs(set.normals[i][k] - place[k] / depth));
    unit += static_cast<long double>(set.normals[i][k]) * set.normals[i][k];
  }
  tally.place = std::max(tally.place, off), tally.normal = std::max(tally.normal, turn);
  return w[0] >= 0 && w[1] >= 0 && 1 - w[0] - w[1] >= -0x1p-52 && off <= 0x1p-46L + 0x1p-1074L / size &&
         std::abs(unit - 1) < 0x1p-21L && turn <= 0x1p-22L + 0x1p-46L * size / depth;
}

}  // namespace collided::test
