// Contacts as CSV. A frame may have millions of rows: they are formatted into one buffer and written in large pieces.

#include "client/cli/csv.hpp"

#include <charconv>
#include <fstream>
#include <stdexcept>

namespace collided::cli {

namespace {

constexpr size_t kBufferBytes = 1 << 20, kMaxRowBytes = 256;

class Rows {
 public:
  explicit Rows(const std::filesystem::path& file) : name_(file.string()), out_(file, std::ios::binary) {
    if (!out_) throw std::runtime_error(name_ + ": cannot be written");
    buffer_.resize(kBufferBytes);
  }
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
    if (!out_.flush()) throw std::runtime_error(name_ + ": cannot be written");
  }

 private:
  void write() {
    out_.write(buffer_.data(), static_cast<std::streamsize>(at_));
    at_ = 0;
    if (!out_) throw std::runtime_error(name_ + ": cannot be written");
  }

  std::string name_;
  std::ofstream out_;
  std::string buffer_;
  size_t at_ = 0;
};

/// A value of each entry, or nothing but the commas where the field was not computed.
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

constexpr std::pair<v1::ContactFlag, std::string_view> kFlagWords[] = {{v1::CONTACT_FLAG_CERTIFIED, "certified"},
                                                                       {v1::CONTACT_FLAG_NEAR, "near"},
                                                                       {v1::CONTACT_FLAG_CAPPED, "capped"},
                                                                       {v1::CONTACT_FLAG_INITIAL, "initial"}};

/// The words of the flags that are set.
void flags_cell(Rows& rows, const std::vector<uint8_t>& flags, uint64_t i) {
  rows.text(",");
  if (flags.empty()) return;
  bool is_first = true;
  for (const auto& [mask, word] : kFlagWords) {
    if ((flags[i] & mask) == 0) continue;
    if (!is_first) rows.text("|");
    rows.text(word);
    is_first = false;
  }
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

void write_csv(const std::filesystem::path& file, const client::FrameOutput& output) {
  Rows rows(file);
  rows.text("kind,element_a,element_b,v0,v1,v2,v3,toi,distance,flags");
  rows.end_row();
  write_kind(rows, "vt", output.vertex_triangle);
  write_kind(rows, "ee", output.edge_edge);
  write_kind(rows, "tt", output.triangle_triangle);
  rows.finish();
}

}  // namespace collided::cli
