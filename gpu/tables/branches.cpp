#include "gpu/tables/branches.hpp"

#include <algorithm>
#include <map>
#include <tuple>

namespace collided {
namespace {

constexpr double kFewPairs = 1.0 / 8;
constexpr size_t kMaxClasses = 1024;         ///< all of which are compared with each other
constexpr uint32_t kMaxBranches = 1u << 16;  ///< more would leave keys too few bits

/// Meshes of the same groups and mask, all static or none.
struct RuleClass {
  MeshRule rule;
  double vertices = 0, squares = 0;  ///< sums over the meshes
  double excluded = 0;               ///< pairs of vertices of two meshes that are excluded

  /// Pairs of vertices of different meshes.
  double pairs() const { return (vertices * vertices - squares) / 2; }
};

bool may_touch(const MeshRule& a, const MeshRule& b) {
  return (a.is_static == 0 || b.is_static == 0) && (a.groups & b.collide_mask) != 0 && (b.groups & a.collide_mask) != 0;
}
bool touches_itself(const MeshRule& rule) { return rule.is_static == 0 && rule.has_self_contacts != 0; }

class MeshClasses {
 public:
  MeshClasses(const SceneSpec& spec, const std::vector<MeshRule>& rules) : rules_(rules) {
    std::map<std::tuple<uint32_t, uint32_t, uint32_t>, size_t> known;
    for (size_t i = 0; i < rules.size(); ++i) {
      const MeshRule& rule = rules[i];
      const auto [at, is_new] = known.try_emplace({rule.groups, rule.collide_mask, rule.is_static}, classes_.size());
      if (is_new) classes_.push_back({rule});
      of_mesh_.push_back(at->second);
      add_mesh(classes_[at->second], spec.meshes[i].vertex_count, touches_itself(rule));
    }
    for (const auto& [first, second] : spec.excluded_meshes)
      if (first != second && may_touch(rules[first], rules[second]))
        exclude(first, second, static_cast<double>(spec.meshes[first].vertex_count) * spec.meshes[second].vertex_count);
  }

  bool keep_most_apart() const {
    if (classes_.size() > kMaxClasses) return false;
    double touching = itself_ - excluded_;
    for (size_t a = 0; a < classes_.size(); ++a)
      for (size_t b = a; b < classes_.size(); ++b)
        if (may_touch(classes_[a].rule, classes_[b].rule))
          touching += a == b ? classes_[a].pairs() : classes_[a].vertices * classes_[b].vertices;
    return touching <= kFewPairs * vertices_ * vertices_ / 2;
  }
  /// Without branches of single meshes: of the classes alone.
  std::vector<uint32_t> branches(bool has_single) const {
    constexpr uint32_t kNone = ~0u;
    std::vector<uint32_t> of_class(classes_.size(), kNone), of_mesh;
    uint32_t next = 0;
    for (size_t i = 0; i < rules_.size(); ++i) {
      uint32_t& shared = of_class[of_mesh_[i]];
      const bool is_single = has_single && is_single_branch(i);
      if (!is_single && shared == kNone) shared = next++;
      of_mesh.push_back(is_single ? next++ : shared);
    }
    return of_mesh;
  }

 private:
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
  double vertices_ = 0;
  double itself_ = 0, excluded_ = 0;  ///< pairs of vertices: of meshes that touch themselves, of excluded meshes
};

}  // namespace

std::vector<uint32_t> branches_of(const SceneSpec& spec, const std::vector<MeshRule>& rules) {
  if (rules.empty()) return {};
  const MeshClasses classes(spec, rules);
  if (!classes.keep_most_apart()) return {};
  const std::vector<uint32_t> branches = classes.branches(true);
  const bool are_too_many = *std::max_element(branches.begin(), branches.end()) >= kMaxBranches;
  return are_too_many ? classes.branches(false) : branches;
}

}  // namespace collided
