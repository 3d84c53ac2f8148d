// A load's report for people.

#include "client/measure/load/report/text.hpp"

#include <algorithm>
#include <cstdio>
#include <vector>

#include "client/app/report/numbers.hpp"
#include "client/measure/load/tally/histogram.hpp"

namespace collided::cli::load {

namespace {

std::string count(const Json& value) { return count_text(value.get<uint64_t>()); }
std::string number(const char* format, const Json& value) { return format_double(format, value.get<double>()); }
std::string plural(const Json& value, const std::string& noun) {
  return count(value) + " " + noun + (value == 1 ? "" : "s");
}
std::string ms(const Json& value) { return milliseconds_text(value.get<double>()); }
/// As count_text where there are no decimals to lose.
std::string rate(const Json& value) {
  const double rate = value.get<double>();
  return rate >= 1000 ? count_text(static_cast<uint64_t>(rate + 0.5)) : format_double("%.4g", rate);
}

std::string profile_text(const Json& load) {
  std::string out;
  for (const Json& stretch : load.at("frames_per_second_each")) {
    const bool is_constant = stretch.at("from") == stretch.at("to");
    out += (out.empty() ? "" : ", then ") + (is_constant ? "" : rate(stretch.at("from")) + " to ") +
           rate(stretch.at("to")) + " frames/s of each stream for " + number("%g", stretch.at("seconds")) + " s";
  }
  return out;
}

std::string row(const std::string& name, const std::vector<std::string>& cells) {
  char cell[64];
  std::snprintf(cell, sizeof cell, "%-26s", name.c_str());
  std::string out = cell;
  for (const std::string& text : cells) {
    std::snprintf(cell, sizeof cell, " %9s", text.c_str());
    out += cell;
  }
  return out + "\n";
}

std::string times_row(const std::string& name, const Json& times) {
  std::vector<std::string> cells{ms(times.at("mean"))};
  for (const auto& [percentile, percent] : kPercentiles) cells.push_back(ms(times.at(percentile)));
  cells.push_back(ms(times.at("max")));
  return row(name, cells);
}

std::string times_text(const Json& outcome) {
  std::vector<std::string> names{"mean"};
  for (const auto& [percentile, percent] : kPercentiles) names.emplace_back(percentile);
  names.emplace_back("max");
  std::string out = "\n" + row("milliseconds", names);
  for (const auto& [name, times] : timed(outcome)) out += times_row(name, times);
  return out;
}

std::string counts_text(const Json& outcome) {
  std::string out;
  for (const auto& [name, frames] : outcome.at("frames").items())
    if (name == "due" || name == "sent" || name == "answered" || frames != 0)
      out += (out.empty() ? "\nframes: " : ", ") + count(frames) + " " + name;
  out += "\n";
  for (const auto& [code, refused] : outcome.at("refused").items())
    out += "  refused, " + code + ": " + count(refused.at("count")) +
           ", such as: " + refused.at("first").get<std::string>() + "\n";
  const Json& throughput = outcome.at("throughput");
  return out + "throughput: " + rate(throughput.at("frames_per_second")) + " frames/s, " +
         bytes_text(throughput.at("bytes_in_per_second")) + "/s in, " +
         bytes_text(throughput.at("bytes_out_per_second")) + "/s of contacts out, over " +
         number("%.3g", throughput.at("seconds")) + " s\n";
}

std::string tester_text(const Json& tester) {
  return "tester: " + ms(tester.at("cpu_ms_per_frame")) + " ms of CPU a frame, " + number("%.2g", tester.at("cores")) +
         " cores, " + count(tester.at("threads")) + " threads, the busiest of which worked " +
         format_double("%.0f", 100 * tester.at("busiest_thread").get<double>()) + " % of the time\n";
}

std::string comparison_text(const Json& outcome) {
  if (!outcome.contains("comparison")) return "";
  std::string out;
  for (const auto& [name, values] : outcome.at("comparison").items())
    if (values.is_object())
      out += (out.empty() ? "" : ", ") + name + " " + number("%.10g", values.at("daemon")) + " (tester " +
             number("%.10g", values.at("tester")) + ")";
  return "daemon's counters: " + out + "; at most " +
         number("%.2g", outcome.at("comparison").at("max_difference_percent")) + " % apart\n";
}

std::string search_text(const Json& outcome) {
  if (!outcome.contains("find_max")) return "";
  const Json& search = outcome.at("find_max");
  std::string out = "\n" + row("frames/s of all streams", {"p50 ms", "p99 ms", "max ms"});
  for (const Json& trial : search.at("trials")) {
    const std::string line = row(rate(trial.at("frames_per_second")),
                                 {ms(trial.at("p50_ms")), ms(trial.at("p99_ms")), ms(trial.at("max_ms"))});
    const std::string failure = trial.at("failure");
    out += line.substr(0, line.size() - 1) + "  " + (failure.empty() ? "held" : failure) + "\n";
  }
  const std::string bound = "p99 of at most " + ms(search.at("p99_ms")) + " ms";
  if (search.at("frames_per_second").is_null()) return out + "no rate held a " + bound + "\n";
  return out + "highest rate with a " + bound + ": " + rate(search.at("frames_per_second")) +
         " frames/s of all streams; what follows is its trial\n";
}

std::string generations_text(const Json& outcome) {
  if (!outcome.contains("generations")) return "";
  std::string out = "\n" + row("generation of scenes", {"setup s", "answered", "p50 ms", "p99 ms", "max ms"});
  int generation = 0;
  for (const Json& run : outcome.at("generations"))
    out += row(std::to_string(++generation),
               {format_double("%.3g", run.at("setup_seconds").get<double>()), count(run.at("answered")),
                ms(run.at("p50_ms")), ms(run.at("p99_ms")), ms(run.at("max_ms"))});
  return out + "what follows is the last generation\n";
}

}  // namespace

std::string load_text(const Json& outcome) {
  const Json &load = outcome.at("load"), &input = outcome.at("input"), &scene = input.at("scene");
  const auto text = [&](const char* key) { return outcome.at(key).get<std::string>(); };
  std::string out = "collided " + text("version") + " on " + text("device") + ", tested from " + text("host") + ", " +
                    text("date") + "\n";
  out += plural(load.at("streams"), "stream") + " (" + plural(load.at("clients"), "client") + ", " +
         plural(load.at("scenes_per_client"), "scene") + " each) on " + plural(load.at("connections"), "connection") +
         ", window " + count(load.at("window")) + ", " + load.at("delivery").get<std::string>() + "\n";
  out += input.at("name").get<std::string>() + ": " + count(scene.at("triangles")) + " triangles, " +
         count(input.at("bytes_per_frame")) + " bytes a frame\n";
  if (load.at("loop") == "closed")
    return out +
           "closed loop: a frame is sent when an answer makes room for it, so that no queue beyond the window is "
           "seen\n";
  out += "open loop, " + load.at("arrivals").get<std::string>() + " arrivals";
  return out + (load.contains("frames_per_second_each") ? ": " + profile_text(load) : "") + "\n";
}

std::vector<std::pair<std::string, Json>> timed(const Json& outcome) {
  const bool is_open = outcome.at("load").at("loop") == "open";
  std::vector<std::pair<std::string, Json>> out;
  out.emplace_back(is_open ? "latency, from when due" : "latency", outcome.at("latency_ms"));
  if (is_open) out.emplace_back("service, from when sent", outcome.at("service_ms"));
  for (const auto& [name, times] : outcome.at("daemon_ms").items()) out.emplace_back("daemon: " + name, times);
  out.emplace_back("tester: sent late by", outcome.at("tester").at("delay_ms"));
  return out;
}

std::string outcome_text(const Json& outcome) {
  std::string out = load_text(outcome) + search_text(outcome) + generations_text(outcome) + times_text(outcome) +
                    counts_text(outcome) + tester_text(outcome.at("tester")) + comparison_text(outcome);
  for (const Json& warning : outcome.at("warnings")) out += "warning: " + warning.get<std::string>() + "\n";
  return out;
}

std::string second_text(const SeriesPoint& point) {
  const double seconds = std::max(point.end - point.begin, 1e-3);
  const auto per_second = [&](uint64_t frames) { return rate(static_cast<double>(frames) / seconds); };
  std::string out = format_double("%.0f s: ", point.end) + per_second(point.sent) + " sent/s, " +
                    per_second(point.answered) + " answered/s";
  if (point.answered > 0)
    out += ", p50 " + milliseconds_text(point.p50) + " ms, p99 " + milliseconds_text(point.p99) + " ms";
  if (point.skipped > 0) out += ", " + count_text(point.skipped) + " skipped";
  if (point.refused > 0) out += ", " + count_text(point.refused) + " refused";
  return out;
}

}  // namespace collided::cli::load
