#include "gpu/step/pair_states.hpp"

#include <unordered_map>

#include "gpu/base/keys.hpp"

namespace collided {
namespace {

/// What is found of two meshes.
struct PairFacts {
  MeshPairState pair;
  bool crosses = false, touches = false;
};

class PairsOfMeshes {
 public:
  explicit PairsOfMeshes(const SolidMeshes& meshes) : meshes_(meshes) {}

  void add_crossing(const EdgeAndTriangle& ids, bool is_sure) {
    PairFacts* facts = find(meshes_.mesh_of_edge(ids[0]), meshes_.mesh_of_triangle(ids[1]));
    if (facts == nullptr) return;
    facts->crosses = facts->crosses || is_sure;
    facts->touches = true;
  }
  /// A loose point has no edge that would tell.
  void add_on(uint32_t vertex, uint32_t solid) {
    if (PairFacts* facts = find(meshes_.mesh_of_vertex(vertex), meshes_.solids[solid])) facts->touches = true;
  }
  void add_inside(uint32_t vertex, uint32_t triangle, double depth) {
    const uint32_t own = meshes_.mesh_of_vertex(vertex), solid = meshes_.mesh_of_triangle(triangle);
    MeshPairState& pair = find(own, solid)->pair;
    ++(own == pair.first ? pair.first_inside : pair.second_inside);
    if (depth < pair.depth || (depth == pair.depth && vertex >= pair.deepest)) return;
    pair.depth = depth;
    pair.deepest = vertex;
  }
  std::vector<MeshPairState> finish(const OverlapDecision& decide) {
    std::vector<MeshPairState> states;
    states.reserve(pairs_.size());
    for (auto& [key, facts] : pairs_) {
      facts.pair.state = state_of(facts, decide);
      states.push_back(facts.pair);
    }
    std::sort(states.begin(), states.end(), [](const MeshPairState& a, const MeshPairState& b) {
      return pack_ids(a.first, a.second) < pack_ids(b.first, b.second);
    });
    return states;
  }

 private:
  /// Returns null for a mesh and itself, and where neither is a solid.
  PairFacts* find(uint32_t a, uint32_t b) {
    if (a == b || !(meshes_.are_solid[a] || meshes_.are_solid[b])) return nullptr;
    const auto [low, high] = std::minmax(a, b);
    PairFacts& facts = pairs_[pack_ids(low, high)];
    facts.pair.first = low, facts.pair.second = high;
    return &facts;
  }
  PairState state_of(const PairFacts& facts, const OverlapDecision& decide) const {
    const MeshPairState& pair = facts.pair;
    const bool has_inside = pair.first_inside > 0 || pair.second_inside > 0;
    if (facts.crosses) return PairState::kOverlapping;
    if (facts.touches)
      return has_inside || decide(pair.first, pair.second) ? PairState::kOverlapping : PairState::kTouching;
    if (pair.first_inside == meshes_.used[pair.first] && pair.second_inside == 0) return PairState::kFirstInside;
    if (pair.second_inside == meshes_.used[pair.second] && pair.first_inside == 0) return PairState::kSecondInside;
    return PairState::kOverlapping;
  }

  const SolidMeshes& meshes_;
  std::unordered_map<uint64_t, PairFacts> pairs_;
};

}  // namespace

std::vector<MeshPairState> find_pair_states(const FoundInSolids& found, const OverlapDecision& decide) {
  PairsOfMeshes pairs(found.meshes);
  for (size_t i = 0; i < found.crossings.size(); ++i)
    pairs.add_crossing(found.crossings.elements[i], (found.crossings.flags[i] & kFlagTouching) == 0);
  for (const EdgeAndTriangle& ids : found.ties) pairs.add_crossing(ids, false);
  for (const uint64_t pair : found.on) pairs.add_on(first_id(pair), second_id(pair));
  for (size_t i = 0; i < found.inside.size(); ++i)
    pairs.add_inside(found.inside.elements[i][0], found.inside.elements[i][1], -found.inside.distance[i]);
  return pairs.finish(decide);
}

}  // namespace collided
