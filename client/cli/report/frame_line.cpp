// One answered frame of many: a line for people, or an object.

#include "client/cli/report/frame_line.hpp"

#include "client/cli/report/numbers.hpp"

namespace collided::cli {

std::string frame_text(const v1::FrameDone& done, v1::Report report) {
  const v1::FrameCounts& counts = done.metrics().counts();
  const std::string time = ", " + format_double("%.3f", done.metrics().total_milliseconds()) + " ms";
  if (report == v1::REPORT_ANY_HIT) return (done.any_contact() ? "a contact" : "no contact") + time;
  return std::to_string(done.contact_count()) + " contacts (" + std::to_string(counts.contacts_vertex_triangle()) +
         " vt, " + std::to_string(counts.contacts_edge_edge()) + " ee, " +
         std::to_string(counts.contacts_triangle_triangle()) + " tt), earliest " +
         format_double("%.6g", done.earliest_toi()) + time;
}

Json frame_result_json(const v1::FrameDone& done, v1::Report report) {
  const bool is_counted = report != v1::REPORT_ANY_HIT;
  Json out = {{"contact_count", is_counted ? Json(done.contact_count()) : Json(nullptr)},
              {"any_contact", done.any_contact()},
              {"earliest_toi", done.earliest_toi()}};
  if (done.has_advanced()) out["advanced"] = done.advanced();
  out.update(frame_json(done, report));
  return out;
}

}  // namespace collided::cli
