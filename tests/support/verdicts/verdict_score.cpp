#include "tests/support/verdicts/verdict_score.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/support/families/query_families.hpp"

namespace collided::test {
namespace {

ExactImpact truth_of(const Query& query, Mode mode, double thickness) {
  if (mode == Mode::kCcd) return thickness > 0 ? judge_ccd(query, thickness) : judge_ccd(query);
  const std::array<Vec3d, 4> end{query.p[4], query.p[5], query.p[6], query.p[7]};
  return {judge_proximity(query.kind, end, thickness), 0, 1};
}

bool well_formed(const Verdict& v, Mode mode) {
  return !v.hit || ((mode == Mode::kDcd || (v.toi >= 0 && v.toi <= 1)) && v.distance >= 0);
}

// Adds one verdict to the score; returns the promise that it breaks, if any.
class Scorer {
 public:
  Scorer(Mode mode, Accuracy accuracy) : mode_(mode), accuracy_(accuracy) {}

  std::string add(const ExactImpact& truth, const Verdict& verdict) {
    ++score_.queries;
    score_.hits += truth.hit;
    if (!well_formed(verdict, mode_)) return count(score_.malformed, "malformed");
    if (!verdict.hit) return truth.hit ? count(score_.missed, "missed") : "";
    score_.capped += (verdict.flags & kFlagCapped) != 0;
    score_.certified += (verdict.flags & kFlagCertified) != 0;
    return truth.hit ? add_hit(truth, verdict) : add_false_hit(verdict);
  }
  Score take() { return std::move(score_); }

 private:
  static std::string count(uint64_t& counter, const char* what) {
    ++counter;
    return what;
  }

  std::string add_hit(const ExactImpact& truth, const Verdict& verdict) {
    const bool certified = verdict.flags & kFlagCertified;
    if (accuracy_ == Accuracy::kExact && !certified) return "not certified";
    if (mode_ == Mode::kDcd) return "";
    const mpq_class toi(verdict.toi);
    score_.gaps.push_back(mpq_class(truth.lower - toi).get_d());
    if (toi > truth.upper) return count(score_.late, "late");
    const bool says = verdict.flags & kFlagInitial, is = truth.upper == 0;
    const bool is_wrong = accuracy_ == Accuracy::kExact ? says != is : says && !is;
    return certified && is_wrong ? count(score_.wrong_initial, "wrong flag INITIAL") : "";
  }

  std::string add_false_hit(const Verdict& verdict) {
    ++score_.false_hits;
    if (verdict.flags & kFlagCertified) return count(score_.wrongly_certified, "false, yet certified");
    return accuracy_ == Accuracy::kExact ? "false" : "";
  }

  Mode mode_;
  Accuracy accuracy_;
  Score score_;
};

}  // namespace

Judged judge(std::vector<Query> queries, Mode mode, double thickness) {
  Judged judged{mode, thickness, std::move(queries), {}};
  judged.truth.resize(judged.queries.size());
  tbb::parallel_for(size_t{0}, judged.queries.size(),
                    [&](size_t i) { judged.truth[i] = truth_of(judged.queries[i], mode, thickness); });
  return judged;
}

double Score::worst_gap() const { return gaps.empty() ? 0 : *std::max_element(gaps.begin(), gaps.end()); }

double Score::median_gap() const {
  if (gaps.empty()) return 0;
  std::vector<double> sorted = gaps;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

double Score::worst_delay() const {
  return gaps.empty() ? 0 : std::max(0.0, -*std::min_element(gaps.begin(), gaps.end()));
}

Score& Score::operator+=(const Score& other) {
  queries += other.queries;
  hits += other.hits;
  missed += other.missed;
  late += other.late;
  false_hits += other.false_hits;
  capped += other.capped;
  certified += other.certified;
  wrongly_certified += other.wrongly_certified;
  wrong_initial += other.wrong_initial;
  malformed += other.malformed;
  gaps.insert(gaps.end(), other.gaps.begin(), other.gaps.end());
  return *this;
}

Score score(const Judged& judged, std::span<const Verdict> verdicts, Accuracy accuracy,
            std::vector<Offence>* offences) {
  Scorer scorer(judged.mode, accuracy);
  for (size_t i = 0; i < judged.queries.size(); ++i) {
    std::string what = scorer.add(judged.truth[i], verdicts[i]);
    if (!what.empty() && offences) offences->push_back({i, std::move(what)});
  }
  return scorer.take();
}

double typical_extent(std::span<const Query> queries) {
  if (queries.empty()) return 0;
  std::vector<double> extents;
  for (const Query& query : queries) extents.push_back(extent_of(query));
  const auto middle = extents.begin() + static_cast<std::ptrdiff_t>(extents.size() / 2);
  std::nth_element(extents.begin(), middle, extents.end());
  return *middle;
}

std::string text_of(const Verdict& verdict) {
  if (!verdict.hit) return "no hit";
  char text[120];
  std::snprintf(text, sizeof text, "hit, toi %.17g = %a, distance %g, flags %u", verdict.toi, verdict.toi,
                verdict.distance, verdict.flags);
  return text;
}

std::string text_of(const ExactImpact& truth) {
  if (!truth.hit) return "no hit";
  char text[80];
  std::snprintf(text, sizeof text, "hit, toi from %.17g to %.17g", truth.lower.get_d(), truth.upper.get_d());
  return text;
}

std::string name_of(Accuracy accuracy) {
  switch (accuracy) {
    case Accuracy::kCandidates:
      return "CANDIDATES";
    case Accuracy::kFast:
      return "FAST";
    case Accuracy::kGuarded:
      return "GUARDED";
    case Accuracy::kCertified:
      return "CERTIFIED";
    case Accuracy::kExact:
      return "EXACT";
  }
  return "?";
}

}  // namespace collided::test
