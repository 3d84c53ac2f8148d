#include "tests/gpu/narrow/covering_judge.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace collided::test {
namespace {

/// Squared slopes: a bit is never set up to the first, and always from the second on.
const mpq_class kShallow(1, 64 * 64), kSteep(1, 32 * 32);
/// Of the extent of a contact's features: gaps that doubles know well.
constexpr double kClearGap = 0x1p-20;
/// The same of the points that weights give.
constexpr double kRoundingOfPoints = 1e-4;

int orientation(const ExactPoint& a, const ExactPoint& b, const ExactPoint& c, const ExactPoint& d) {
  const ExactPoint p = b - a, q = c - a, r = d - a;
  return sgn(p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2]) +
             p[2] * (q[0] * r[1] - q[1] * r[0]));
}

ExactPoint cross_product(const ExactPoint& a, const ExactPoint& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length_of(const ExactPoint& d) { return std::sqrt(product(d, d).get_d()); }

bool includes(const std::vector<uint32_t>& all, const std::vector<uint32_t>& some) {
  return std::includes(all.begin(), all.end(), some.begin(), some.end());
}
bool share_one(const std::vector<uint32_t>& some, const std::vector<uint32_t>& others) {
  return std::find_first_of(some.begin(), some.end(), others.begin(), others.end()) != some.end();
}

}  // namespace

CoveringCounts& CoveringCounts::operator+=(const CoveringCounts& other) {
  contacts += other.contacts, kept += other.kept, same += other.same, nearer += other.nearer;
  crossing += other.crossing, shallow += other.shallow, steep += other.steep, unsure += other.unsure;
  descents += other.descents, left_out += other.left_out, faces += other.faces, supports += other.supports;
  return *this;
}

CoveringJudge::CoveringJudge(const Case& c, const Topology& topology)
    : topology_(topology), elements_of_(topology.vertex_count) {
  for (uint32_t mesh = 0; mesh < c.end.size(); ++mesh)
    for (const Vec3d& p : c.end[mesh]) {
      positions_.push_back(p);
      points_.push_back(exact_point(p));
      mesh_of_vertex_.push_back(mesh);
    }
  for (uint32_t element = 0; element < topology_.triangles.size(); ++element) {
    const auto& t = topology_.triangles[element];
    std::set<uint32_t> vertices(t.begin(), t.end());
    for (const uint32_t v : vertices) elements_of_[v].push_back(element);
    vertices_of_.emplace_back(vertices.begin(), vertices.end());
  }
}

std::array<uint32_t, 4> CoveringJudge::stencil_of(QueryKind kind, const std::array<uint32_t, 2>& elements) const {
  if (kind == QueryKind::kVertexTriangle) {
    const auto& t = topology_.triangles[elements[1]];
    return {elements[0], t[0], t[1], t[2]};
  }
  const auto &a = topology_.edges[elements[0]], &b = topology_.edges[elements[1]];
  return {a[0], a[1], b[0], b[1]};
}

std::array<CoveringJudge::Feature, 2> CoveringJudge::named(const Contact& contact, uint32_t element) const {
  constexpr uint8_t kBits = kOfTriangle | kOfFirstEdge | kOfSecondEdge;
  const FeaturePair* pair = find_feature_pair(contact.kind, contact.features & kBits);
  if (pair == nullptr) {
    ADD_FAILURE() << "no features have the byte " << int{contact.features};
    pair = &feature_pairs(contact.kind).front();
  }
  std::array<Feature, 2> features;
  for (const size_t i : pair->first) features[0].vertices.push_back(contact.stencil[i]);
  for (const size_t i : pair->second) features[1].vertices.push_back(contact.stencil[i]);
  for (Feature& feature : features) {
    std::sort(feature.vertices.begin(), feature.vertices.end());
    if (feature.vertices.size() == 3) feature.element = element;
  }
  return features;
}

JudgedFeatures CoveringJudge::truth_of(const Contact& contact) const {
  const auto& s = contact.stencil;
  return judge_features(contact.kind, {points_[s[0]], points_[s[1]], points_[s[2]], points_[s[3]]}, s);
}

