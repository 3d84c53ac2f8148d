// Contacts as VTK's PolyData in XML.

#include <string_view>

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

class Arrays {
 public:
  Arrays(NumberFile& out, const client::FrameOutput& output, const StepPositions& positions)
      : out_(out), output_(output), positions_(positions) {}

  /// One array: `value_of` a contact gives an array of its components.
  template <class ValueOf>
  void write(std::string_view type, std::string_view name, const ValueOf& value_of) const {
    using Value = decltype(value_of(std::declval<LocatedContact>()));
    out_.text("<DataArray type=\"").text(type).text("\" Name=\"").text(name).text("\" NumberOfComponents=\"");
    out_.number(std::tuple_size_v<Value>).text("\" format=\"ascii\">\n");
    for_each_located(output_, positions_, [&](const LocatedContact& contact) {
      std::string_view separator = "";
      for (const auto x : value_of(contact)) {
        out_.text(separator).number(x);
        separator = " ";
      }
      out_.text("\n");
    });
    out_.text("</DataArray>\n");
  }

  /// The same of a column of Contacts, unless no contact has it.
  template <class T, size_t N>
  void write(std::string_view name, std::vector<std::array<T, N>> client::Contacts::*column) const {
    if (is_there(column))
      write(kType<T>, name, [&](const LocatedContact& contact) { return (contact.contacts.*column)[contact.i]; });
  }
  template <class T>
  void write(std::string_view name, std::vector<T> client::Contacts::*column) const {
    if (is_there(column))
      write(kType<T>, name,
            [&](const LocatedContact& contact) { return std::array{(contact.contacts.*column)[contact.i]}; });
  }

 private:
  /// What one kind has, all kinds with points have.
  template <class Field>
  bool is_there(Field field) const {
    return !(output_.vertex_triangle.*field).empty() || !(output_.edge_edge.*field).empty();
  }

  NumberFile& out_;
  const client::FrameOutput& output_;
  const StepPositions& positions_;
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

}  // namespace

void write_vtp(const std::string& file, const client::FrameOutput& output, const StepPositions& positions) {
  size_t count = 0;
  for_each_located(output, positions, [&](const LocatedContact&) { ++count; });
  NumberFile out(file);
  const Arrays arrays(out, output, positions);
  out.text(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\">\n<PolyData>\n");
  out.text("<Piece NumberOfPoints=\"").number(count).text("\" NumberOfVerts=\"").number(count);
  out.text("\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n<PointData>\n");
  write_data(arrays);
  out.text("</PointData>\n<Points>\n");
  arrays.write("Float64", "points", [](const LocatedContact& c) { return c.points.first; });
  out.text("</Points>\n<Verts>\n");
  size_t at = 0, end = 0;
  arrays.write("Int64", "connectivity", [&](const LocatedContact&) { return std::array{at++}; });
  arrays.write("Int64", "offsets", [&](const LocatedContact&) { return std::array{++end}; });
  out.text("</Verts>\n</Piece>\n</PolyData>\n</VTKFile>\n");
  out.finish();
}

}  // namespace collided::cli
