// Merges the reported contacts and the true ones, both sorted by pair.

#include "client/measure/tradeoff/judge.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "client/measure/statistics.hpp"

namespace collided::cli {

namespace {

constexpr double kExactBracket = 0x1p-60;  // exact times are at most this early, before they are rounded towards 0

struct Reported {
  PairKey pair;
  double toi;
};

PairKey vertex_triangle_key(const client::Contacts& contacts, size_t i) {
  return {contacts.elements[i][0], contacts.elements[i][1], 0, 0};
}

std::vector<Reported> sorted(const client::Contacts& contacts, PairKey (*key)(const client::Contacts&, size_t)) {
  if (contacts.toi.size() != contacts.count || contacts.stencils.size() != contacts.count)
    throw std::runtime_error("the daemon sent contacts without time of impact or vertices: nothing can be judged");
  std::vector<Reported> out(contacts.count);
  for (size_t i = 0; i < out.size(); ++i) out[i] = {key(contacts, i), contacts.toi[i]};
  std::sort(out.begin(), out.end(), [](const Reported& a, const Reported& b) { return a.pair < b.pair; });
  return out;
}

PairKey edge_edge_key(const client::Contacts& contacts, size_t i) {
  const auto& s = contacts.stencils[i];
  return edge_pair({s[0], s[1]}, {s[2], s[3]});
}

/// Gaps, and the worst lateness, of contacts of all kinds.
struct Gaps {
  std::vector<double> values;
  double latest = 0;
};

KindScore judge_kind(const std::vector<TrueContact>& truth, const std::vector<Reported>& reported, Gaps& gaps) {
  KindScore score;
  score.reported = reported.size();
  auto contact = truth.begin();
  for (const Reported& r : reported) {
    while (contact != truth.end() && contact->pair < r.pair) ++contact;
    if (contact == truth.end() || contact->pair != r.pair) continue;
    ++score.right;
    gaps.values.push_back(contact->toi - r.toi);
    if (r.toi > contact->last_toi) {
      ++score.late;
      gaps.latest = std::max(gaps.latest, r.toi - contact->toi);
    }
    ++contact;  // a pair reported twice is right once
  }
  score.missed = truth.size() - score.right;
  score.wrong = score.reported - score.right;
  return score;
}

std::vector<TrueContact> as_truth(const std::vector<Reported>& close, const std::vector<Reported>& wide,
                                  uint64_t& bounded) {
  const auto is_same_pair = [](const Reported& a, const Reported& b) { return a.pair == b.pair; };
  if (!std::equal(close.begin(), close.end(), wide.begin(), wide.end(), is_same_pair))
    throw std::runtime_error("the level exact finds other contacts with another delta: it cannot be the judge");
  std::vector<TrueContact> out;
  out.reserve(close.size());
  for (size_t i = 0; i < close.size(); ++i) {
    const bool is_exact = wide[i].toi > 0;
    const double toi = is_exact ? wide[i].toi : close[i].toi;
    bounded += !is_exact;
    out.push_back({close[i].pair, toi, std::nextafter(toi + (is_exact ? kExactBracket : kBoundedTime), 2)});
  }
  return out;
}

}  // namespace

Truth exact_truth(const client::FrameOutput& close, const client::FrameOutput& wide) {
  Truth truth;
  truth.vertex_triangle = as_truth(sorted(close.vertex_triangle, vertex_triangle_key),
                                   sorted(wide.vertex_triangle, vertex_triangle_key), truth.bounded);
  truth.edge_edge =
      as_truth(sorted(close.edge_edge, edge_edge_key), sorted(wide.edge_edge, edge_edge_key), truth.bounded);
  return truth;
}

Score judge(const Truth& truth, const client::FrameOutput& output) {
  Gaps gaps;
  Score score;
  score.vertex_triangle = judge_kind(truth.vertex_triangle, sorted(output.vertex_triangle, vertex_triangle_key), gaps);
  score.edge_edge = judge_kind(truth.edge_edge, sorted(output.edge_edge, edge_edge_key), gaps);
  score.latest = gaps.latest;
  if (!gaps.values.empty())
    score.gap = Gap{quantile(gaps.values, 0.5), quantile(gaps.values, 0.99), quantile(gaps.values, 1)};
  return score;
}

}  // namespace collided::cli
