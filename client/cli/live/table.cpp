// The last frames of a scene as a table for a terminal.

#include "client/cli/live/table.hpp"

#include <algorithm>
#include <array>

#include "client/app/options/values.hpp"
#include "client/app/report/numbers.hpp"
#include "client/app/report/text.hpp"

namespace collided::cli {

namespace {

constexpr size_t kValueWidth = 11, kValues = 4, kMaxName = 32, kMinCurve = 8;

std::string value_text(const Series& series, double value) {
  switch (series.unit) {
    case Series::Unit::kMilliseconds:
      return milliseconds_text(value) + " ms";
    case Series::Unit::kBytes:
      return bytes_text(value);
    case Series::Unit::kCount:
      break;
  }
  return count_text(static_cast<uint64_t>(value));
}

std::string padded(std::string text, size_t width) {
  text.resize(std::max(width, text.size()), ' ');
  return text;
}

std::string right(const std::string& text, size_t width) {
  return (text.size() < width ? std::string(width - text.size(), ' ') : " ") + text;
}

/// Its last value, least, median and greatest.
std::array<double, kValues> values_of(const Series& series) {
  std::vector<double> sorted(series.values.begin(), series.values.end());
  std::sort(sorted.begin(), sorted.end());
  return {series.values.back(), sorted.front(), sorted[sorted.size() / 2], sorted.back()};
}

std::string row_of(const Series& series, size_t name_width, TableSize size) {
  std::string line = padded(series.name, name_width);
  for (const double value : values_of(series)) line += right(value_text(series, value), kValueWidth);
  if (line.size() + 2 + kMinCurve > size.columns) return line.substr(0, size.columns);
  return line + "  " + curve(series.values, size.columns - line.size() - 2, size.has_unicode);
}

std::string contact_text(const History& history) {
  if (!history.any_contact()) return "no contact";
  const std::optional<double> earliest = history.earliest_toi();
  return earliest ? "earliest " + format_double("%.6g", *earliest) : "a contact";
}

std::string frame_line(const History& history) {
  return "frame " + count_text(history.last_frame_id()) + "   " + format_double("%.1f", history.rate()) +
         " frames/s   " + count_text(history.skipped()) + " skipped   " + contact_text(history);
}

std::string header(size_t name_width, const History& history) {
  std::string line = padded("", name_width);
  for (const char* name : {"last", "min", "median", "max"}) line += right(name, kValueWidth);
  return line + "  last " + std::to_string(std::min<uint64_t>(history.frames(), History::kFrames)) + " frames";
}

}  // namespace

std::string curve(const std::deque<double>& values, size_t width, bool has_unicode) {
  static constexpr std::array<const char*, 8> kBlocks{"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  static constexpr std::array<const char*, 8> kAscii{"_", ".", "-", ":", "=", "+", "*", "#"};
  const auto first = values.size() > width ? values.end() - static_cast<ptrdiff_t>(width) : values.begin();
  const double greatest = first == values.end() ? 0 : *std::max_element(first, values.end());
  std::string out;
  for (auto at = first; at != values.end(); ++at) {
    const double part = greatest > 0 ? std::clamp(*at / greatest, 0.0, 1.0) : 0;
    out += (has_unicode ? kBlocks
                        : kAscii)[std::min<size_t>(static_cast<size_t>(part * kBlocks.size()), kBlocks.size() - 1)];
  }
  return out;
}

std::vector<std::string> table_title(const v1::Scene& scene) {
  const v1::SceneSpec& spec = scene.spec();
  const std::string name = spec.display_name().empty() ? "" : shown_name(spec.display_name()) + ", ";
  return {name + "scene " + scene.scene_id(),
          count_text(static_cast<uint64_t>(spec.meshes_size())) + " meshes, " + count_text(scene.vertex_count()) +
              " vertices, " + count_text(scene.triangle_count()) + " triangles; " + name_of(spec.accuracy()) + ", " +
              name_of(spec.backend()) + (scene.device().empty() ? "" : ", " + scene.device())};
}

std::vector<std::string> table_lines(const std::vector<std::string>& title, const History& history, TableSize size) {
  std::vector<std::string> lines = title;
  if (history.frames() == 0) {
    lines.push_back("no frame yet");
  } else {
    size_t name_width = 0;
    for (const Series& series : history.series()) name_width = std::max(name_width, series.name.size());
    name_width = std::min(name_width, kMaxName);
    lines.insert(lines.end(), {frame_line(history), "", header(name_width, history)});
    for (const Series& series : history.series()) lines.push_back(row_of(series, name_width, size));
  }
  for (size_t i = 0; i < std::min(title.size() + 3, lines.size()); ++i)
    lines[i].resize(std::min(lines[i].size(), size.columns));
  if (lines.size() > size.rows && size.rows > 0) {
    const size_t left_out = lines.size() - size.rows + 1;
    lines.resize(size.rows - 1);
    lines.push_back(("and " + std::to_string(left_out) + " more; a larger window shows them").substr(0, size.columns));
  }
  return lines;
}

}  // namespace collided::cli
