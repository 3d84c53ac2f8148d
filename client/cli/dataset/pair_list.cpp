// The steps of a data set in a list that somebody wrote.

#include <algorithm>
#include <map>
#include <stdexcept>

#include "client/cli/dataset/csv_text.hpp"
#include "client/cli/dataset/dataset.hpp"
#include "client/scenes/mesh_files/mesh_text.hpp"

namespace collided::cli {

namespace {

bool is_control(char c) { return static_cast<unsigned char>(c) < ' ' || c == 0x7f; }

FrameNames names_in(std::string_view line, size_t frames, const std::string& place) {
  const auto fail = [&](const std::string& what) { scenes::fail(place, what); };
  if (std::any_of(line.begin(), line.end(), is_control)) fail("has a control character; names are separated by commas");
  FrameNames names;
  try {
    names = csv_cells(line);
  } catch (const std::runtime_error& e) {
    fail(e.what());
  }
  if (names.size() != frames)
    fail("has " + std::to_string(names.size()) + " names; a step of this --mode has " + std::to_string(frames));
  if (std::count(names.begin(), names.end(), "") > 0) fail("has an empty name");
  return names;
}

}  // namespace

std::vector<FrameNames> listed_pairs(const std::string& text, const std::string& file, size_t frames) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  std::string_view rest = text;
  if (rest.starts_with(kByteOrderMark)) rest.remove_prefix(kByteOrderMark.size());
  std::vector<FrameNames> pairs;
  std::map<FrameNames, size_t> line_of;
  for (size_t number = 1; !rest.empty(); ++number) {
    const std::string_view line = scenes::next_line(rest);
    const bool is_header = pairs.empty() && (line == "frame0" || line.starts_with("frame0,"));
    if (line.empty() || line.starts_with("#") || is_header) continue;
    const std::string place = file + ":" + std::to_string(number);
    FrameNames names = names_in(line, frames, place);
    const auto [first, is_new] = line_of.emplace(names, number);
    if (!is_new) scenes::fail(place, "is line " + std::to_string(first->second) + " again");
    pairs.push_back(std::move(names));
  }
  return pairs;
}

}  // namespace collided::cli
