// Reported contacts against the truth: both are lists in the order of their pairs, walked side by side.

#include "client/cli/tradeoff_judge.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace collided::cli {

namespace {

constexpr double kExactBracket = 0x1p-60;  // EXACT is at most this much early, and then rounded toward 0

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

/// The gaps and the lateness of all kinds, put together.
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
    ++contact;  // a pair that is reported twice is right once
  }
  score.missed = truth.size() - score.right;
  score.wrong = score.reported - score.right;
  return score;
}

/// The smallest value that at least the part `rank` of all values does not exceed.
double quantile(std::vector<double>& values, double rank) {
  const auto n = static_cast<double>(values.size());
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::max(1.0, std::ceil(rank * n))) - 1;
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::vector<TrueContact> as_truth(const std::vector<Reported>& contacts) {
  std::vector<TrueContact> out;
  out.reserve(contacts.size());
  for (const Reported& r : contacts) out.push_back({r.pair, r.toi, std::nextafter(r.toi + kExactBracket, 2)});
  return out;
}

}  // namespace

PairKey edge_pair(std::array<uint32_t, 2> a, std::array<uint32_t, 2> b) {
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  if (b < a) std::swap(a, b);
  return {a[0], a[1], b[0], b[1]};
}

Truth exact_truth(const client::FrameOutput& output) {
  return {as_truth(sorted(output.vertex_triangle, vertex_triangle_key)),
          as_truth(sorted(output.edge_edge, edge_edge_key))};
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
