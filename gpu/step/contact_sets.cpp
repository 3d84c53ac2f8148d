#include "gpu/step/contact_sets.hpp"

#include <algorithm>

namespace collided {
namespace {

constexpr uint64_t kAtATime = 1u << 17;  ///< contacts

bool is_undecided(const ContactSet& set, size_t i) {
  return (set.flags[i] & (kFlagCertified | kFlagCapped)) != kFlagCertified || (!set.toi.empty() && set.toi[i] == 0);
}

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
  filter_array(set.toi);
  filter_array(set.distance);
  filter_array(set.weights);
  filter_array(set.flags);
  filter_array(set.elements);
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
  return places;
}

void apply(CpuLoops& loops, ContactSet& set, const std::vector<size_t>& places,
           const std::vector<ExactAnswer>& answers) {
  std::vector<bool> keep(set.size(), true);
  loops.in_turn(places.size(), kAtATime, [&](uint64_t first, uint64_t end) {
    for (size_t k = first; k < end; ++k) {
      const size_t i = places[k];
      keep[i] = answers[k].hit;
      set.flags[i] = kFlagCertified | (answers[k].initial ? kFlagInitial : 0);
      if (!set.toi.empty()) set.toi[i] = answers[k].toi;
    }
  });
  filter(loops, set, keep);
}

void keep_earliest(CpuLoops& loops, FrameResult& result) {
  ContactSet &vt = result.vertex_triangle, &ee = result.edge_edge;
  const auto first_of = [&](const ContactSet& set) {
    return static_cast<size_t>(std::min_element(set.toi.begin(), set.toi.end()) - set.toi.begin());
  };
  const size_t v = first_of(vt), e = first_of(ee);
  const bool vt_wins = v < vt.size() && (e == ee.size() || vt.toi[v] <= ee.toi[e]);
  keep_one(loops, vt, vt_wins ? v : vt.size());
  keep_one(loops, ee, vt_wins ? ee.size() : e);
}

double earliest_toi(const ContactSet& set) {
  return set.toi.empty() ? 1 : *std::min_element(set.toi.begin(), set.toi.end());
}

}  // namespace collided
