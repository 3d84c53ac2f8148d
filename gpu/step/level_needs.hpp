#pragma once
// What a frame's level and report need: which lists, stages and filters there are at all.

#include "gpu/contacts/columns.hpp"
#include "gpu/step/settings.hpp"

namespace collided {

struct LevelNeeds {
  FrameSettings settings{};
  bool is_ccd = true;
  bool finds_features = true, triangle_triangle = false;
  FieldSet fields = {};  ///< that are asked for

  bool operator==(const LevelNeeds&) const = default;

  bool is_exact() const { return settings.accuracy == Accuracy::kExact; }
  bool is_earliest_only() const { return settings.report == Report::kEarliestOnly; }
  bool is_any_hit() const { return settings.report == Report::kAnyHit; }

  /// Candidates of features are looked at more closely.
  bool has_narrow_phase() const { return settings.accuracy != Accuracy::kCandidates; }
  /// Triangles of a frame are tested at every level; in CCD their boxes are all there is.
  bool tests_triangles() const { return triangle_triangle && !is_ccd; }
  /// What is reported of a kind is a contact, not just a candidate.
  bool tests(ContactKind kind) const {
    return kind == ContactKind::kTriangleTriangle ? tests_triangles() : has_narrow_phase();
  }
  /// Contacts have more than their ids.
  bool has_data() const { return has_narrow_phase() || tests_triangles(); }

  /// What contacts of a kind have.
  FieldSet fields_of(ContactKind kind) const {
    FieldSet present = {ContactField::kElements};
    if (!tests(kind)) return present;
    present = present.with(ContactField::kFlags);
    if (kind == ContactKind::kTriangleTriangle) return present;
    if (is_ccd) present = present.with(ContactField::kToi);
    if (is_any_hit()) return present;  // no contact is returned
    for (const ContactField field : {ContactField::kDistance, ContactField::kWeights, ContactField::kNormals})
      if (fields.has(field)) present = present.with(field);
    return present;
  }
  /// What any of them has.
  FieldSet columns() const {
    return (finds_features ? fields_of(ContactKind::kVertexTriangle) : FieldSet{}) |
           (triangle_triangle ? fields_of(ContactKind::kTriangleTriangle) : FieldSet{});
  }

  /// A filter in float rules candidates out before they are stored.
  bool has_filter() const { return settings.accuracy >= (is_ccd ? Accuracy::kGuarded : Accuracy::kCertified); }
  /// CCD tries a fixed direction before it follows the features, and float goes ahead of double.
  bool is_screened() const { return is_ccd && settings.accuracy >= Accuracy::kGuarded; }
  bool is_approached() const { return is_screened() && settings.accuracy >= Accuracy::kCertified; }

  bool judges_resolution() const { return settings.accuracy >= Accuracy::kGuarded; }
};

inline LevelNeeds needs_of(const SceneSpec& spec, const FrameSettings& settings) {
  return {settings, spec.mode == Mode::kCcd, spec.vertex_triangle || spec.edge_edge, spec.triangle_triangle,
          spec.fields};
}

}  // namespace collided
