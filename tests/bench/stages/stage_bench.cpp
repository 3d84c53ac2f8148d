// Single stages and kernels of the engine on one CPU core, on the data of a step of a scene, by Google Benchmark.

#include "tests/bench/stages/stage_bench.hpp"

#include <CLI/CLI.hpp>
#include <iostream>

#include "tests/bench/inputs.hpp"

namespace collided::test {
namespace {

struct Options {
  std::string scene = "flamenco";
  double scale = 1;
};

void add_options(CLI::App& app, Options& o) {
  app.add_option("--scene", o.scene, "Procedural scene, or real frames of the data folder (COLLIDED_DATA)")
      ->capture_default_str();
  app.add_option("--scale", o.scale, "Refines the grids")->check(CLI::PositiveNumber)->capture_default_str();
}

constexpr const char* kWhat =
    "Single stages and kernels of the engine on one CPU core, on the data of a step of a scene";

/// Google Benchmark answers --help, before anyone else sees the command line.
void print_help() {
  CLI::App app(kWhat, "collided_stage_bench");
  Options defaults;
  add_options(app, defaults);
  std::cout << app.help() << "\nand Google Benchmark's:\n";
  benchmark::PrintDefaultHelp();
}

void run(const Options& o) {
  const std::vector<BenchInput> inputs = bench_inputs(o.scene, o.scale);
  if (o.scene.empty() || inputs.empty()) throw std::invalid_argument("no scene is called \"" + o.scene + "\"");
  StageScene scene(o.scene, inputs.front().at(3, 5));
  benchmark::AddCustomContext("scene", o.scene + ", " + std::to_string(scene.triangles()) + " triangles");
  register_queries(scene);
  register_octree(scene);
  register_pairs(scene);
  register_hierarchy(scene);
  register_frame(scene);
  register_sorts();
  benchmark::RunSpecifiedBenchmarks();
}

}  // namespace
}  // namespace collided::test

int main(int argc, char** argv) {
  using namespace collided::test;
  benchmark::Initialize(&argc, argv, print_help);
  CLI::App app(kWhat);
  Options options;
  add_options(app, options);
  CLI11_PARSE(app, argc, argv);
  try {
    run(options);
    return 0;
  } catch (const std::exception& e) {
    std::cerr << "collided_stage_bench: " << e.what() << "\n";
    return 1;
  }
}
