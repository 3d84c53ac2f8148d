// Lists of pairs of mesh files, which people and other programs write as CSV.

#include <stdexcept>

#include "client/cli/dataset/csv_text.hpp"
#include "client/cli/dataset/dataset.hpp"
#include "tests/fuzz/targets/fuzz.hpp"

namespace collided::fuzz {
namespace {

std::string as_list(const std::vector<cli::FrameNames>& pairs) {
  std::string text = "# as read\n";
  for (const cli::FrameNames& names : pairs)
    for (size_t i = 0; i < names.size(); ++i) text += cli::csv_cell(names[i]) + (i + 1 < names.size() ? "," : "\n");
  return text;
}

// A name that begins like a comment or a header is none once it is in front of a line.
bool begins_like_another_line(const std::vector<cli::FrameNames>& pairs) {
  for (const cli::FrameNames& names : pairs)
    if (names[0].starts_with('#') || names[0] == "frame0") return true;
  return false;
}

void read(const std::string& text, size_t frames) {
  std::vector<cli::FrameNames> pairs;
  try {
    pairs = cli::listed_pairs(text, "input", frames);
  } catch (const std::runtime_error& e) {
    require(std::string(e.what()).starts_with("input:"), "a refusal names file and line");
    return;
  }
  for (const cli::FrameNames& names : pairs) require(names.size() == frames, "each step has its frames");
  if (!begins_like_another_line(pairs))
    require(cli::listed_pairs(as_list(pairs), "written", frames) == pairs, "a written list is the same list");
}

}  // namespace

void run(Input input) {
  const std::string text = input.rest();
  for (const size_t frames : {1, 2}) read(text, frames);
}

}  // namespace collided::fuzz
