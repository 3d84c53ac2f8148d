#include "gpu/step/contact_sets.hpp"

#include <algorithm>

#include "gpu/contacts/contact.hpp"

namespace collided {
namespace {

constexpr uint64_t kAtATime = 1u << 17;  ///< contacts

bool is_undecided(const ContactSet& set, size_t i) {
  return collided::is_undecided(set.flags[i], !set.toi.empty() && set.toi[i] == 0);
}

bool is_apart(const ContactSet& set, size_t i) { return (set.flags[i] & kFlagApart) != 0; }

/// Keeps entry i of every array if keep[i].
void filter(CpuLoops& loops, ContactSet& set, const std::vector<bool>& keep) {
  const auto filter_array = [&](auto& array) {
    if (array.empty()) return;
    size_t n = 0;
    loops.in_turn(keep.size(), kAtATime, [&](uint64_t first, uint64_t end) {
      for (size_t i = first; i < end; ++i)
        if (keep[i]) array[n++] = array[i];
    });
    array.truncate(n);
  };
  for_each_field([&](ContactField, auto& column) { filter_array(column); }, set);
}

/// At most 1. In lanes, as each comparison would else wait for the last.
double least_of(const double* times, uint64_t count) {
  constexpr uint64_t kLanes = 16;
  double least[kLanes];
  std::fill_n(least, kLanes, 1.0);
  uint64_t i = 0;
  for (; i + kLanes <= count; i += kLanes)
    for (uint64_t k = 0; k < kLanes; ++k) least[k] = times[i + k] < least[k] ? times[i + k] : least[k];
  for (; i < count; ++i) least[0] = std::min(least[0], times[i]);
  return *std::min_element(least, least + kLanes);
}

double least_of_approaching(const double* times, const uint8_t* flags, uint64_t count) {
  double least = 1;
  for (uint64_t i = 0; i < count; ++i) least = std::min(least, (flags[i] & kFlagSeparating) != 0 ? 1 : times[i]);
  return least;
}

/// Keeps those at `places` of which take(index in places, place) is true, and all others.
template <class Take>
void keep_if(CpuLoops& loops, ContactSet& set, const std::vector<size_t>& places, const Take& take) {
  std::vector<bool> keep(set.size(), true);
  size_t kept = set.size();
  loops.in_turn(places.size(), kAtATime, [&](uint64_t first, uint64_t end) {
    for (size_t k = first; k < end; ++k) {
      const bool stays = take(k, places[k]);
      keep[places[k]] = stays;
      kept -= stays ? 0 : 1;
    }
  });
  if (kept < set.size()) filter(loops, set, keep);
}

void keep_one(CpuLoops& loops, ContactSet& set, size_t place) {
  std::vector<bool> keep(set.size(), false);
  if (place < keep.size()) keep[place] = true;
  filter(loops, set, keep);
}

}  // namespace

size_t count_undecided(CpuLoops& loops, const ContactSet& set) {
  size_t count = 0;
  loops.in_turn(set.size(), kAtATime, [&](uint64_t first, uint64_t end) {
    for (size_t i = first; i < end; ++i) count += is_undecided(set, i) ? 1 : 0;
  });
  return count;
}

std::vector<size_t> undecided(CpuLoops& loops, const ContactSet& set, size_t count) {
  std::vector<size_t> places;
  places.reserve(count);
  loops.in_turn(set.size(), kAtATime, [&](uint64_t first, uint64_t end) {
    for (size_t i = first; i < end; ++i)
      if (is_undecided(set, i)) places.push_back(i);
  });
  std::stable_partition(places.begin(), places.end(), [&](size_t i) { return !is_apart(set, i); });
  return places;
}

size_t count_open(const ContactSet& set, const std::vector<size_t>& places) {
  const auto open = [&](size_t i) { return !is_apart(set, i); };
  return static_cast<size_t>(std::partition_point(places.begin(), places.end(), open) - places.begin());
}

void apply(CpuLoops& loops, ContactSet& set, const std::vector<size_t>& places, const std::vector<ExactAnswer>& answers,
           const std::vector<Normal>& normals) {
  keep_if(loops, set, places, [&](size_t k, size_t i) {
    set.flags[i] = decided_flags(set.flags[i], answers[k].initial);
    if (!set.toi.empty()) set.toi[i] = answers[k].toi;
    if (!normals.empty()) set.normals[i] = normals[k];
    return answers[k].hit;
  });
}

void apply(CpuLoops& loops, ContactSet& set, const std::vector<size_t>& places,
           const std::vector<EdgeTriangleVerdict>& verdicts) {
  keep_if(loops, set, places, [&](size_t k, size_t i) {
    const EdgeTriangleVerdict& verdict = verdicts[k];
    set.flags[i] = static_cast<uint8_t>(kFlagCertified | (verdict.touches ? kFlagTouching : 0));
    if (!set.weights.empty()) set.weights[i] = {verdict.weights[0], verdict.weights[1]};
    return verdict.crosses;
  });
}

void take_marks(CpuLoops& loops, ContactSet& set) {
  loops.in_turn(set.flags.size(), kAtATime, [&](uint64_t first, uint64_t end) {
    for (size_t i = first; i < end; ++i) set.flags[i] &= static_cast<uint8_t>(~kFlagOnArc);
  });
}

void keep_earliest(CpuLoops& loops, PerKind<ContactSet>& contacts) {
  const ContactSet* winner = nullptr;
  size_t place = 0;
  for_each_kind(
      [&](ContactKind, const ContactSet& set) {
        const size_t first = static_cast<size_t>(std::min_element(set.toi.begin(), set.toi.end()) - set.toi.begin());
        if (first < set.toi.size() && (winner == nullptr || set.toi[first] < winner->toi[place]))
          winner = &set, place = first;
      },
      contacts);
  for_each_kind([&](ContactKind, ContactSet& set) { keep_one(loops, set, &set == winner ? place : set.size()); },
                contacts);
}

double earliest_toi(CpuLoops& loops, const PerKind<ContactSet>& contacts, bool ignore_separating) {
  double earliest = 1;
  for_each_kind(
      [&](ContactKind, const ContactSet& set) {
        loops.in_turn(set.toi.size(), kAtATime, [&](uint64_t first, uint64_t end) {
          const double least = ignore_separating
                                   ? least_of_approaching(set.toi.data() + first, set.flags.data() + first, end - first)
                                   : least_of(set.toi.data() + first, end - first);
          earliest = std::min(earliest, least);
        });
      },
      contacts);
  return earliest;
}

}  // namespace collided
