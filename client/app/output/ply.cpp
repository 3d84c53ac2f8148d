// Contacts as points of a PLY file.

#include <string_view>

#include "client/app/output/located.hpp"
#include "client/app/output/number_file.hpp"
#include "client/app/output/paraview.hpp"

namespace collided::cli {

namespace {

constexpr std::string_view kProperties =
    "property double x\nproperty double y\nproperty double z\n"
    "property float nx\nproperty float ny\nproperty float nz\n"
    "property double toi\nproperty double distance\n"
    "property uchar kind\nproperty uint element_a\nproperty uint element_b\n"
    "property uint v0\nproperty uint v1\nproperty uint v2\nproperty uint v3\n"
    "property double w0\nproperty double w1\nproperty uchar flags\n";

template <class T>
T value(const std::vector<T>& values, size_t i) {
  return values.empty() ? T{} : values[i];
}

template <class Values>
void numbers(NumberFile& out, const Values& values) {
  for (const auto x : values) out.text(" ").number(x);
}

void write_row(NumberFile& out, const LocatedContact& contact) {
  const client::Contacts& c = contact.contacts;
  const size_t i = contact.i;
  out.number(contact.points.first[0]).text(" ").number(contact.points.first[1]).text(" ");
  out.number(contact.points.first[2]);
  numbers(out, value(c.normals, i));
  numbers(out, std::array{value(c.toi, i), value(c.distance, i)});
  out.text(" ").number(static_cast<int>(contact.kind));
  numbers(out, value(c.elements, i));
  numbers(out, value(c.stencils, i));
  numbers(out, value(c.weights, i));
  out.text(" ").number(static_cast<int>(value(c.flags, i))).text("\n");
}

}  // namespace

void write_ply(const std::string& file, const client::FrameOutput& output, const StepPositions& positions) {
  size_t count = 0;
  for_each_located(output, positions, [&](const LocatedContact&) { ++count; });
  NumberFile out(file);
  out.text("ply\nformat ascii 1.0\ncomment contacts found by collided\nelement vertex ").number(count).text("\n");
  out.text(kProperties).text("end_header\n");
  for_each_located(output, positions, [&](const LocatedContact& contact) { write_row(out, contact); });
  out.finish();
}

}  // namespace collided::cli
