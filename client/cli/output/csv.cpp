// Contacts as CSV. A frame may have millions of rows: they are formatted in a buffer and written in large pieces.

#include "client/cli/output/csv.hpp"

#include <charconv>
#include <utility>

#include "client/cli/options/values.hpp"
#include "client/cli/output/output.hpp"
#include "client/cli/report/contacts.hpp"

namespace collided::cli {

namespace {

constexpr size_t kBufferBytes = 1 << 20, kMaxRowBytes = 256;

class Rows {
 public:
  explicit Rows(const std::string& file) : out_(file), buffer_(kBufferBytes, '\0') {}
  void text(std::string_view s) { at_ += s.copy(buffer_.data() + at_, s.size()); }
  template <class T>
  void number(T x) {
    at_ = static_cast<size_t>(std::to_chars(buffer_.data() + at_, buffer_.data() + buffer_.size(), x).ptr -
                              buffer_.data());
  }
  void end_row() {
    buffer_[at_++] = '\n';
    if (at_ + kMaxRowBytes > kBufferBytes) write();
  }
  void finish() {
    write();
    out_.finish();
  }

 private:
  void write() { out_.write(buffer_.data(), std::exchange(at_, 0)); }

  OutputFile out_;
  std::string buffer_;
  size_t at_ = 0;
};

/// The values of entry `i`, or only the commas if the field was not computed.
template <class T, size_t N>
void cells(Rows& rows, const std::vector<std::array<T, N>>& values, uint64_t i) {
  for (size_t k = 0; k < N; ++k) {
    rows.text(",");
    if (!values.empty()) rows.number(values[i][k]);
  }
}

template <class T>
void cell(Rows& rows, const std::vector<T>& values, uint64_t i) {
  rows.text(",");
  if (!values.empty()) rows.number(values[i]);
}

/// The words of every combination of flags, such as "certified|initial".
std::array<std::string, 16> all_flag_texts() {
  std::array<std::string, 16> texts;
  for (uint8_t flags = 0; flags < texts.size(); ++flags)
    for (const std::string_view word : flag_words(flags))
      texts[flags] += (texts[flags].empty() ? "" : "|") + std::string(word);
  return texts;
}

void flags_cell(Rows& rows, const std::vector<uint8_t>& flags, uint64_t i) {
  static const auto kTexts = all_flag_texts();
  rows.text(",");
  if (!flags.empty()) rows.text(kTexts[flags[i] % kTexts.size()]);
}

void write_kind(Rows& rows, std::string_view kind, const client::Contacts& contacts) {
  for (uint64_t i = 0; i < contacts.count; ++i) {
    rows.text(kind);
    cells(rows, contacts.elements, i);
    cells(rows, contacts.stencils, i);
    cell(rows, contacts.toi, i);
    cell(rows, contacts.distance, i);
    flags_cell(rows, contacts.flags, i);
    rows.end_row();
  }
}

}  // namespace

void write_csv(const std::string& file, const client::FrameOutput& output) {
  Rows rows(file);
  rows.text("kind,element_a,element_b,v0,v1,v2,v3,toi,distance,flags");
  rows.end_row();
  for_each_kind(
      [&](v1::ContactKind kind, const client::Contacts& contacts) { write_kind(rows, name_of(kind), contacts); },
      output);
  rows.finish();
}

}  // namespace collided::cli
