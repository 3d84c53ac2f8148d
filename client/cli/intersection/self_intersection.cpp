// Judges whether a mesh is free of self-intersection.

#include "client/cli/intersection/self_intersection.hpp"

#include <algorithm>

#include "client/cli/intersection/uncovered.hpp"

namespace collided::cli {

namespace {

constexpr v1::ContactKind kTellingKinds[] = {v1::CONTACT_KIND_EDGE_TRIANGLE, v1::CONTACT_KIND_VERTEX_TRIANGLE,
                                             v1::CONTACT_KIND_EDGE_EDGE};

const client::Contacts& contacts_of(v1::ContactKind wanted, const client::FrameOutput& output) {
  const client::Contacts* found = nullptr;
  client::for_each_kind(
      [&](v1::ContactKind kind, const client::Contacts& contacts) { found = kind == wanted ? &contacts : found; },
      output);
  return *found;
}

std::string uncovered_text(const SelfIntersection& self) {
  std::string text;
  for (const std::string& part : self.uncovered) text += (text.empty() ? "" : "; ") + part;
  return text;
}

/// "free", "intersects" or, of a mesh without contacts, "uncovered".
std::string verdict_of(const SelfIntersection& self) {
  if (!self.counts.is_empty()) return "intersects";
  return self.uncovered.empty() ? "free" : "uncovered";
}

}  // namespace

bool tells_self_intersection(const v1::SceneSpec& spec, const client::MeshInput& mesh) {
  return spec.mode() == v1::DETECTION_MODE_DCD && spec.accuracy() == v1::ACCURACY_EXACT && spec.thickness() == 0 &&
         mesh.half_thickness == 0 && spec.report() == v1::REPORT_ALL && mesh.exclude_rings == 0 &&
         std::ranges::all_of(kTellingKinds,
                             [&](v1::ContactKind kind) { return std::ranges::count(spec.kinds(), int{kind}) > 0; });
}

DetectionOptions self_detection() {
  DetectionOptions options;
  options.mode = "dcd", options.accuracy = "exact";
  options.kinds.clear();
  for (const v1::ContactKind kind : kTellingKinds) options.kinds.push_back(name_of(kind));
  return options;
}

SelfIntersection judge_self(const client::MeshInput& mesh, client::Positions positions,
                            const client::FrameOutput& output) {
  SelfIntersection self;
  self.mesh = mesh.name;
  self.uncovered = uncovered_parts(mesh, positions);
  const client::SceneFeatures scene(std::span(&mesh, 1));
  const MeetingPlace place{std::span(&mesh, 1), scene, positions};
  for (const v1::ContactKind kind : kTellingKinds) {
    const client::Contacts& contacts = contacts_of(kind, output);
    for (size_t i = 0; i < contacts.count; ++i) {
      if (self.counts.is_empty()) self.first = meeting_text(kind, contacts, i, place);
      self.counts.add(kind, contacts, i);
      if (self.listed.size() < kMaxListed) self.listed.push_back(meeting_json(kind, contacts, i, place));
    }
  }
  return self;
}

std::string self_text(const SelfIntersection& self) {
  const std::string uncovered = uncovered_text(self);
  if (!self.counts.is_empty())
    return self.mesh + ": " + meetings_text(self.counts) + "; the first: " + self.first +
           (uncovered.empty() ? "" : "; not covered: " + uncovered);
  return self.mesh + (uncovered.empty() ? ": no self-intersection"
                                        : ": no self-intersection found, but not all is covered: " + uncovered);
}

Json self_json(const SelfIntersection& self) {
  Json out = {{"name", self.mesh}, {"verdict", verdict_of(self)}};
  out.update(meeting_counts_json(self.counts));
  out["crossings"] = self.listed;
  if (!self.uncovered.empty()) out["uncovered"] = self.uncovered;
  return out;
}

}  // namespace collided::cli
