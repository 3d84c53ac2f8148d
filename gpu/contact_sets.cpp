#include "gpu/contact_sets.hpp"

#include <algorithm>

namespace collided {
namespace {

/// Keeps entry i of every array if keep[i].
void filter(ContactSet& set, const std::vector<bool>& keep) {
  const auto filter_array = [&](auto& array) {
    if (array.empty()) return;
    size_t n = 0;
    for (size_t i = 0; i < keep.size(); ++i)
      if (keep[i]) array[n++] = array[i];
    array.resize(n);
  };
  filter_array(set.toi);
  filter_array(set.distance);
  filter_array(set.weights);
  filter_array(set.flags);
  filter_array(set.elements);
}

void keep_one(ContactSet& set, size_t place) {
  std::vector<bool> keep(set.size(), false);
  if (place < keep.size()) keep[place] = true;
  filter(set, keep);
}

}  // namespace

std::vector<size_t> undecided(const ContactSet& set) {
  std::vector<size_t> places;
  for (size_t i = 0; i < set.size(); ++i)
    if ((set.flags[i] & (kFlagCertified | kFlagCapped)) != kFlagCertified || (!set.toi.empty() && set.toi[i] == 0))
      places.push_back(i);
  return places;
}

void apply(ContactSet& set, const std::vector<size_t>& places, const std::vector<ExactAnswer>& answers) {
  std::vector<bool> keep(set.size(), true);
  for (size_t k = 0; k < places.size(); ++k) {
    const size_t i = places[k];
    keep[i] = answers[k].hit;
    set.flags[i] = kFlagCertified | (answers[k].initial ? kFlagInitial : 0);
    if (!set.toi.empty()) set.toi[i] = answers[k].toi;
  }
  filter(set, keep);
}

void keep_earliest(FrameResult& result) {
  ContactSet &vt = result.vertex_triangle, &ee = result.edge_edge;
  const auto first_of = [&](const ContactSet& set) {
    return static_cast<size_t>(std::min_element(set.toi.begin(), set.toi.end()) - set.toi.begin());
  };
  const size_t v = first_of(vt), e = first_of(ee);
  const bool vt_wins = v < vt.size() && (e == ee.size() || vt.toi[v] <= ee.toi[e]);
  keep_one(vt, vt_wins ? v : vt.size());
  keep_one(ee, vt_wins ? ee.size() : e);
}

double earliest_toi(const ContactSet& set) {
  return set.toi.empty() ? 1 : *std::min_element(set.toi.begin(), set.toi.end());
}

}  // namespace collided
