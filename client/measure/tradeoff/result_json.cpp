// A tradeoff to JSON and back.

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include "client/measure/tradeoff/report.hpp"

namespace collided::cli {

namespace {

constexpr const char* kFormat = "collided tradeoff 1";

Json kind_json(const KindScore& s) {
  return {{"reported", s.reported}, {"right", s.right}, {"missed", s.missed}, {"false", s.wrong}, {"late", s.late}};
}

KindScore kind_of(const Json& json) {
  return {json.at("reported"), json.at("right"), json.at("missed"), json.at("false"), json.at("late")};
}

Json gap_json(const std::optional<Gap>& gap) {
  if (!gap) return nullptr;
  return {{"median", gap->median}, {"p99", gap->p99}, {"worst", gap->worst}};
}

std::optional<Gap> gap_of(const Json& json) {
  if (json.is_null()) return std::nullopt;
  return Gap{json.at("median"), json.at("p99"), json.at("worst")};
}

Json score_json(const Score& score) {
  return {{"sum", kind_json(sum(score))},
          {"vertex_triangle", kind_json(score.vertex_triangle)},
          {"edge_edge", kind_json(score.edge_edge)},
          {"toi_gap", gap_json(score.gap)},
          {"latest_by", score.latest}};
}

Score score_of(const Json& json) {
  return {kind_of(json.at("vertex_triangle")), kind_of(json.at("edge_edge")), gap_of(json.at("toi_gap")),
          json.at("latest_by")};
}

Json times_json(const Times& times) {
  return {{"narrow", times.narrow}, {"stages", times.stages}, {"total", times.total}, {"stage", times.stage}};
}

Times times_of(const Json& json) {
  return {json.at("narrow"), json.at("stages"), json.at("total"),
          json.at("stage").get<std::map<std::string, double>>()};
}

Json work_json(const Work& work) {
  return {{"survivors_vertex_triangle", work.survivors_vertex_triangle},
          {"survivors_edge_edge", work.survivors_edge_edge},
          {"exact_decisions", work.exact_decisions},
          {"certified", work.certified},
          {"near", work.near},
          {"capped", work.capped}};
}

Work work_of(const Json& json) {
  return {json.at("survivors_vertex_triangle"),
          json.at("survivors_edge_edge"),
          json.at("exact_decisions"),
          json.at("certified"),
          json.at("near"),
          json.at("capped")};
}

std::string known(const std::string& name, std::initializer_list<std::string> names) {
  if (std::find(names.begin(), names.end(), name) == names.end())
    throw std::runtime_error("'" + name + "' is not known");
  return name;
}

Json run_json(const Run& run) {
  return {{"position_format", run.format},
          {"level", run.level},
          {"delta", run.delta ? Json(*run.delta) : Json(nullptr)},
          {"contacts", score_json(run.score)},
          {"median_ms", times_json(run.times)},
          {"counts", work_json(run.work)}};
}

Run run_of(const Json& json) {
  const Json& delta = json.at("delta");
  return {known(json.at("position_format"), {"f32", "f64"}),
          known(json.at("level"), {"fast", "guarded", "certified", "exact"}),
          delta.is_null() ? std::nullopt : std::optional(delta.get<double>()),
          score_of(json.at("contacts")),
          times_of(json.at("median_ms")),
          work_of(json.at("counts"))};
}

Json truth_json(const TruthUsed& truth) {
  return {{"position_format", truth.format},
          {"source", truth.source},
          {"vertex_triangle", truth.vertex_triangle},
          {"edge_edge", truth.edge_edge},
          {"bounded_times", truth.bounded}};
}

TruthUsed truth_of(const Json& json) {
  return {json.at("position_format"), json.at("source"), json.at("vertex_triangle"), json.at("edge_edge"),
          json.at("bounded_times")};
}

template <class T>
Json list_json(const std::vector<T>& values, Json (*to_json)(const T&)) {
  Json out = Json::array();
  for (const T& value : values) out.push_back(to_json(value));
  return out;
}

template <class T>
std::vector<T> list_of(const Json& json, T (*from_json)(const Json&)) {
  std::vector<T> out;
  for (const Json& value : json) out.push_back(from_json(value));
  return out;
}

Tradeoff tradeoff_of(const Json& json) {
  if (json.at("format") != kFormat) throw std::runtime_error("its format is not '" + std::string(kFormat) + "'");
  Tradeoff out{.name = json.at("name"),
               .input = json.at("input"),
               .date = json.at("date"),
               .commit = json.at("commit"),
               .version = json.at("version"),
               .backend = json.at("backend"),
               .device = json.at("device"),
               .vertices = json.at("vertices"),
               .edges = json.at("edges"),
               .triangles = json.at("triangles"),
               .thickness = json.at("thickness"),
               .repeats = json.at("repeats"),
               .truths = list_of(json.at("truths"), truth_of),
               .runs = list_of(json.at("runs"), run_of)};
  if (out.runs.empty()) throw std::runtime_error("it has no runs");
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

Tradeoff read_tradeoff(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file.string() + ": cannot be read");
  try {
    return tradeoff_of(Json::parse(in));
  } catch (const std::exception& e) {
    throw std::runtime_error(file.string() + ": is no result of 'collidectl tradeoff': " + e.what());
  }
}

}  // namespace collided::cli
