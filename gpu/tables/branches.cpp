#include "gpu/tables/branches.hpp"

#include <algorithm>
#include <map>
#include <tuple>

namespace collided {
namespace {

constexpr double kFewPairs = 1.0 / 8;
constexpr double kSomePairs = 1.0 / 64;
constexpr double kLarge = 1.0 / 8;   ///< of all vertices; a mesh of so many has kSomePairs of all pairs in itself
constexpr size_t kFewBranches = 16;  ///< each walk may have to go through all of them
constexpr uint32_t kMaxBranches = 1u << 16;  ///< more would leave keys too few bits

/// Meshes of the same groups and mask, all static or none, that all touch themselves or none does.
struct RuleClass {
  MeshRule rule;
  double vertices = 0, squares = 0;  ///< sums over the meshes
  double excluded = 0;               ///< pairs of vertices of two meshes that are excluded

  /// Pairs of vertices of different meshes.
  double pairs() const { return (vertices * vertices - squares) / 2; }
};

class MeshClasses {
 public:
  MeshClasses(const SceneSpec& spec, const std::vector<MeshRule>& rules) : rules_(rules) {
    std::map<std::tuple<uint32_t, uint32_t, uint32_t, uint32_t>, size_t> known;
    for (size_t i = 0; i < rules.size(); ++i) {
      const MeshRule& rule = rules[i];
      const auto [at, is_new] =
          known.try_emplace({rule.groups, rule.collide_mask, rule.is_static, rule.has_self_contacts}, classes_.size());
      if (is_new) classes_.push_back({rule});
      of_mesh_.push_back(at->second);
      sizes_.push_back(rule.is_idle != 0 ? 0 : spec.meshes[i].vertex_count);
      add_mesh(classes_[at->second], sizes_[i], touches_itself(rule));
    }
    for (const auto& [first, second] : spec.excluded_meshes)
      if (first != second && may_touch(rules[first], rules[second]))
        exclude(first, second, sizes_[first] * sizes_[second]);
  }

  bool are_countable() const { return vertices_ > 0 && classes_.size() <= kMaxRuleClasses; }
  bool keep_most_apart() const {
    double touching = itself_ - excluded_;
    for_each_pair([&](const RuleClass& p, const RuleClass& q, double pairs) {
      if (may_touch(p.rule, q.rule)) touching += pairs;
    });
    return touching <= kFewPairs * all_pairs();
  }
  /// Counts what moves: nothing else makes large boxes, which overlap although nothing touches.
  bool keep_some_apart() const {
    double apart = excluded_;
    for_each_pair([&](const RuleClass& p, const RuleClass& q, double pairs) {
      const bool moves = p.rule.is_static == 0 || q.rule.is_static == 0;
      if (moves && !may_touch(p.rule, q.rule)) apart += pairs;
    });
    for (size_t mesh = 0; mesh < rules_.size(); ++mesh)
      if (is_large(mesh)) apart += sizes_[mesh] * sizes_[mesh] / 2;
    return apart >= kSomePairs * all_pairs();
  }
  /// Without branches of single meshes: of the classes alone.
  std::vector<uint32_t> branches(bool has_single) const {
    constexpr uint32_t kNone = ~0u;
    std::vector<uint32_t> of_class(classes_.size(), kNone), of_mesh;
    uint32_t next = 0;
    for (size_t i = 0; i < rules_.size(); ++i) {
      uint32_t& shared = of_class[of_mesh_[i]];
      const bool is_single = has_single && (is_single_branch(i) || is_large(i));
      if (!is_single && shared == kNone) shared = next++;
      of_mesh.push_back(is_single ? next++ : shared);
    }
    return of_mesh;
  }

 private:
  double all_pairs() const { return vertices_ * vertices_ / 2; }
  /// use(class, class, pairs of vertices of different meshes), whatever is excluded.
  template <class Use>
  void for_each_pair(const Use& use) const {
    for (size_t a = 0; a < classes_.size(); ++a)
      for (size_t b = a; b < classes_.size(); ++b)
        use(classes_[a], classes_[b], a == b ? classes_[a].pairs() : classes_[a].vertices * classes_[b].vertices);
  }
  /// True for a mesh that may not touch itself and holds a large share of the scene. It needs its own branch, because a
  /// node of several meshes does not show that all triangles below belong to one.
  bool is_large(size_t mesh) const {
    const MeshRule& rule = rules_[mesh];
    return rule.is_static == 0 && !touches_itself(rule) && sizes_[mesh] >= kLarge * vertices_;
  }

  void add_mesh(RuleClass& of, double vertices, bool touches_itself) {
    of.vertices += vertices, of.squares += vertices * vertices;
    vertices_ += vertices;
    if (touches_itself) itself_ += vertices * vertices / 2;
  }
  void exclude(uint32_t first, uint32_t second, double pairs) {
    excluded_ += pairs;
    if (of_mesh_[first] == of_mesh_[second]) classes_[of_mesh_[first]].excluded += pairs;
  }
  /// True if exclusions keep the mesh from most others of its class, which groups and masks would let it touch.
  bool is_single_branch(size_t mesh) const {
    const RuleClass& like = classes_[of_mesh_[mesh]];
    return may_touch(like.rule, like.rule) && like.pairs() - like.excluded <= kFewPairs * like.pairs();
  }

  const std::vector<MeshRule>& rules_;
  std::vector<RuleClass> classes_;
  std::vector<size_t> of_mesh_;  ///< each one's class
  std::vector<double> sizes_;    ///< vertices of each mesh; 0 of those that take no part
  double vertices_ = 0;
  double itself_ = 0, excluded_ = 0;  ///< pairs of vertices: of meshes that touch themselves, of excluded meshes
};

}  // namespace

std::vector<uint32_t> branches_of(const SceneSpec& spec, const std::vector<MeshRule>& rules) {
  if (rules.empty()) return {};
  const MeshClasses classes(spec, rules);
  if (!classes.are_countable()) return {};
  const std::vector<uint32_t> branches = classes.branches(true);
  const uint32_t highest = *std::max_element(branches.begin(), branches.end());
  if (!classes.keep_most_apart())
    return highest < kFewBranches && classes.keep_some_apart() ? branches : std::vector<uint32_t>{};
  return highest < kMaxBranches ? branches : classes.branches(false);
}

}  // namespace collided
