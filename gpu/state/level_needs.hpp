#pragma once
// What a frame's level and report need: which lists, stages and filters there are at all.

#include "gpu/contacts/columns.hpp"
#include "gpu/contacts/layout.hpp"
#include "gpu/narrow/floors.hpp"
#include "gpu/state/settings.hpp"

namespace collided {

/// Holds what the floors of a step that advances depend on.
struct WayRules {
  FloorRules floors;
  double off = 0;    ///< how far vertices of rigid meshes may be off their straight ways, besides blend()'s rounding
  double noise = 0;  ///< the largest of any pair (floors.hpp), in the unit of the positions

  bool operator==(const WayRules&) const = default;
  /// Pairs within this distance may have to be shortened.
  COLLIDED_HD double reach() const { return 1.001 * floors.reach() + 2 * off + noise; }
};

struct LevelNeeds {
  FrameSettings settings{};
  PerKind<bool> kinds = {};
  FieldSet fields = {};            ///< that are asked for
  bool finds_rest_pairs = false;   ///< the step finds the pairs that all others leave out
  bool tells_contacts = true;      ///< the step finds contacts
  bool tells_features = false;     ///< on which features their closest points are, and which are covered
  bool tells_signed = false;       ///< their signed distances
  bool tells_states = false;       ///< how pairs of meshes lie to each other
  bool looks_into_solids = false;  ///< after the step: which vertices are in which solids
  bool advances = false;           ///< the step finds the pairs that ways are shortened for
  WayRules ways = {};              ///< of such a step
  bool has_room = false;           ///< there is memory of the backend for contacts
  ContactWidths widths = {};       ///< of what is put there

  bool operator==(const LevelNeeds&) const = default;

  bool is_ccd() const { return settings.is_ccd(); }
  bool is_exact() const { return settings.accuracy == Accuracy::kExact; }
  bool is_earliest_only() const { return settings.report == Report::kEarliestOnly; }
  bool is_any_hit() const { return settings.report == Report::kAnyHit; }
  /// Only the list of all contacts has those that come no closer.
  bool skips_separating() const { return settings.ignore_separating && settings.report != Report::kAll; }

  /// Candidates of features are looked at more closely.
  bool has_narrow_phase() const { return settings.accuracy != Accuracy::kCandidates; }
  /// Triangles of a frame are tested at every level; in CCD their boxes are all there is.
  bool tests_triangles() const { return kinds.triangle_triangle && !is_ccd(); }
  /// Edges that go through triangles are those of a DCD frame.
  bool tests_crossings() const { return kinds.edge_triangle && !is_ccd(); }
  /// Some contacts are left to exact arithmetic on the host, or get their signs there.
  bool settles() const { return is_exact() || tests_crossings() || looks_into_solids; }
  /// What is reported of a kind is a contact, not just a candidate.
  bool tests(ContactKind kind) const {
    if (is_of_features(kind)) return has_narrow_phase();
    if (kind == ContactKind::kVertexSolid) return looks_into_solids;
    return kind == ContactKind::kEdgeTriangle ? tests_crossings() : tests_triangles();
  }
  /// Contacts stay on the backend.
  bool keeps_contacts() const { return has_room && !is_any_hit(); }
  /// The step itself puts them where they are to stay, unless the host has to decide first which are contacts.
  bool places_contacts() const { return keeps_contacts() && !settles(); }
  /// At kExact: contacts of features are decided in the step, as far as that goes.
  bool decides_in_step() const { return is_exact() && settings.thickness == 0 && !settings.differs_by_pair(); }
  bool has_times() const { return columns().has(ContactField::kToi); }

  /// Contacts have more than their ids.
  bool has_data() const { return has_narrow_phase() || tests_triangles() || tests_crossings(); }

  /// What contacts of a kind have.
  FieldSet fields_of(ContactKind kind) const {
    FieldSet present = {ContactField::kElements};
    if (!tests(kind)) return present;
    present = present.with(ContactField::kFlags);
    if (kind == ContactKind::kTriangleTriangle) return present;
    if (kind == ContactKind::kEdgeTriangle) {
      const bool has_weights = fields.has(ContactField::kWeights) && !is_any_hit();
      return has_weights ? present.with(ContactField::kWeights) : present;
    }
    if (is_ccd()) present = present.with(ContactField::kToi);
    if (is_of_features(kind) && tells_features) present = present.with(ContactField::kFeatures);
    if (is_any_hit()) return present;  // no contact is returned
    if (is_of_features(kind) && tells_signed)
      present = present.with(ContactField::kDistance).with(ContactField::kSignedDistance);
    for (const ContactField field : {ContactField::kDistance, ContactField::kWeights, ContactField::kNormals})
      if (fields.has(field)) present = present.with(field);
    return present;
  }
  /// What any of them has.
  FieldSet columns() const {
    FieldSet all;
    for_each_kind([&](ContactKind kind, bool is_wanted) { all = is_wanted ? all | fields_of(kind) : all; }, kinds);
    return all;
  }