std::vector<uint32_t> CoveringJudge::elements_at(const Feature& feature) const {
  if (feature.vertices.size() == 3) return {feature.element};
  std::vector<uint32_t> found;
  for (const uint32_t element : elements_of_[feature.vertices[0]])
    if (includes(vertices_of_[element], feature.vertices)) found.push_back(element);
  return found;
}

/// `way`: the vector from the feature's closest point to the other's.
CoveringJudge::Descent CoveringJudge::descent_at(const Feature& feature, const ExactPoint& way) const {
  Descent descent;
  const mpq_class length = product(way, way);
  if (length == 0 || feature.vertices.size() == 3) return descent;
  for (const uint32_t element : elements_at(feature)) {
    mpq_class best = 0;
    // Along a direction of the surface; only the part of `way` along it counts.
    const auto try_direction = [&](const ExactPoint& d) {
      const mpq_class along = product(way, d), size = product(d, d);
      if (along > 0) best = std::max(best, mpq_class(along * along / (size * length)));
    };
    const std::vector<uint32_t>& vertices = vertices_of_[element];
    const ExactPoint& at = points_[feature.vertices[0]];
    std::vector<ExactPoint> sides;
    for (const uint32_t v : vertices)
      if (!std::count(feature.vertices.begin(), feature.vertices.end(), v)) sides.push_back(points_[v] - at);
    if (feature.vertices.size() == 2 && sides.size() == 1) {  // the part across the edge
      const ExactPoint edge = points_[feature.vertices[1]] - at;
      const mpq_class size = product(edge, edge);
      ExactPoint across = sides[0];
      const mpq_class share = size > 0 ? mpq_class(product(across, edge) / size) : mpq_class(0);
      for (size_t k = 0; k < 3; ++k) across[k] -= share * edge[k];
      try_direction(across);
    } else if (feature.vertices.size() == 1) {
      for (const ExactPoint& side : sides) try_direction(side);
      if (sides.size() == 2) {
        const mpq_class a = product(sides[0], sides[0]), b = product(sides[0], sides[1]),
                        c = product(sides[1], sides[1]), u = product(way, sides[0]), v = product(way, sides[1]),
                        first = u * c - v * b, second = v * a - u * b;
        if (a * c != b * b && first >= 0 && second >= 0) {
          ExactPoint inside;
          for (size_t k = 0; k < 3; ++k) inside[k] = first * sides[0][k] + second * sides[1][k];
          try_direction(inside);
        }
      }
    }
    if (best > 0) descent.elements.push_back(element);
    descent.squared_slope = std::max(descent.squared_slope, best);
  }
  return descent;
}

bool CoveringJudge::crosses(uint32_t edge, uint32_t element) const {
  const auto [u, v] = topology_.edges[edge];
  const std::vector<uint32_t>& t = vertices_of_[element];
  if (t.size() < 3 || share_one(t, {u, v})) return false;
  for (size_t k = 0; k < 3; ++k) {
    const auto [low, high] = std::minmax(positions_[u][k], positions_[v][k]);
    const auto [from, to] = std::minmax({positions_[t[0]][k], positions_[t[1]][k], positions_[t[2]][k]});
    if (high < from || to < low) return false;
  }
  const auto side = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    return orientation(points_[a], points_[b], points_[c], points_[d]);
  };
  if (side(t[0], t[1], t[2], u) * side(t[0], t[1], t[2], v) >= 0) return false;
  const int turn = side(u, v, t[0], t[1]);
  return turn != 0 && side(u, v, t[1], t[2]) == turn && side(u, v, t[2], t[0]) == turn;
}

bool CoveringJudge::cross(uint32_t mesh, uint32_t other) {
  const std::array<uint32_t, 2> meshes = {std::min(mesh, other), std::max(mesh, other)};
  if (const auto found = cross_.find(meshes); found != cross_.end()) return found->second;
  bool any = false;
  for (uint32_t edge = 0; edge < topology_.edges.size() && !any; ++edge)
    for (uint32_t element = 0; element < vertices_of_.size() && !any; ++element) {
      const uint32_t a = mesh_of_vertex_[topology_.edges[edge][0]], b = mesh_of_vertex_[vertices_of_[element][0]];
      any = std::min(a, b) == meshes[0] && std::max(a, b) == meshes[1] && crosses(edge, element);
    }
  return cross_[meshes] = any;
}

