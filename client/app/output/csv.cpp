// Contacts as CSV. A frame may have millions of rows.

#include "client/app/output/csv.hpp"

#include <cstdlib>
#include <memory>
#include <new>

#include "client/app/options/values.hpp"
#include "client/app/output/text_columns.hpp"
#include "client/app/report/contacts.hpp"

namespace collided::cli {

namespace {

using client::Contacts;

/// A byte as words, such as "certified|initial".
template <auto kWordsOf>
struct WordsColumn {
  std::string_view names;
  std::vector<uint8_t> Contacts::*values;
};

constexpr auto kFlagWordsOf = [](v1::ContactKind, uint8_t flags) { return flag_words(flags); };

/// The points where the two features touch, which follow from the weights and the positions of the vertices.
struct PointsColumn {
  std::string_view names;
};

/// The columns after the kind, in their order.
constexpr std::tuple kColumns{TextColumn{"element_a,element_b", &Contacts::elements},
                              TextColumn{"v0,v1,v2,v3", &Contacts::stencils},
                              TextColumn{"toi", &Contacts::toi},
                              TextColumn{"distance", &Contacts::distance},
                              WordsColumn<kFlagWordsOf>{"flags", &Contacts::flags},
                              TextColumn{"w0,w1", &Contacts::weights},
                              PointsColumn{"point_a_x,point_a_y,point_a_z,point_b_x,point_b_y,point_b_z"},
                              TextColumn{"normal_x,normal_y,normal_z", &Contacts::normals},
                              WordsColumn<&feature_words>{"features", &Contacts::features},
                              TextColumn{"signed_distance", &Contacts::signed_distances}};
static_assert(count_columns(kColumns) == client::kColumnCount, "a column of contacts is not in the files");

/// A contact, and what its points are computed from.
struct Row {
  v1::ContactKind kind;
  const Contacts& contacts;
  uint64_t i;
  const StepPositions& positions;
};

/// The components of the entry, or only the commas if the column was not computed.
template <class Entry>
void write(NumberFile& rows, const Row& row, const TextColumn<Entry>& column) {
  const std::vector<Entry>& values = row.contacts.*column.values;
  for (const auto x : components(values.empty() ? Entry{} : values[row.i])) {
    rows.text(",");
    if (!values.empty()) rows.number(x);
  }
}

/// The words of every byte, for each kind.
using ByteTexts = std::array<std::array<std::string, 256>, v1::ContactKind_ARRAYSIZE>;

template <class WordsOf>
ByteTexts all_texts(const WordsOf& words_of) {
  ByteTexts texts;
  for (int kind = 0; kind < v1::ContactKind_ARRAYSIZE; ++kind)
    for (size_t byte = 0; byte < texts[kind].size(); ++byte)
      for (const std::string_view word : words_of(static_cast<v1::ContactKind>(kind), static_cast<uint8_t>(byte)))
        texts[kind][byte] += (texts[kind][byte].empty() ? "" : "|") + std::string(word);
  return texts;
}

template <auto kWordsOf>
void write(NumberFile& rows, const Row& row, const WordsColumn<kWordsOf>& column) {
  static const ByteTexts kTexts = all_texts(kWordsOf);
  const std::vector<uint8_t>& bytes = row.contacts.*column.values;
  rows.text(",");
  if (!bytes.empty()) rows.text(kTexts[row.kind][bytes[row.i]]);
}

void write(NumberFile& rows, const Row& row, const PointsColumn&) {
  const std::optional<ContactPoints> points = contact_points(row.kind, row.contacts, row.i, row.positions);
  if (!points) return (void)rows.text(",,,,,,");
  for (const auto& point : {points->first, points->second})
    for (const double x : point) rows.text(",").number(x);
}

/// `first`: the cells before the contact's own.
void write_kind(NumberFile& rows, const std::string& first, const client::Contacts& contacts, v1::ContactKind kind,
                const StepPositions& positions) {
  for (uint64_t i = 0; i < contacts.count; ++i) {
    rows.text(first);
    const Row row{kind, contacts, i, positions};
    for_each_text_column(kColumns, [&](const auto& column) { write(rows, row, column); });
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
  std::string header = "kind";
  for_each_text_column(kColumns, [&](const auto& column) { header += "," + std::string(column.names); });
  return header + "\n";
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
