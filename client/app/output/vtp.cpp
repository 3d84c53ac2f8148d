// Contacts as VTK's PolyData in XML.

#include <string_view>

#include "client/app/output/contour_lines.hpp"
#include "client/app/output/located.hpp"
#include "client/app/output/number_file.hpp"
#include "client/app/output/paraview.hpp"
#include "client/app/report/json.hpp"

namespace collided::cli {

namespace {

/// VTK's name of a type.
template <class T>
constexpr std::string_view kType;
template <>
constexpr std::string_view kType<uint8_t> = "UInt8";
template <>
constexpr std::string_view kType<uint32_t> = "UInt32";
template <>
constexpr std::string_view kType<float> = "Float32";
template <>
constexpr std::string_view kType<double> = "Float64";

/// Writes arrays, each with its name and type.
class Arrays {
 public:
  Arrays(NumberFile& out, const client::FrameOutput& output, const StepPositions& positions, const ContourLines& lines)
      : out_(out), output_(output), positions_(positions), lines_(lines) {}

  /// Writes one array. `rows`, called with a function that takes a row's components, goes through all rows.
  template <size_t kComponents, class Rows>
  void write_rows(std::string_view type, std::string_view name, const Rows& rows) const {
    out_.text("<DataArray type=\"").text(type).text("\" Name=\"").text(name).text("\" NumberOfComponents=\"");
    out_.number(kComponents).text("\" format=\"ascii\">\n");
    rows([&](const auto& row) {
      std::string_view separator = "";
      for (const auto x : row) {
        out_.text(separator).number(x);
        separator = " ";
      }
      out_.text("\n");
    });
    out_.text("</DataArray>\n");
  }

  /// Writes one array of all points: `value_of` a contact gives an array of its components, `of_corner` that of a
  /// corner of contours by its index.
  template <class ValueOf, class OfCorner>
  void write(std::string_view type, std::string_view name, const ValueOf& value_of, const OfCorner& of_corner) const {
    using Value = decltype(value_of(std::declval<LocatedContact>()));
    write_rows<std::tuple_size_v<Value>>(type, name, [&](const auto& write_row) {
      for_each_located(output_, positions_, [&](const LocatedContact& contact) { write_row(value_of(contact)); });
      for (size_t i = 0; i < lines_.corners.size(); ++i) write_row(of_corner(i));
    });
  }
  /// The same with zeros for corners.
  template <class ValueOf>
  void write(std::string_view type, std::string_view name, const ValueOf& value_of) const {
    using Value = decltype(value_of(std::declval<LocatedContact>()));
    write(type, name, value_of, [](size_t) { return Value{}; });
  }

  /// The same of a column of Contacts, unless no contact has it.
  template <class T, size_t N>
  void write(std::string_view name, std::vector<std::array<T, N>> client::Contacts::*column) const {
    if (is_there(column))
      write(kType<T>, name, [&](const LocatedContact& contact) { return value_or_zero(contact, column); });
  }
  template <class T>
  void write(std::string_view name, std::vector<T> client::Contacts::*column) const {
    if (is_there(column))
      write(kType<T>, name, [&](const LocatedContact& contact) { return std::array{value_or_zero(contact, column)}; });
  }

 private:
  template <class T>
  static T value_or_zero(const LocatedContact& contact, std::vector<T> client::Contacts::*column) {
    const std::vector<T>& values = contact.contacts.*column;
    return values.empty() ? T{} : values[contact.i];
  }

  template <class Field>
  bool is_there(Field field) const {
    return !(output_.vertex_triangle.*field).empty() || !(output_.edge_edge.*field).empty() ||
           !(output_.edge_triangle.*field).empty() || !(output_.vertex_solid.*field).empty();
  }

  NumberFile& out_;
  const client::FrameOutput& output_;
  const StepPositions& positions_;
  const ContourLines& lines_;
};

void write_data(const Arrays& arrays) {
  arrays.write("UInt8", "kind", [](const LocatedContact& c) { return std::array{static_cast<int>(c.kind)}; });
  client::for_each_column([&](v1::ContactField field, auto column) {
    if (field != v1::CONTACT_FIELD_FLAGS) arrays.write(long_name_of(field), column);
  });
  arrays.write("Float64", "other_point", [](const LocatedContact& c) { return c.points.second; });
  arrays.write("UInt8", "flags", [](const LocatedContact& c) {
    return std::array{c.contacts.flags.empty() ? 0 : static_cast<int>(c.contacts.flags[c.i])};
  });
}

/// Data of cells: vertices, then contours.
void write_cell_data(const Arrays& arrays, const ContourLines& lines) {
  const auto write = [&](std::string_view type, std::string_view name, const auto& of_vertex, const auto& of_contour) {
    arrays.write_rows<std::tuple_size_v<std::remove_cvref_t<decltype(of_vertex)>>>(type, name, [&](const auto& row) {
      for (size_t i = 0; i < lines.contact_count; ++i) row(of_vertex);
      for (size_t i = 0; i < lines.contours.size(); ++i) row(of_contour(i));
    });
  };
  write("Int32", "contour", std::array{-1}, [](size_t i) { return std::array{i}; });
  write("UInt8", "closed", std::array{0}, [&](size_t i) { return std::array{lines.contours[i].is_closed ? 1 : 0}; });
  write("Int32", "meshes", std::array{-1, -1}, [&](size_t i) { return lines.contours[i].meshes; });
}

void write_lines(const Arrays& arrays, const ContourLines& lines) {
  arrays.write_rows<1>("Int64", "connectivity", [&](const auto& row) {
    for (const std::vector<size_t>& line : lines.points) row(line);
  });
  arrays.write_rows<1>("Int64", "offsets", [&](const auto& row) {
    size_t end = 0;
    for (const std::vector<size_t>& line : lines.points) row(std::array{end += line.size()});
  });
}

}  // namespace

void write_vtp(const std::string& file, const client::FrameOutput& output, const StepPositions& positions) {
  const ContourLines lines(output, positions);
  NumberFile out(file);
  const Arrays arrays(out, output, positions, lines);
  out.text(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\">\n<PolyData>\n");
  out.text("<Piece NumberOfPoints=\"").number(lines.contact_count + lines.corners.size());
  out.text("\" NumberOfVerts=\"").number(lines.contact_count).text("\" NumberOfLines=\"").number(lines.contours.size());
  out.text("\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n<PointData>\n");
  write_data(arrays);
  out.text("</PointData>\n");
  if (positions.scene != nullptr) {
    out.text("<CellData>\n");
    write_cell_data(arrays, lines);
    out.text("</CellData>\n");
  }
  out.text("<Points>\n");
  arrays.write(
      "Float64", "points", [](const LocatedContact& c) { return c.points.first; },
      [&](size_t i) { return lines.corners[i]; });
  out.text("</Points>\n<Verts>\n");
  const auto write_numbers = [&](std::string_view name, size_t first) {
    arrays.write_rows<1>("Int64", name, [&](const auto& row) {
      for (size_t i = 0; i < lines.contact_count; ++i) row(std::array{first + i});
    });
  };
  write_numbers("connectivity", 0);
  write_numbers("offsets", 1);
  out.text("</Verts>\n");
  if (positions.scene != nullptr) {
    out.text("<Lines>\n");
    write_lines(arrays, lines);
    out.text("</Lines>\n");
  }
  out.text("</Piece>\n</PolyData>\n</VTKFile>\n");
  out.finish();
}

}  // namespace collided::cli
