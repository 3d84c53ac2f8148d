// A load's report as one HTML page.

#include "client/measure/load/report/html.hpp"

#include <vector>

#include "client/app/output/markup.hpp"
#include "client/app/report/numbers.hpp"
#include "client/measure/load/report/chart.hpp"
#include "client/measure/load/report/plots.hpp"
#include "client/measure/load/report/style.hpp"
#include "client/measure/load/report/text.hpp"
#include "client/measure/load/tally/histogram.hpp"

namespace collided::cli::load {

namespace {

using Cells = std::vector<std::string>;

std::string ms(const Json& value) { return milliseconds_text(value.get<double>()); }
std::string count(const Json& value) { return count_text(value.get<uint64_t>()); }
std::string element(const std::string& name, const std::string& text) {
  return "<" + name + ">" + escape_markup(text) + "</" + name + ">";
}

std::string table_row(const char* cell, const Cells& cells) {
  std::string out = "<tr>";
  for (const std::string& text : cells) out += element(cell, text);
  return out + "</tr>\n";
}

/// The first row is its head.
std::string table(const std::string& title, const std::vector<Cells>& rows) {
  std::string out = element("h2", title) + "\n<div class=\"table\"><table>\n";
  for (size_t i = 0; i < rows.size(); ++i) out += table_row(i == 0 ? "th" : "td", rows[i]);
  return out + "</table></div>\n";
}

Cells times_cells(const std::string& name, const Json& times) {
  Cells cells{name, count(times.at("count")), ms(times.at("mean")), ms(times.at("min"))};
  for (const auto& [percentile, percent] : kPercentiles) cells.push_back(ms(times.at(percentile)));
  cells.push_back(ms(times.at("max")));
  return cells;
}

std::string times_table(const Json& outcome) {
  Cells head{"milliseconds", "frames", "mean", "min"};
  for (const auto& [percentile, percent] : kPercentiles) head.emplace_back(percentile);
  head.emplace_back("max");
  std::vector<Cells> rows{head};
  for (const auto& [name, times] : timed(outcome)) rows.push_back(times_cells(name, times));
  return table("Times", rows);
}

std::string frames_table(const Json& outcome) {
  std::vector<Cells> rows{{"frames", "count"}};
  for (const auto& [name, frames] : outcome.at("frames").items()) rows.push_back({name, count(frames)});
  for (const auto& [code, refused] : outcome.at("refused").items())
    rows.push_back({"refused, " + code + ": " + refused.at("first").get<std::string>(), count(refused.at("count"))});
  return table("Frames", rows);
}

std::string generations_table(const Json& outcome) {
  if (!outcome.contains("generations")) return "";
  std::vector<Cells> rows{{"generation", "setup s", "answered", "p50 ms", "p99 ms", "max ms"}};
  for (const Json& run : outcome.at("generations"))
    rows.push_back({std::to_string(rows.size()), format_double("%.3g", run.at("setup_seconds").get<double>()),
                    count(run.at("answered")), ms(run.at("p50_ms")), ms(run.at("p99_ms")), ms(run.at("max_ms"))});
  return table("Generations of scenes; all else is of the last", rows);
}

std::string comparison_table(const Json& outcome) {
  if (!outcome.contains("comparison")) return "";
  std::vector<Cells> rows{{"", "tester", "daemon"}};
  const auto number = [](const Json& value) { return format_double("%.10g", value.get<double>()); };
  for (const auto& [name, values] : outcome.at("comparison").items())
    if (values.is_object()) rows.push_back({name, number(values.at("tester")), number(values.at("daemon"))});
  return table("The daemon's counters", rows);
}

std::string trials_table(const Json& outcome) {
  if (!outcome.contains("find_max")) return "";
  std::vector<Cells> rows{{"frames/s of all streams", "answered", "p50 ms", "p99 ms", "max ms", ""}};
  for (const Json& trial : outcome.at("find_max").at("trials")) {
    const std::string failure = trial.at("failure");
    rows.push_back({format_double("%.1f", trial.at("frames_per_second")), count(trial.at("answered")),
                    ms(trial.at("p50_ms")), ms(trial.at("p99_ms")), ms(trial.at("max_ms")),
                    failure.empty() ? "held" : failure});
  }
  return table("Trials", rows);
}

std::string figure(const std::string& value, const std::string& name) {
  return "<div>" + element("b", value) + element("span", name) + "</div>\n";
}

std::string figures(const Json& outcome) {
  std::string out = "<div class=\"figures\">\n";
  if (outcome.contains("find_max")) {
    const Json& best = outcome.at("find_max").at("frames_per_second");
    out += figure(best.is_null() ? "none" : format_double("%.4g", best.get<double>()) + "/s",
                  "highest rate, p99 up to " + ms(outcome.at("find_max").at("p99_ms")) + " ms");
  }
  const Json &latency = outcome.at("latency_ms"), &frames = outcome.at("frames");
  for (const char* name : {"p50", "p99", "p99.9", "max"})
    out += figure(ms(latency.at(name)) + " ms", std::string("latency, ") + name);
  out += figure(format_double("%.4g", outcome.at("throughput").at("frames_per_second")), "frames a second");
  out += figure(count(frames.at("answered")), "answered of " + count(frames.at("due")));
  out += figure(ms(outcome.at("tester").at("cpu_ms_per_frame")) + " ms", "the tester's CPU a frame");
  return out + "</div>\n";
}

/// Each line as a paragraph.
std::string paragraphs(const std::string& text) {
  std::string out;
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find('\n', at), text.size());
    out += element("p", text.substr(at, end - at)) + "\n";
    at = end + 1;
  }
  return out;
}

std::string warnings(const Json& outcome) {
  std::string out;
  for (const Json& warning : outcome.at("warnings"))
    out += "<div class=\"warning\">" + escape_markup(warning.get<std::string>()) + "</div>\n";
  return out;
}

}  // namespace

std::string outcome_html(const Json& outcome) {
  const std::string title = "Load: " + outcome.at("input").at("name").get<std::string>();
  std::string out =
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n" +
      element("title", title) + "\n<style>" + kStyle + "</style>\n</head>\n<body>\n" + element("h1", title) + "\n" +
      paragraphs(load_text(outcome)) + warnings(outcome) + figures(outcome) + "<div class=\"plots\">\n";
  for (const Chart& chart : plots_of(outcome)) out += chart_svg(chart);
  return out + "</div>\n" + trials_table(outcome) + times_table(outcome) + frames_table(outcome) +
         comparison_table(outcome) + generations_table(outcome) + "</body>\n</html>\n";
}

}  // namespace collided::cli::load
