// Contacts as points of a PLY file.

#include <algorithm>
#include <string_view>

#include "client/app/output/contour_lines.hpp"
#include "client/app/output/located.hpp"
#include "client/app/output/number_file.hpp"
#include "client/app/output/paraview.hpp"
#include "client/app/output/text_columns.hpp"

namespace collided::cli {

namespace {

using client::Contacts;

/// The number of the contact's kind.
struct KindColumn {};

/// The properties after the point, in their order.
constexpr std::tuple kColumns{TextColumn{"nx,ny,nz", &Contacts::normals},
                              TextColumn{"toi", &Contacts::toi},
                              TextColumn{"distance", &Contacts::distance},
                              KindColumn{},
                              TextColumn{"element_a,element_b", &Contacts::elements},
                              TextColumn{"v0,v1,v2,v3", &Contacts::stencils},
                              TextColumn{"w0,w1", &Contacts::weights},
                              TextColumn{"flags", &Contacts::flags},
                              TextColumn{"features", &Contacts::features},
                              TextColumn{"signed_distance", &Contacts::signed_distances}};
static_assert(count_columns(kColumns) == client::kColumnCount, "a column of contacts is not in the files");

/// PLY's name of a type.
template <class T>
constexpr std::string_view kType;
template <>
constexpr std::string_view kType<uint8_t> = "uchar";
template <>
constexpr std::string_view kType<uint32_t> = "uint";
template <>
constexpr std::string_view kType<float> = "float";
template <>
constexpr std::string_view kType<double> = "double";

void declare(NumberFile& out, std::string_view type, std::string_view name) {
  out.text("property ").text(type).text(" ").text(name).text("\n");
}

template <class Entry>
void declare(NumberFile& out, const TextColumn<Entry>& column) {
  using Component = typename std::remove_cvref_t<decltype(components(Entry{}))>::value_type;
  for (size_t at = 0; at < column.names.size();) {
    const size_t end = std::min(column.names.find(',', at), column.names.size());
    declare(out, kType<Component>, column.names.substr(at, end - at));
    at = end + 1;
  }
}
void declare(NumberFile& out, const KindColumn&) { declare(out, "uchar", "kind"); }

void declare_all(NumberFile& out) {
  for (const std::string_view axis : {"x", "y", "z"}) declare(out, "double", axis);
  for_each_text_column(kColumns, [&](const auto& column) { declare(out, column); });
}

template <class Entry>
void write(NumberFile& out, const LocatedContact& contact, const TextColumn<Entry>& column) {
  const std::vector<Entry>& values = contact.contacts.*column.values;
  for (const auto x : components(values.empty() ? Entry{} : values[contact.i])) out.text(" ").number(x);
}
void write(NumberFile& out, const LocatedContact& contact, const KindColumn&) {
  out.text(" ").number(static_cast<int>(contact.kind));
}

void write_point(NumberFile& out, const scenes::Vec3d& point) {
  out.number(point[0]).text(" ").number(point[1]).text(" ").number(point[2]);
}

void write_row(NumberFile& out, const LocatedContact& contact) {
  write_point(out, contact.points.first);
  for_each_text_column(kColumns, [&](const auto& column) { write(out, contact, column); });
  out.text("\n");
}

/// A point that is no contact: all other properties are 0.
void write_corner(NumberFile& out, const scenes::Vec3d& corner) {
  write_point(out, corner);
  const auto add_zeros = [&](const auto& column) {
    if constexpr (requires { column.names; })
      for (size_t i = 0; i <= static_cast<size_t>(std::ranges::count(column.names, ',')); ++i) out.text(" 0");
    else
      out.text(" 0");
  };
  for_each_text_column(kColumns, add_zeros);
  out.text("\n");
}

void write_edges(NumberFile& out, const ContourLines& lines) {
  for (const std::vector<size_t>& line : lines.points)
    for (size_t i = 1; i < line.size(); ++i) out.number(line[i - 1]).text(" ").number(line[i]).text("\n");
}

}  // namespace

void write_ply(const std::string& file, const client::FrameOutput& output, const StepPositions& positions) {
  const ContourLines lines(output, positions);
  NumberFile out(file);
  out.text("ply\nformat ascii 1.0\ncomment contacts found by collided\nelement vertex ");
  out.number(lines.contact_count + lines.corners.size()).text("\n");
  declare_all(out);
  if (positions.scene != nullptr) {
    out.text("element edge ").number(lines.segment_count()).text("\n");
    for (const std::string_view end : {"vertex1", "vertex2"}) declare(out, "int", end);
  }
  out.text("end_header\n");
  for_each_located(output, positions, [&](const LocatedContact& contact) { write_row(out, contact); });
  for (const scenes::Vec3d& corner : lines.corners) write_corner(out, corner);
  write_edges(out, lines);
  out.finish();
}

}  // namespace collided::cli
