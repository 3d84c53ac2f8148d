// A pair of frames in the table of all pairs.

#include "client/cli/batch/row.hpp"

#include <charconv>
#include <stdexcept>
#include <vector>

#include "client/app/report/digest.hpp"
#include "client/app/report/frame_line.hpp"
#include "client/cli/dataset/csv_text.hpp"

namespace collided::cli {

namespace {

constexpr const char* kRowBytes = "row_bytes";

template <class T>
std::string text_of(T number) {
  char digits[40];
  return {digits, std::to_chars(digits, digits + sizeof digits, number).ptr};
}

std::string line(const std::vector<std::string>& cells) {
  std::string out;
  for (const std::string& cell : cells) out += (out.empty() ? "" : ",") + cell;
  return out + "\n";
}

std::vector<std::string> first_cells(uint64_t pair, const FrameNames& names, const char* status) {
  return {text_of(pair), csv_cell(names.front()), names.size() > 1 ? csv_cell(names[1]) : "", status};
}

/// Empty cells for what these options do not find out.
std::vector<std::string> found_cells(const v1::SceneSpec& spec, const client::FrameOutput& output) {
  const v1::FrameDone& done = output.done;
  const client::PerKind<uint64_t> found = found_counts(done, spec);
  const bool is_counted = spec.report() != v1::REPORT_ANY_HIT;
  const auto count = [&](uint64_t n) { return is_counted ? text_of(n) : ""; };
  return {count(done.contact_count()),
          count(found.vertex_triangle),
          count(found.edge_edge),
          count(found.triangle_triangle),
          count(found.edge_triangle),
          done.any_contact() ? "yes" : "no",
          has_times(done, spec) ? text_of(done.earliest_toi()) : "",
          is_counted ? digest_of(output) : ""};
}

size_t row_bytes(const Record& record) {
  const uint64_t bytes = number_of(record.head, kRowBytes);
  if (bytes == 0 || bytes > record.text.size()) throw std::runtime_error("a record has no row");
  return bytes;
}

}  // namespace

const char* const kRowHeader =
    "pair,frame0,frame1,status,vertices,triangles,contacts,vertex_triangle,edge_edge,triangle_triangle,edge_triangle,"
    "any_contact,earliest_toi,contacts_digest,error\n";

std::string row_of(uint64_t pair, const FrameNames& names, const v1::Scene& scene, const client::FrameOutput& output) {
  std::vector<std::string> cells = first_cells(pair, names, "done");
  cells.push_back(text_of(scene.vertex_count()));
  cells.push_back(text_of(scene.triangle_count()));
  for (std::string& cell : found_cells(scene.spec(), output)) cells.push_back(std::move(cell));
  cells.emplace_back();  // no error
  return line(cells);
}

std::string failed_row(uint64_t pair, const FrameNames& names, const std::string& why) {
  constexpr size_t kCellsBefore = 14;  // the error's
  std::vector<std::string> cells = first_cells(pair, names, "failed");
  cells.resize(kCellsBefore);
  cells.push_back(csv_cell(why));
  return line(cells);
}

Record pair_record(std::string row, const std::string& contacts) {
  Record record{{{kRowBytes, row.size()}}, std::move(row)};
  record.text += contacts;
  return record;
}

std::string_view row_in(const Record& record) { return std::string_view(record.text).substr(0, row_bytes(record)); }

std::string_view contacts_in(const Record& record) { return std::string_view(record.text).substr(row_bytes(record)); }

}  // namespace collided::cli
