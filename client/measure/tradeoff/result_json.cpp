// Results of 'collidectl tradeoff' as JSON.

#include "client/measure/tradeoff/result_json.hpp"

namespace collided::cli {

namespace {

constexpr const char* kFormat = "collided tradeoff 1";

Json kind_json(const KindScore& s) {
  return {{"reported", s.reported}, {"right", s.right}, {"missed", s.missed}, {"false", s.wrong}, {"late", s.late}};
}

Json gap_json(const std::optional<Gap>& gap) {
  if (!gap) return nullptr;
  return {{"median", gap->median}, {"p99", gap->p99}, {"worst", gap->worst}};
}

Json score_json(const Score& score) {
  return {{"sum", kind_json(sum(score))},
          {"vertex_triangle", kind_json(score.vertex_triangle)},
          {"edge_edge", kind_json(score.edge_edge)},
          {"toi_gap", gap_json(score.gap)},
          {"latest_by", score.latest}};
}

Json times_json(const Times& times) {
  return {{"narrow", times.narrow}, {"stages", times.stages}, {"total", times.total}, {"stage", times.stage}};
}

Json work_json(const Work& work) {
  return {{"survivors_vertex_triangle", work.survivors_vertex_triangle},
          {"survivors_edge_edge", work.survivors_edge_edge},
          {"exact_decisions", work.exact_decisions},
          {"certified", work.certified},
          {"near", work.near},
          {"capped", work.capped}};
}

Json run_json(const Run& run) {
  return {{"position_format", run.format},
          {"level", run.level},
          {"delta", run.delta ? Json(*run.delta) : Json(nullptr)},
          {"bytes_in", run.bytes},
          {"contacts", score_json(run.score)},
          {"median_ms", times_json(run.times)},
          {"counts", work_json(run.work)}};
}

Json truth_json(const TruthUsed& truth) {
  return {{"position_format", truth.format},
          {"source", truth.source},
          {"vertex_triangle", truth.vertex_triangle},
          {"edge_edge", truth.edge_edge},
          {"bounded_times", truth.bounded}};
}

template <class T>
Json list_json(const std::vector<T>& values, Json (*to_json)(const T&)) {
  Json out = Json::array();
  for (const T& value : values) out.push_back(to_json(value));
  return out;
}

}  // namespace

Json tradeoff_json(const Tradeoff& result) {
  return {{"format", kFormat},
          {"name", result.name},
          {"input", result.input},
          {"date", result.date},
          {"commit", result.commit},
          {"version", result.version},
          {"backend", result.backend},
          {"device", result.device},
          {"vertices", result.vertices},
          {"edges", result.edges},
          {"triangles", result.triangles},
          {"mode", "ccd"},
          {"thickness", result.thickness},
          {"repeats", result.repeats},
          {"truths", list_json(result.truths, truth_json)},
          {"runs", list_json(result.runs, run_json)}};
}

Json tradeoff_summary(const Tradeoff& result) {
  Json runs = Json::array();
  for (const Run& run : result.runs) {
    const KindScore score = sum(run.score);
    runs.push_back({{"position_format", run.format},
                    {"level", run.level},
                    {"delta", run.delta ? Json(*run.delta) : Json(nullptr)},
                    {"contact_count", score.reported},
                    {"missed", score.missed},
                    {"false", score.wrong},
                    {"late", score.late},
                    {"narrow_ms", run.times.narrow},
                    {"total_ms", run.times.total}});
  }
  return {{"name", result.name}, {"device", result.device}, {"triangles", result.triangles}, {"runs", runs}};
}

}  // namespace collided::cli