CoveringJudge::Between& CoveringJudge::between(const Key& key) {
  const auto [entry, is_new] = pairs_.try_emplace(key);
  Between& pair = entry->second;
  if (!is_new) return pair;
  std::vector<ExactPoint> points[2];
  for (size_t side = 0; side < 2; ++side)
    for (const uint32_t v : key[side].vertices) points[side].push_back(points_[v]);
  if (const auto gap = gap_of_hulls(points[0], points[1])) {
    pair.gap = gap->vector;
    pair.squared = product(gap->vector, gap->vector);
    pair.descent[0] = descent_at(key[0], ExactPoint{} - gap->vector);
    pair.descent[1] = descent_at(key[1], gap->vector);
  }
  pair.meshes_cross = cross(mesh_of(key[0]), mesh_of(key[1]));
  return pair;
}

double CoveringJudge::extent_of(const Contact& contact) const {
  double extent = 0;
  for (const uint32_t v : contact.stencil)
    for (size_t k = 0; k < 3; ++k)
      extent = std::max(extent, std::abs(positions_[v][k] - positions_[contact.stencil[0]][k]));
  return extent;
}

void CoveringJudge::expect_features(const Contact& contact, const Key& ordered, Accuracy accuracy,
                                    CoveringCounts& counts) {
  auto& truths = truths_[contact.kind == QueryKind::kVertexTriangle ? 0 : 1];
  auto known = truths.find(contact.stencil);
  if (known == truths.end()) known = truths.emplace(contact.stencil, truth_of(contact)).first;
  const JudgedFeatures& truth = known->second;
  const uint8_t features = contact.features & (kOfTriangle | kOfFirstEdge | kOfSecondEdge);
  if (features == truth.features) return;
  EXPECT_NE(accuracy, Accuracy::kExact) << "features " << int{features} << ", not " << int{truth.features};
  // Rounding took others that are as near.
  ++counts.unsure;
  const Between& pair = between(ordered);
  if (!pair.gap) return;
  EXPECT_LE(std::abs(std::sqrt(pair.squared.get_d()) - std::sqrt(truth.squared.get_d())), 1e-7 * extent_of(contact))
      << "features " << int{features} << ", not " << int{truth.features};
}

/// Weights give the points of the features that are named, though others may be as near.
void CoveringJudge::expect_points(const Contact& contact, const Between& pair, bool is_swapped,
                                  const std::array<double, 2>& weights, Accuracy accuracy) const {
  const auto [w0, w1] = weights;
  std::array<double, 4> of_stencil = {1, w0 + w1 - 1, -w0, -w1};
  if (contact.kind == QueryKind::kEdgeEdge) {
    of_stencil = {1 - w0, w0, w1 - 1, -w1};
    const int first = contact.features & kOfFirstEdge, second = (contact.features & kOfSecondEdge) / 4;
    EXPECT_TRUE(first == 0 || w0 == first - 1) << "end " << first << ", weight " << w0;
    EXPECT_TRUE(second == 0 || w1 == second - 1) << "end " << second << ", weight " << w1;
  }
  if (accuracy == Accuracy::kFast || !pair.gap) return;  // FAST guarantees nothing, and thin triangles show it
  for (size_t k = 0; k < 3; ++k) {
    double between = 0;
    for (size_t i = 0; i < 4; ++i)
      between += of_stencil[i] * (positions_[contact.stencil[i]][k] - positions_[contact.stencil[3]][k]);
    EXPECT_NEAR(between, (is_swapped ? -1 : 1) * (*pair.gap)[k].get_d(), kRoundingOfPoints * extent_of(contact)) << k;
  }
}

void CoveringJudge::expect_slopes(const Between& pair, uint8_t bits, CoveringCounts& counts) const {
  for (const int side : {0, 1}) {
    const bool is_set = (bits >> side & 1) != 0;
    const mpq_class& slope = pair.descent[side].squared_slope;
    if (slope <= kShallow) {
      ++counts.shallow;
      EXPECT_FALSE(is_set) << "a squared slope of " << slope.get_d();
    } else if (slope > kSteep) {
      ++counts.steep;
      EXPECT_TRUE(is_set) << "a squared slope of " << slope.get_d();
    }
  }
}

