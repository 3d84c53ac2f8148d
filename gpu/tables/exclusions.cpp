#include "gpu/tables/exclusions.hpp"

#include <algorithm>
#include <map>
#include <tuple>

#include "gpu/tables/branches.hpp"

namespace collided {
namespace {

/// Sets MeshRule::is_idle.
void mark_idle(const SceneSpec& spec, std::vector<MeshRule>& rules) {
  struct Class {
    MeshRule rule;
    uint64_t meshes = 0, partners = 0;
  };
  const auto key = [](const MeshRule& rule) { return std::tuple(rule.groups, rule.collide_mask, rule.is_static); };
  std::map<std::tuple<uint32_t, uint32_t, uint32_t>, Class> classes;
  for (const MeshRule& rule : rules) {
    Class& like = classes.try_emplace(key(rule), Class{rule}).first->second;
    ++like.meshes;
  }
  if (classes.size() > kMaxRuleClasses) return;
  for (auto& [of_one, one] : classes)
    for (const auto& [of_other, other] : classes)
      if (may_touch(one.rule, other.rule)) one.partners += other.meshes - (of_one == of_other ? 1 : 0);

  std::vector<uint64_t> partners;
  for (const MeshRule& rule : rules) partners.push_back(classes.at(key(rule)).partners);
  for (const auto& [first, second] : spec.excluded_meshes)
    if (first != second && may_touch(rules[first], rules[second])) --partners[first], --partners[second];
  for (size_t i = 0; i < rules.size(); ++i) rules[i].is_idle = partners[i] == 0 && !touches_itself(rules[i]) ? 1 : 0;
}

std::vector<MeshRule> rules_without_branches(const SceneSpec& spec) {
  std::vector<MeshRule> rules;
  for (const MeshSpec& m : spec.meshes) {
    const bool is_free = m.self_contacts && m.motion != MeshMotion::kRigid;
    const bool has_self_contacts = is_free && (m.groups & m.collide_mask) != 0;
    rules.push_back({m.groups, m.collide_mask, m.motion == MeshMotion::kStatic ? 1u : 0u, has_self_contacts ? 1u : 0u});
  }
  for (const auto& [first, second] : spec.excluded_meshes)
    if (first == second) rules[first].has_self_contacts = 0;
  mark_idle(spec, rules);
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
    rules[i].is_idle = touches_itself(rules[i]) ? 0 : 1;
  }
  return rules;
}

bool may_touch(const std::vector<MeshRule>& rest_rules) {
  return std::any_of(rest_rules.begin(), rest_rules.end(), [](const MeshRule& rule) { return touches_itself(rule); });
}

IdleMeshes idle_meshes(const SceneSpec& spec) {
  IdleMeshes idle;
  for (const MeshRule& rule : rules_without_branches(spec)) idle.meshes.push_back(rule.is_idle != 0);
  const auto count = static_cast<size_t>(std::count(idle.meshes.begin(), idle.meshes.end(), true));
  if (count == 0) return {};
  idle.are_all = count == idle.meshes.size();
  return idle;
}

// Meshes of one rule are looked at together: pairs of two rules that may touch are gone through only as long as they
// are excluded one by one.
std::optional<std::array<uint32_t, 2>> find_tested_pair(const SceneSpec& spec, const std::vector<bool>& among) {
  const std::vector<MeshRule> rules = rules_without_branches(spec);
  const std::vector<uint64_t> slots = excluded_mesh_slots(spec);
  const KeySet excluded{Span<const uint64_t>(slots.data(), slots.size())};
  std::map<std::tuple<uint32_t, uint32_t, uint32_t>, std::vector<uint32_t>> like;
  for (uint32_t i = 0; i < rules.size(); ++i) {
    if (!among[i] || spec.meshes[i].vertex_count == 0) continue;
    if (touches_itself(rules[i])) return {{i, i}};
    like[{rules[i].groups, rules[i].collide_mask, rules[i].is_static}].push_back(i);
  }
  for (auto one = like.begin(); one != like.end(); ++one)
    for (auto other = one; other != like.end(); ++other) {
      if (!may_touch(rules[one->second.front()], rules[other->second.front()])) continue;
      for (const uint32_t i : one->second)
        for (const uint32_t j : other->second)
          if (i != j && !excluded.has(pack_ids(std::min(i, j), std::max(i, j)))) return {{i, j}};
    }
  return std::nullopt;
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
