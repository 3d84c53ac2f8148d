// The engine's broad phase on the CPU against Embree's: the same boxes, the same threads, in turn in one run.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <limits>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/bench/embree/embree_match.hpp"
#include "tests/bench/inputs.hpp"
#include "tests/bench/report.hpp"
#include "tests/support/frames/real_frames.hpp"

namespace collided::test {
namespace {

struct Options {
  std::string scene = kBallFrames.name, date, commit;
  double scale = 1;
  int rounds = 11;
  int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  bool json = false;
};

void add_options(CLI::App& app, Options& o) {
  app.footer(
      "Without --scene: the real frames cloth_ball_92_93 of the data folder (COLLIDED_DATA). A procedural scene is\n"
      "taken at t = 0.8. Exit status 1 if the two do not find equally many pairs.");
  app.add_option("--scene", o.scene, "Scene")->capture_default_str();
  app.add_option("--scale", o.scale, "Refines the grids of a procedural scene")->capture_default_str();
  app.add_option("--rounds", o.rounds, "Runs of each contender")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--threads", o.threads, "Of both")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_flag("--json", o.json, "Print JSON");
  app.add_option("--date", o.date, "Recorded in the result");
  app.add_option("--commit", o.commit, "Recorded in the result");
}

double least(const std::vector<double>& values) { return *std::min_element(values.begin(), values.end()); }

/// Median of the faster of Embree's builds: the base of every ratio.
double best_embree(const Match& match) {
  double best = std::numeric_limits<double>::infinity();
  for (const Contender& c : match.contenders)
    if (c.is_embree) best = std::min(best, median(c.ms));
  return best;
}

void print_text(const Options& o, const Match& m) {
  std::printf("%s: %llu triangles, %d threads, %d rounds; milliseconds, ratio to the faster Embree\n", o.scene.c_str(),
              static_cast<unsigned long long>(m.triangles), o.threads, o.rounds);
  for (const Contender& c : m.contenders) {
    if (c.ms.empty()) {
      std::printf("%-30s not available\n", c.name.c_str());
      continue;
    }
    std::printf("%-30s median %9.2f  min %9.2f  ratio %5.2f", c.name.c_str(), median(c.ms), least(c.ms),
                median(c.ms) / best_embree(m));
    if (c.is_embree) std::printf("  of it build %8.2f", median(c.build_ms));
    std::printf("\n");
  }
  const auto number = [](uint64_t n) { return std::to_string(n); };
  std::cout << "pairs: Embree " << number(m.embree_pairs) << ", " << number(m.embree_pairs_apart)
            << " of them share no vertex; collided " << number(m.engine_pairs) << ", listed "
            << (m.lists_pairs ? number(m.listed_pairs) : "not available") << ": "
            << (m.agrees() ? "they agree" : "THEY DO NOT AGREE") << "\ncandidates: " << number(m.candidates_vt)
            << " VT, " << number(m.candidates_ee) << " EE\n";
}

void print_json(const Options& o, const Match& m) {
  nlohmann::ordered_json out = {{"date", o.date},          {"commit", o.commit},   {"scene", o.scene},
                                {"scale", o.scale},        {"threads", o.threads}, {"rounds", o.rounds},
                                {"triangles", m.triangles}};
  for (const Contender& c : m.contenders) {
    if (c.ms.empty()) {
      out["contenders"].push_back({{"name", c.name}, {"available", false}});
      continue;
    }
    out["contenders"].push_back({{"name", c.name},
                                 {"available", true},
                                 {"median_ms", median(c.ms)},
                                 {"min_ms", least(c.ms)},
                                 {"ratio_to_best_embree", median(c.ms) / best_embree(m)}});
    if (c.is_embree) out["contenders"].back()["build_ms"] = median(c.build_ms);
  }
  out["pairs"] = {{"embree", m.embree_pairs}, {"embree_apart", m.embree_pairs_apart}, {"engine", m.engine_pairs}};
  if (m.lists_pairs) out["pairs"]["engine_listed"] = m.listed_pairs;
  out["candidates"] = {{"vt", m.candidates_vt}, {"ee", m.candidates_ee}};
  out["agree"] = m.agrees();
  std::cout << out.dump(2) << "\n";
}

int run(const Options& o) {
  if (o.scene == kBallFrames.name && !are_here(kBallFrames)) {
    std::cerr << "skipped: there is no data folder (COLLIDED_DATA) with " << o.scene << "; try --scene\n";
    return 0;
  }
  const std::vector<BenchInput> inputs = bench_inputs(o.scene, o.scale);
  if (inputs.empty()) throw std::invalid_argument("no scene is called " + o.scene);
  const Match match = run_match(inputs.front().at(3, 5), o.rounds, o.threads);
  o.json ? print_json(o, match) : print_text(o, match);
  return match.agrees() ? 0 : 1;
}

}  // namespace
}  // namespace collided::test

int main(int argc, char** argv) {
  using namespace collided::test;
  CLI::App app("The engine's broad phase on the CPU against Embree's: the same boxes and threads, in turn");
  Options options;
  add_options(app, options);
  CLI11_PARSE(app, argc, argv);
  try {
    return run(options);
  } catch (const std::exception& e) {
    std::cerr << "collided_embree_bench: " << e.what() << "\n";
    return 2;
  }
}