bool CoveringJudge::has_nearer(const Key& key, const Between& pair, int side, bool& is_left_out) const {
  const Feature& other = key[1 - side];
  for (const uint32_t near : pair.descent[side].elements)
    for (const uint32_t far : elements_at(other)) {
      is_left_out = is_left_out || share_one(vertices_of_[near], vertices_of_[far]);
      for (const auto& [features, known] : pairs_)
        for (const size_t i : {0u, 1u})
          if (includes(vertices_of_[near], features[i].vertices) &&
              includes(vertices_of_[far], features[1 - i].vertices) && known.count > 0 && known.gap &&
              known.squared < pair.squared)
            return true;
    }
  return false;
}

/// Where the surface comes nearer, a contact of these surfaces is nearer. So the nearest of those that lead to each
/// other is kept.
void CoveringJudge::expect_nearer_contacts(CoveringCounts& counts) const {
  for (const auto& [key, pair] : pairs_)
    for (const int side : {0, 1}) {
      if (pair.count == 0 || pair.meshes_cross || (*pair.bits >> side & 1) == 0) continue;
      bool is_left_out = false;
      if (has_nearer(key, pair, side, is_left_out))
        ++counts.descents;
      else if (is_left_out)
        ++counts.left_out;
      else
        ADD_FAILURE() << "nothing that is nearer is in the answer";
    }
}

CoveringCounts CoveringJudge::expect(const FrameResult& found, Accuracy accuracy, bool has_both, bool is_complete) {
  CoveringCounts counts;
  for (auto& [key, pair] : pairs_) pair.bits = std::nullopt, pair.count = pair.kept = 0;
  const auto look = [&](QueryKind kind, const ContactSet& set) {
    ASSERT_EQ(set.features.size(), set.size());
    ASSERT_EQ(set.flags.size(), set.size());
    for (size_t i = 0; i < set.size() && !::testing::Test::HasFatalFailure(); ++i) {
      const Contact contact{kind, stencil_of(kind, set.elements[i]), set.features[i], set.flags[i]};
      SCOPED_TRACE((kind == QueryKind::kVertexTriangle ? "vertex " : "edge ") + std::to_string(set.elements[i][0]) +
                   ", " + std::to_string(set.elements[i][1]));
      Key key = named(contact, set.elements[i][1]);
      const bool is_swapped = key[1] < key[0];
      if (is_swapped) std::swap(key[0], key[1]);
      expect_features(contact, key, accuracy, counts);
      Between& pair = between(key);
      const bool first = (contact.features & kNearerAtFirst) != 0, second = (contact.features & kNearerAtSecond) != 0,
                 is_same = (contact.features & kSameAsBefore) != 0, is_covered = (contact.flags & kFlagCovered) != 0;
      const auto bits = static_cast<uint8_t>((is_swapped ? second : first) | (is_swapped ? first : second) << 1);
      EXPECT_EQ(contact.features & 128, 0);
      EXPECT_EQ(is_same, pair.count > 0) << "an earlier contact with the same features";
      EXPECT_EQ(bits, pair.bits.value_or(bits)) << "contacts with the same features have the same surfaces";
      pair.bits = bits;
      EXPECT_TRUE(bits == 0 || !pair.gap || pair.squared > 0) << "nothing is nearer than what touches";
      if (pair.gap && std::sqrt(pair.squared.get_d()) > kClearGap * extent_of(contact))
        expect_slopes(pair, bits, counts);
      expect_points(contact, pair, is_swapped, set.weights[i], accuracy);
      EXPECT_EQ(is_covered, has_both && ((bits != 0 && !pair.meshes_cross) || is_same));
      ++pair.count;
      pair.kept += !is_covered;
      ++counts.contacts, counts.kept += !is_covered, counts.same += is_same, counts.nearer += bits != 0;
      counts.crossing += pair.meshes_cross;
    }
  };
  look(QueryKind::kVertexTriangle, found.vertex_triangle);
  look(QueryKind::kEdgeEdge, found.edge_edge);
  if (!has_both) return counts;
  for (const auto& [key, pair] : pairs_)
    EXPECT_EQ(pair.kept, pair.count == 0 || (*pair.bits != 0 && !pair.meshes_cross) ? 0u : 1u);
  if (is_complete) expect_nearer_contacts(counts);
  return counts;
}

