// Contacts as CSV. A frame may have millions of rows.

#include "client/app/output/csv.hpp"

#include <cstdlib>
#include <memory>
#include <new>

#include "client/app/options/values.hpp"
#include "client/app/report/contacts.hpp"

namespace collided::cli {

namespace {

template <class T>
void cell(NumberFile& rows, const std::vector<T>& values, uint64_t i) {
  rows.text(",");
  if (!values.empty()) rows.number(values[i]);
}

/// The values of entry `i`, or only the commas if the field was not computed.
template <class T, size_t N>
void cells(NumberFile& rows, const std::vector<std::array<T, N>>& values, uint64_t i) {
  for (size_t k = 0; k < N; ++k) {
    rows.text(",");
    if (!values.empty()) rows.number(values[i][k]);
  }
}

/// The words of every combination of flags, such as "certified|initial".
std::array<std::string, 32> all_flag_texts() {
  std::array<std::string, 32> texts;
  for (uint8_t flags = 0; flags < texts.size(); ++flags)
    for (const std::string_view word : flag_words(flags))
      texts[flags] += (texts[flags].empty() ? "" : "|") + std::string(word);
  return texts;
}

void flags_cell(NumberFile& rows, const std::vector<uint8_t>& flags, uint64_t i) {
  static const auto kTexts = all_flag_texts();
  rows.text(",");
  if (!flags.empty()) rows.text(kTexts[flags[i] % kTexts.size()]);
}

void point_cells(NumberFile& rows, const std::optional<ContactPoints>& points) {
  if (!points) return (void)rows.text(",,,,,,");
  for (const auto& point : {points->first, points->second})
    for (const double x : point) rows.text(",").number(x);
}

/// `first`: the cells before the contact's own.
void write_kind(NumberFile& rows, const std::string& first, const client::Contacts& contacts, v1::ContactKind kind,
                const StepPositions& positions) {
  for (uint64_t i = 0; i < contacts.count; ++i) {
    rows.text(first);
    cells(rows, contacts.elements, i);
    cells(rows, contacts.stencils, i);
    cell(rows, contacts.toi, i);
    cell(rows, contacts.distance, i);
    flags_cell(rows, contacts.flags, i);
    cells(rows, contacts.weights, i);
    point_cells(rows, contact_points(kind, contacts, i, positions));
    cells(rows, contacts.normals, i);
    rows.text("\n");
  }
}

void write_rows(NumberFile& rows, const std::string& first, const client::FrameOutput& output,
                const StepPositions& positions) {
  for_each_kind(
      [&](v1::ContactKind kind, const client::Contacts& contacts) {
        write_kind(rows, first + name_of(kind), contacts, kind, positions);
      },
      output);
}

}  // namespace

CsvFile::CsvFile(const std::string& file, Frames frames) : rows_(file), frames_(frames) {
  if (frames == Frames::kMany) rows_.text("frame,");
  rows_.text(csv_header());
}

void CsvFile::add(const client::FrameOutput& output, const StepPositions& positions) {
  write_rows(rows_, frames_ == Frames::kMany ? std::to_string(output.frame_id) + "," : "", output, positions);
}

std::string csv_header() {
  return "kind,element_a,element_b,v0,v1,v2,v3,toi,distance,flags,w0,w1,"
         "point_a_x,point_a_y,point_a_z,point_b_x,point_b_y,point_b_z,normal_x,normal_y,normal_z\n";
}

std::string csv_rows(const std::string& first, const client::FrameOutput& output, const StepPositions& positions) {
  char* text = nullptr;
  size_t bytes = 0;
  std::FILE* const memory = open_memstream(&text, &bytes);
  if (memory == nullptr) throw std::bad_alloc();
  const auto free_text = [](char** text) { std::free(*text); };
  const std::unique_ptr<char*, decltype(free_text)> guard(&text, free_text);
  NumberFile rows(memory);
  write_rows(rows, first, output, positions);
  rows.finish();
  return {text, bytes};
}

}  // namespace collided::cli
