// The steps of a data set that are in the names of its files, as cloth-ball/frames/cloth_ball92.ply and
// cloth_ball93.ply.

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <utility>

#include "client/cli/dataset/dataset.hpp"
#include "client/scenes/mesh_files/mesh_text.hpp"

namespace collided::cli {

namespace {

struct Numbered {
  uint64_t number = 0;
  std::string name;
};

/// What the names of a sequence have in common: what stands before the number, and behind it.
using Key = std::pair<std::string, std::string>;

/// The last number in the name of the file, not of its folders; none if there is none, or one of 20 digits.
std::optional<std::pair<Key, uint64_t>> split(const std::string& name) {
  constexpr const char* kDigits = "0123456789";
  const size_t file = name.find_last_of('/') + 1;  // 0 if there is none
  const size_t dot = name.find_last_of('.');
  const size_t last = name.find_last_of(kDigits, dot);
  if (last == std::string::npos || last < file) return {};
  const size_t before = name.find_last_not_of(kDigits, last);
  const size_t first = std::max(file, before == std::string::npos ? 0 : before + 1);
  uint64_t number = 0;
  if (std::from_chars(name.data() + first, name.data() + last + 1, number).ec != std::errc()) return {};
  return std::pair(Key(name.substr(0, first), name.substr(last + 1)), number);
}

/// Between the closest two, which are different numbers.
uint64_t step_of(const std::vector<Numbered>& frames) {
  uint64_t step = UINT64_MAX;
  for (size_t i = 1; i < frames.size(); ++i) {
    const uint64_t difference = frames[i].number - frames[i - 1].number;
    if (difference == 0) scenes::fail(frames[i].name, "has the same number as " + frames[i - 1].name);
    step = std::min(step, difference);
  }
  return step;
}

void add_pairs(const std::vector<Numbered>& frames, std::vector<FrameNames>& pairs, std::vector<std::string>& notes) {
  const uint64_t step = step_of(frames);
  for (size_t i = 1; i < frames.size(); ++i) {
    const Numbered &a = frames[i - 1], &b = frames[i];
    if (b.number - a.number == step)
      pairs.push_back({a.name, b.name});
    else
      notes.push_back("no pair of " + a.name + " and " + b.name + ": other frames of theirs are " +
                      std::to_string(step) + " apart");
  }
}

}  // namespace

std::vector<FrameNames> paired(const std::vector<std::string>& names, std::vector<std::string>& notes) {
  std::vector<std::vector<Numbered>> sequences;
  std::map<Key, size_t> sequence_of;
  for (const std::string& name : names) {
    const auto parts = split(name);
    if (!parts) {
      notes.push_back("no pair of " + name + ": its name has no number");
      continue;
    }
    const auto [at, is_new] = sequence_of.emplace(parts->first, sequences.size());
    if (is_new) sequences.emplace_back();
    sequences[at->second].push_back({parts->second, name});
  }
  std::vector<FrameNames> pairs;
  for (const auto& frames : sequences) {
    if (frames.size() == 1) notes.push_back("no pair of " + frames[0].name + ": no other file is of its sequence");
    add_pairs(frames, pairs, notes);
  }
  return pairs;
}

}  // namespace collided::cli