/// From the feature along its mesh: from a corner along its sides; from a side along it, both ways, and to the opposite
/// corners; on a face along two sides, both ways.
std::vector<ExactPoint> CoveringJudge::directions_into(const Feature& feature) const {
  std::vector<ExactPoint> directions;
  const ExactPoint& at = points_[feature.vertices[0]];
  for (size_t i = 1; i < feature.vertices.size(); ++i)
    for (const ExactPoint& along : {points_[feature.vertices[i]] - at, at - points_[feature.vertices[i]]})
      directions.push_back(along);
  for (const uint32_t element : elements_at(feature))
    for (const uint32_t v : vertices_of_[element])
      if (!std::count(feature.vertices.begin(), feature.vertices.end(), v)) directions.push_back(points_[v] - at);
  return directions;
}

void CoveringJudge::expect_normal(const std::array<Feature, 2>& touching, const Normal& normal,
                                  CoveringCounts& counts) const {
  const std::vector<ExactPoint> into[2] = {directions_into(touching[0]), directions_into(touching[1])};
  const auto supports = [&](const ExactPoint& n) {
    const auto against = [&](const ExactPoint& d, int side) { return side * sgn(product(n, d)) < 0; };
    return std::none_of(into[0].begin(), into[0].end(), [&](const ExactPoint& d) { return against(d, 1); }) &&
           std::none_of(into[1].begin(), into[1].end(), [&](const ExactPoint& d) { return against(d, -1); });
  };
  const auto supporting = [&](const ExactPoint& n) -> std::optional<ExactPoint> {
    if (product(n, n) == 0) return std::nullopt;
    if (supports(n)) return n;
    const ExactPoint opposite = ExactPoint{} - n;
    return supports(opposite) ? std::optional(opposite) : std::nullopt;
  };
  for (const size_t side : {1u, 0u})
    for (const uint32_t element : elements_at(touching[side])) {
      const auto& t = topology_.triangles[element];
      const auto n = supporting(cross_product(points_[t[1]] - points_[t[0]], points_[t[2]] - points_[t[0]]));
      if (!n) continue;
      ++counts.faces;
      for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(normal[k], (*n)[k].get_d() / length_of(*n), 1e-6) << k;
      return;
    }
  std::vector<ExactPoint> all = into[0];
  all.insert(all.end(), into[1].begin(), into[1].end());
  if (std::none_of(all.begin(), all.end(), [&](const ExactPoint& a) {
        return std::any_of(all.begin(), all.end(),
                           [&](const ExactPoint& b) { return supporting(cross_product(a, b)).has_value(); });
      }))
    return;
  ++counts.supports;
  for (const int side : {0, 1})
    for (const ExactPoint& d : into[side]) {
      const double along = normal[0] * d[0].get_d() + normal[1] * d[1].get_d() + normal[2] * d[2].get_d();
      EXPECT_GE(side == 0 ? along : -along, -1e-6 * length_of(d)) << "a direction of surface " << side;
    }
}

CoveringCounts CoveringJudge::expect_normals(const FrameResult& found) const {
  CoveringCounts counts;
  const auto look = [&](QueryKind kind, const ContactSet& set) {
    for (size_t i = 0; i < set.size(); ++i) {
      Contact contact{kind, stencil_of(kind, set.elements[i]), 0, 0};
      const JudgedFeatures truth = truth_of(contact);
      if (truth.squared > 0) continue;
      contact.features = truth.features;
      SCOPED_TRACE((kind == QueryKind::kVertexTriangle ? "vertex " : "edge ") + std::to_string(set.elements[i][0]) +
                   ", " + std::to_string(set.elements[i][1]));
      expect_normal(named(contact, set.elements[i][1]), set.normals[i], counts);
    }
  };
  look(QueryKind::kVertexTriangle, found.vertex_triangle);
  look(QueryKind::kEdgeEdge, found.edge_edge);
  return counts;
}

}  // namespace collided::test