  /// Returns what boxes are grown by to find all pairs that matter to the step. Those of thick meshes grow by more.
  double reach() const { return max(settings.reach(), advances ? ways.reach() : 0.0); }
  /// A filter in float rules candidates out.
  bool has_filter() const { return settings.accuracy >= (is_ccd() ? Accuracy::kGuarded : Accuracy::kCertified); }
  /// It does so before they are stored.
  bool filters_searches() const { return has_filter() && !advances; }
  /// CCD tries a fixed direction before it follows the features, and float goes ahead of double.
  bool is_screened() const { return is_ccd() && settings.accuracy >= Accuracy::kGuarded; }
  bool is_approached() const { return is_screened() && settings.accuracy >= Accuracy::kCertified; }
  /// DCD looks again at pairs that are neither certain to be apart nor certain to be within the thickness.
  bool looks_twice() const { return !is_ccd() && settings.accuracy >= Accuracy::kCertified; }

  bool judges_resolution() const { return tells_contacts && settings.accuracy >= Accuracy::kGuarded; }
};

/// Returns the kinds of features that are wanted.
inline PerKind<bool> kinds_of_features(const SceneSpec& spec) {
  return {.vertex_triangle = spec.kinds.vertex_triangle, .edge_edge = spec.kinds.edge_edge};
}

inline LevelNeeds needs_of(const SceneSpec& spec, const FrameSettings& settings, const ContactRoom& room = {}) {
  LevelNeeds needs{settings, {}, spec.fields};
  needs.tells_features =
      collided::tells_features(spec) && !needs.is_ccd() && needs.has_narrow_phase() && settings.report == Report::kAll;
  needs.looks_into_solids =
      collided::looks_into_solids(spec) && !needs.is_ccd() && needs.has_narrow_phase() && !needs.is_earliest_only();
  needs.tells_signed = tells_signed_distances(spec) && needs.looks_into_solids && settings.report == Report::kAll;
  needs.tells_states = spec.pair_states && needs.looks_into_solids && settings.report == Report::kAll;
  needs.kinds = kinds_of_features(spec);
  needs.kinds.triangle_triangle = spec.kinds.triangle_triangle;
  needs.kinds.edge_triangle =
      !needs.is_ccd() && (spec.kinds.edge_triangle || needs.tells_features || needs.tells_signed || needs.tells_states);
  needs.has_room = !room.memory.empty();
  if (!needs.has_room) return needs;
  for_each_kind(
      [&](ContactKind kind, bool is_wanted, bool is_told) {
        if (is_wanted && is_told) needs.widths.set(kind, needs.fields_of(kind) & room.fields, room.stencils);
      },
      needs.kinds, spec.kinds);
  return needs;
}

/// Returns the needs of a step that finds the pairs whose vertices' ways may have to be shortened, and nothing else.
inline LevelNeeds needs_of_ways(const SceneSpec& spec, const WayRules& ways) {
  const FrameSettings settings{Mode::kCcd, Accuracy::kGuarded, 0, Report::kAll, 0, 0, false};
  LevelNeeds needs{settings, kinds_of_features(spec), {ContactField::kElements}};
  needs.tells_contacts = false;
  needs.advances = true;
  needs.ways = ways;
  return needs;
}

/// Of the step that finds the pairs of features that are within rest_distance, or, if that is 0, in contact. They are
/// where they are, whatever the scene's mode, and decided in exact arithmetic: a pair that is farther apart by any
/// amount is not among them.
inline LevelNeeds needs_of_rest_pairs(const SceneSpec& spec) {
  const bool is_contact = spec.rest_distance == 0;
  const double distance = is_contact ? spec.thickness : spec.rest_distance;
  const FrameSettings settings{
      Mode::kDcd, Accuracy::kExact, 0, Report::kAll, distance, distance, false, 0, is_contact ? thickest_of(spec) : 0};
  return {settings, kinds_of_features(spec), {ContactField::kElements}, true};
}

}  // namespace collided
