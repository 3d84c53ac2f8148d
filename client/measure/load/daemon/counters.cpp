// The daemon's own counters before and after a run, beside what the tester counted.

#include "client/measure/load/daemon/counters.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <sstream>

namespace collided::cli::load {

namespace {

constexpr const char *kFrames = "collided_frame_seconds_count", *kSkipped = "collided_skipped_frames_total";
constexpr const char* kPhases[] = {"queue", "decode", "upload", "compute", "download", "encode"};

double value_of(const Samples& samples, const std::string& name) {
  const auto at = samples.find(name);
  return at == samples.end() ? 0 : at->second;
}

int64_t count_of(const Samples& samples, const std::string& name) { return std::llround(value_of(samples, name)); }

std::string rejected_name(const std::string& code) { return "collided_rejected_total{reason=\"" + code + "\"}"; }

/// Of a histogram in seconds, with its labels.
double mean_ms(const Samples& samples, const std::string& name, const std::string& labels = "") {
  const double count = value_of(samples, name + "_count" + labels);
  return count > 0 ? 1000 * value_of(samples, name + "_sum" + labels) / count : 0;
}

Json rejected_json(const Samples& growth) {
  const std::string before = rejected_name(""), head = before.substr(0, before.size() - 2);
  Json out = Json::object();
  for (const auto& [name, value] : growth)
    if (name.starts_with(head)) out[name.substr(head.size(), name.size() - head.size() - 2)] = std::llround(value);
  return out;
}

}  // namespace

Samples parse_samples(const std::string& text) {
  Samples samples;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    const size_t space = line.rfind(' ');
    if (line.empty() || line[0] == '#' || space == std::string::npos) continue;
    samples[line.substr(0, space)] = std::strtod(line.c_str() + space, nullptr);
  }
  return samples;
}

Samples growth(const Samples& before, const Samples& after) {
  Samples out;
  for (const auto& [name, value] : after)
    if (const double added = value - value_of(before, name); added != 0) out[name] = added;
  return out;
}

Json daemon_json(const Samples& growth) {
  Json phases = Json::object();
  for (const char* phase : kPhases)
    phases[phase] = mean_ms(growth, "collided_phase_seconds", std::string("{phase=\"") + phase + "\"}");
  return {{"answered", count_of(growth, kFrames)},
          {"skipped", count_of(growth, kSkipped)},
          {"rejected", rejected_json(growth)},
          {"mean_frame_ms", mean_ms(growth, "collided_frame_seconds")},
          {"mean_phase_ms", phases}};
}

Comparison compare(const Tally& tally, const Samples& growth) {
  Comparison out;
  const auto add = [&](const std::string& name, auto tester, auto daemon) {
    const auto a = static_cast<double>(tester), b = static_cast<double>(daemon);
    if (a == 0 && b == 0) return;
    out.max_difference = std::max(out.max_difference, std::abs(a - b) / std::max(a, b));
    out.counts[name] = {{"tester", tester}, {"daemon", daemon}};
  };
  add("answered", tally.answered + tally.late, count_of(growth, kFrames));
  add("skipped", tally.skipped, count_of(growth, kSkipped));
  for (const auto& [code, refusals] : tally.refused)
    add("refused " + code, refusals.count, count_of(growth, rejected_name(code)));
  add("mean_frame_ms", tally.total.mean(), mean_ms(growth, "collided_frame_seconds"));
  return out;
}

}  // namespace collided::cli::load
