// Results of 'collidectl tradeoff' for people.

#include "client/measure/tradeoff/report.hpp"

#include <cmath>
#include <cstdio>

#include "client/app/options/values.hpp"
#include "client/app/report/numbers.hpp"
#include "client/cpp/positions.hpp"

namespace collided::cli {

namespace {

using Cells = std::vector<std::string>;

/// Both kinds and their sum: "30 (10 + 20)".
std::string counts(const Score& score, uint64_t KindScore::*part) {
  const uint64_t both = sum(score).*part;
  if (both == 0) return "0";
  return count_text(both) + " (" + count_text(score.vertex_triangle.*part) + " + " + count_text(score.edge_edge.*part) +
         ")";
}

std::string gap_text(const std::optional<Gap>& gap, double Gap::*part) {
  return gap ? format_double("%.1e", (*gap).*part) : "-";
}

std::string row(const Cells& cells) {
  std::string out = "|";
  for (const std::string& cell : cells) out += " " + cell + " |";
  return out + "\n";
}

std::string head(const Cells& cells, size_t left) {
  std::string out = row(cells) + "|";
  for (size_t i = 0; i < cells.size(); ++i) out += i < left ? " --- |" : " --: |";
  return out + "\n";
}

Cells key_cells(const Run& run) { return {run.format, run.level, run.delta ? delta_text(*run.delta) : "-"}; }

std::string answers_row(const Run& run) {
  const Score& score = run.score;
  Cells cells = key_cells(run);
  for (const auto part :
       {&KindScore::reported, &KindScore::right, &KindScore::missed, &KindScore::wrong, &KindScore::late})
    cells.push_back(counts(score, part));
  cells.push_back(sum(score).late == 0 ? "-" : format_double("%.1e", score.latest));
  for (const auto part : {&Gap::median, &Gap::p99, &Gap::worst}) cells.push_back(gap_text(score.gap, part));
  return row(cells);
}

const Run* fast_run(const Tradeoff& result, const std::string& format) {
  for (const Run& run : result.runs)
    if (run.level == "fast" && run.format == format) return &run;
  return nullptr;
}

/// Each time, and its ratio to the level fast.
std::string cost_row(const Run& run, const Run* fast) {
  Cells cells = key_cells(run);
  for (const auto part : {&Times::narrow, &Times::stages, &Times::total}) {
    const double ms = run.times.*part;
    cells.push_back(milliseconds_text(ms));
    cells.push_back(fast && fast->times.*part > 0 ? format_double("%.2f", ms / fast->times.*part) : "-");
  }
  cells.push_back(count_text(run.bytes));
  const Work& work = run.work;
  for (const uint64_t n : {work.survivors_vertex_triangle, work.survivors_edge_edge, work.certified, work.near,
                           work.capped, work.exact_decisions})
    cells.push_back(count_text(n));
  return row(cells);
}

std::string truth_text(const TruthUsed& truth) {
  const std::string found =
      count_text(truth.vertex_triangle) + " vertex-triangle and " + count_text(truth.edge_edge) + " edge-edge contacts";
  const std::string source = truth.source != "exact" ? "given by `" + truth.source + "`"
                             : client::is_quantized(format_of(truth.format))
                                 ? "the level `EXACT` on the positions before they were encoded, in f64"
                                 : "the level `EXACT` on the same positions";
  const std::string times = truth.bounded == 0 ? ""
                                               : "; the times of impact of " + count_text(truth.bounded) +
                                                     " of them are not exact, but at most 1e-9 of the step early";
  return "- " + truth.format + ": " + source + "; " + found + times + "\n";
}

std::string setting_text(const Tradeoff& result) {
  std::string text = result.device + " (" + result.backend + "), collided " + result.version;
  if (!result.commit.empty()) text += ", commit " + result.commit;
  if (!result.date.empty()) text += ", " + result.date;
  return text + "; " + result.input + ", " + count_text(result.triangles) + " triangles, CCD, thickness " +
         format_double("%g", result.thickness) + "; medians of " + std::to_string(result.repeats) +
         " steps, the levels taking turns.\n";
}

}  // namespace

std::string delta_text(double delta) {
  if (delta == 0) return "auto";
  const double exponent = std::floor(std::log10(delta) + 1e-9);  // 1e-3 and not 0.001
  const std::string mantissa = format_double("%.6g", delta / std::pow(10, exponent));
  return exponent < -1 ? mantissa + "e" + format_double("%g", exponent) : format_double("%g", delta);
}

std::string tradeoff_markdown(const Tradeoff& result) {
  std::string out = "## " + result.name + "\n\n" + setting_text(result) + "\nTruth, by position format:\n\n";
  for (const TruthUsed& truth : result.truths) out += truth_text(truth);
  out +=
      "\nAnswers: sums (vertex-triangle + edge-edge). Missed: true, but not reported; false: reported, but not true; "
      "late: a time of impact after the true one. Gap: true time of impact minus the reported one, as a fraction of "
      "the step, over the right contacts. Delta `auto` is the daemon's own choice.\n\n";
  out += head({"positions", "level", "delta", "contacts", "right", "missed", "false", "late", "latest by", "gap median",
               "gap p99", "gap worst"},
              3);
  for (const Run& run : result.runs) out += answers_row(run);
  out +=
      "\nCost: milliseconds, and their ratio to `fast` on the same positions (x); bytes of a frame's positions; pairs "
      "that the coplanarity filter "
      "left; contacts by flag; pairs decided in exact arithmetic.\n\n";
  out += head({"positions", "level", "delta", "narrow", "x", "all stages", "x", "total", "x", "bytes", "left VT",
               "left EE", "certified", "near", "capped", "exact decisions"},
              3);
  for (const Run& run : result.runs) out += cost_row(run, fast_run(result, run.format));
  return out;
}

std::string tradeoff_text(const Tradeoff& result) {
  std::string out = result.name + ", " + count_text(result.triangles) + " triangles, " + result.device + "\n";
  for (const Run& run : result.runs) {
    const KindScore score = sum(run.score);
    const std::string name = run.format + " " + run.level + (run.delta ? " " + delta_text(*run.delta) : "");
    char line[160];
    std::snprintf(line, sizeof line, "  %-20s %s contacts, %s missed, %s false, %s late; narrow phase %s ms\n",
                  name.c_str(), count_text(score.reported).c_str(), count_text(score.missed).c_str(),
                  count_text(score.wrong).c_str(), count_text(score.late).c_str(),
                  milliseconds_text(run.times.narrow).c_str());
    out += line;
  }
  return out;
}

}  // namespace collided::cli
