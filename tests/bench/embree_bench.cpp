// The engine's broad phase on the CPU against Embree's: the same boxes, the same threads, in turn in one run.

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <limits>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/bench/embree_match.hpp"
#include "tests/bench/inputs.hpp"
#include "tests/bench/report.hpp"
#include "tests/support/data_folder.hpp"

namespace collided::test {
namespace {

constexpr const char* kUsage =
    "usage: collided_embree_bench [--scene NAME] [--scale S] [--rounds N] [--threads N] [--json]\n"
    "                             [--date TEXT] [--commit TEXT]\n"
    "Without --scene: the real frames cloth_ball_92_93 of the data folder (COLLIDED_DATA). A procedural scene is\n"
    "taken at t = 0.8. Exit status 1 if the two do not find equally many pairs.\n";

struct Options {
  std::string scene = kBallFrames.name, date, commit;
  double scale = 1;
  int rounds = 11;
  int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  bool json = false;
};

void set_option(Options& o, const std::string& option, const std::string& value) {
  if (option == "--scene")
    o.scene = value;
  else if (option == "--scale")
    o.scale = std::stod(value);
  else if (option == "--rounds")
    o.rounds = std::stoi(value);
  else if (option == "--threads")
    o.threads = std::stoi(value);
  else if (option == "--date")
    o.date = value;
  else if (option == "--commit")
    o.commit = value;
  else
    throw std::invalid_argument("unknown option " + option);
}

Options parse(int argc, char** argv) {
  Options o;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--json") {
      o.json = true;
      continue;
    }
    if (i + 1 == argc) throw std::invalid_argument(option + " is not known, or needs a value");
    set_option(o, option, argv[++i]);
  }
  if (o.rounds < 1 || o.threads < 1) throw std::invalid_argument("--rounds and --threads must be at least 1");
  return o;
}

double least(const std::vector<double>& values) { return *std::min_element(values.begin(), values.end()); }

/// Median of the faster of Embree's builds: what every ratio is to.
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
  if (o.scene == kBallFrames.name && !data_folder()) {
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
  try {
    return run(parse(argc, argv));
  } catch (const std::invalid_argument& e) {
    std::cerr << e.what() << "\n" << kUsage;
    return 2;
  } catch (const std::exception& e) {
    std::cerr << "collided_embree_bench: " << e.what() << "\n";
    return 1;
  }
}
