#include "gpu/exact/batch.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "gpu/detector.hpp"

namespace collided {
namespace {

/// f(i) for i in [0, n), cancellable: a decision takes microseconds to milliseconds.
template <class F>
void for_each_pair(const ExactQuestion& question, size_t n, const F& f) {
  constexpr size_t kBetweenChecks = 128;
  tbb::task_arena arena(question.threads > 0 ? question.threads : tbb::task_arena::automatic);
  for (size_t first = 0; first < n; first += kBetweenChecks) {
    if (question.cancelled && question.cancelled()) throw Cancelled();
    const size_t last = std::min(n, first + kBetweenChecks);
    arena.execute([&] {
      tbb::parallel_for(tbb::blocked_range<size_t>(first, last), [&](const tbb::blocked_range<size_t>& range) {
        for (size_t i = range.begin(); i != range.end(); ++i) f(i);
      });
    });
  }
}

ExactAnswer decide(const ExactQuestion& question, const ExactPoints& p) {
  const Vec3<double> start[4] = {p[0], p[1], p[2], p[3]}, end[4] = {p[4], p[5], p[6], p[7]};
  const auto near = question.vertex_triangle ? exact_proximity_vertex_triangle : exact_proximity_edge_edge;
  if (!question.continuous) return {near(end, question.thickness), 0, false};
  const ExactImpact impact = question.vertex_triangle ? exact_ccd_vertex_triangle(start, end, question.thickness)
                                                      : exact_ccd_edge_edge(start, end, question.thickness);
  // A time below 2^-60 is rounded to 0 too.
  return {impact.hit, impact.toi, impact.hit && impact.toi == 0 && near(start, question.thickness)};
}

}  // namespace

std::vector<ExactAnswer> decide_exactly(const ExactQuestion& question, const std::vector<ExactPoints>& pairs) {
  std::vector<ExactAnswer> answers(pairs.size());
  for_each_pair(question, pairs.size(), [&](size_t i) { answers[i] = decide(question, pairs[i]); });
  return answers;
}

std::vector<ExactAnswer> decide_triangles_exactly(const ExactQuestion& question,
                                                  const std::vector<std::array<Vec3<double>, 6>>& pairs) {
  std::vector<ExactAnswer> answers(pairs.size());
  for_each_pair(question, pairs.size(), [&](size_t i) {
    const auto& p = pairs[i];
    answers[i].hit = exact_triangles_intersect({p[0], p[1], p[2]}, {p[3], p[4], p[5]});
  });
  return answers;
}

}  // namespace collided
