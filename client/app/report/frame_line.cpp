// One answered frame of many: a line for people, or an object.

#include "client/app/report/frame_line.hpp"

#include "client/app/output/contact_points.hpp"
#include "client/app/report/numbers.hpp"

namespace collided::cli {

namespace {

bool is_counted(const v1::SceneSpec& spec) { return spec.report() != v1::REPORT_ANY_HIT; }

bool has_candidates(const v1::FrameDone& done, const v1::SceneSpec& spec) {
  return done.contact_count() > 0 ? !done.any_contact() : spec.accuracy() == v1::ACCURACY_CANDIDATES;
}

bool has_shortened(const client::FrameOutput& output) { return output.advance.mode != v1::ADVANCE_MODE_ALL_OR_ONE; }

uint64_t count_limits(const client::FrameOutput& output) {
  uint64_t count = 0;
  client::for_each_kind([&](v1::ContactKind, const client::Contacts& limits) { count += limits.count; }, output.limits);
  return count;
}

}  // namespace

bool has_times(const v1::FrameDone& done, const v1::SceneSpec& spec) {
  return is_counted(spec) && spec.mode() != v1::DETECTION_MODE_DCD && !has_candidates(done, spec);
}

client::PerKind<uint64_t> found_counts(const v1::FrameDone& done, const v1::SceneSpec& spec) {
  const v1::FrameCounts& counts = done.metrics().counts();
  if (!has_candidates(done, spec))
    return {counts.contacts_vertex_triangle(), counts.contacts_edge_edge(), counts.contacts_triangle_triangle(),
            counts.contacts_edge_triangle(), counts.contacts_vertex_solid()};
  const uint64_t vertex_triangle = counts.candidates_vertex_triangle(), edge_edge = counts.candidates_edge_edge();
  // Those of triangles have no count of their own; crossings and vertices in solids have no candidates.
  return {vertex_triangle, edge_edge, done.contact_count() - vertex_triangle - edge_edge, 0, 0};
}

std::string frame_text(const v1::FrameDone& done, const v1::SceneSpec& spec) {
  std::string time = ", " + format_double("%.3f", done.metrics().total_milliseconds()) + " ms";
  for (const std::string& option : done.metrics().unused_options()) time += ", " + option + " had no effect";
  if (!is_counted(spec)) return (done.any_contact() ? "a contact" : "no contact") + time;
  const client::PerKind<uint64_t> found = found_counts(done, spec);
  return std::to_string(done.contact_count()) + (has_candidates(done, spec) ? " candidates (" : " contacts (") +
         std::to_string(found.vertex_triangle) + " vt, " + std::to_string(found.edge_edge) + " ee, " +
         std::to_string(found.triangle_triangle) + " tt" +
         (asks_for(spec, v1::CONTACT_KIND_EDGE_TRIANGLE) ? ", " + std::to_string(found.edge_triangle) + " et" : "") +
         (asks_for(spec, v1::CONTACT_KIND_VERTEX_SOLID) ? ", " + std::to_string(found.vertex_solid) + " vs)" : ")") +
         (has_times(done, spec) ? ", earliest " + format_double("%.6g", done.earliest_toi()) : "") + time;
}

Json found_json(const v1::FrameDone& done, const v1::SceneSpec& spec) {
  Json out = {{"contact_count", is_counted(spec) ? Json(done.contact_count()) : Json(nullptr)},
              {"any_contact", done.any_contact()}};
  if (has_times(done, spec)) out["earliest_toi"] = done.earliest_toi();
  if (done.has_advanced()) out["advanced"] = done.advanced();
  if (done.has_way()) out["way"] = done.way();
  return out;
}

std::string advance_text(const client::FrameOutput& output) {
  if (!output.done.has_way()) return "";
  const std::string way = ", went " + format_double("%.6g", output.done.way()) + " of its way";
  const bool is_meshes = output.advance.mode == v1::ADVANCE_MODE_PER_MESH;
  const std::string shortened = has_shortened(output) ? ", " + std::to_string(output.advance.ids.size()) +
                                                            (is_meshes ? " meshes" : " vertices") + " shortened"
                                                      : "";
  const uint64_t limits = count_limits(output);
  return way + shortened + (limits > 0 ? ", " + std::to_string(limits) + " contacts limit it" : "");
}

Json advance_json(const client::FrameOutput& output) {
  Json out = Json::object();
  if (has_shortened(output)) out["shortened_count"] = output.advance.ids.size();
  if (const uint64_t limits = count_limits(output); limits > 0) out["limit_count"] = limits;
  return out;
}

Json frame_result_json(const v1::FrameDone& done, const v1::SceneSpec& spec) {
  Json out = found_json(done, spec);
  out.update(frame_json(done, spec.report()));
  return out;
}

}  // namespace collided::cli
