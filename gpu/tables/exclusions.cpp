#include "gpu/tables/exclusions.hpp"

#include <algorithm>

#include "gpu/tables/branches.hpp"

namespace collided {
namespace {

std::vector<MeshRule> rules_without_branches(const SceneSpec& spec) {
  std::vector<MeshRule> rules;
  for (const MeshSpec& m : spec.meshes) {
    const bool is_free = m.self_contacts && m.motion != MeshMotion::kRigid;
    const bool has_self_contacts = is_free && (m.groups & m.collide_mask) != 0;
    rules.push_back({m.groups, m.collide_mask, m.motion == MeshMotion::kStatic ? 1u : 0u, has_self_contacts ? 1u : 0u});
  }
  for (const auto& [first, second] : spec.excluded_meshes)
    if (first == second) rules[first].has_self_contacts = 0;
  return rules;
}

}  // namespace

std::vector<MeshRule> mesh_rules(const SceneSpec& spec) {
  std::vector<MeshRule> rules = rules_without_branches(spec);
  const std::vector<uint32_t> branches = branches_of(spec, rules);
  for (size_t i = 0; i < branches.size(); ++i) rules[i].branch = branches[i];
  return rules;
}

uint32_t count_branches(const SceneSpec& spec) {
  const std::vector<uint32_t> branches = branches_of(spec, rules_without_branches(spec));
  return branches.empty() ? 0 : *std::max_element(branches.begin(), branches.end()) + 1;
}

std::vector<MeshRule> rest_rules(const SceneSpec& spec, const std::vector<bool>& meshes) {
  std::vector<MeshRule> rules = mesh_rules(spec);
  for (size_t i = 0; i < rules.size(); ++i) {
    rules[i].groups = 0;
    if (!meshes[i] || !spec.meshes[i].excludes_rest_pairs) rules[i].has_self_contacts = 0;
  }
  return rules;
}

bool may_touch(const std::vector<MeshRule>& rest_rules) {
  return std::any_of(rest_rules.begin(), rest_rules.end(),
                     [](const MeshRule& rule) { return rule.is_static == 0 && rule.has_self_contacts != 0; });
}

bool needs_pair_filter(const SceneSpec& spec) {
  const auto is_limited = [](const MeshSpec& m) {
    return m.groups != 1 || m.collide_mask != ~0u || !m.self_contacts || m.motion != MeshMotion::kDeformable;
  };
  return !spec.excluded_meshes.empty() || excludes_rest_pairs(spec) ||
         std::any_of(spec.meshes.begin(), spec.meshes.end(), is_limited);
}

bool excludes_rest_pairs(const SceneSpec& spec) {
  return may_touch(rest_rules(spec, std::vector<bool>(spec.meshes.size(), true)));
}

std::vector<uint64_t> excluded_mesh_slots(const SceneSpec& spec) {
  std::vector<uint64_t> keys;
  for (const auto& [first, second] : spec.excluded_meshes)
    if (first != second) keys.push_back(pack_ids(std::min(first, second), std::max(first, second)));
  std::vector<uint64_t> slots(key_slots(keys.size()), kNoKey);
  for (const uint64_t key : keys) add_key(slots, key);
  return slots;
}

}  // namespace collided
