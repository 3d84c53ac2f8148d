// How 'collidectl bench' reports the metrics.

#include "client/measure/bench/report.hpp"

#include <gtest/gtest.h>

#include <set>

namespace collided::cli {
namespace {

v1::FrameMetrics step(double ms, v1::BroadPhaseEngine engine, uint32_t allocations) {
  v1::FrameMetrics out;
  out.set_step_milliseconds(ms);
  out.set_broad_phase_engine(engine);
  out.set_allocations(allocations);
  out.set_graph_launches(2);
  out.set_replays(1);
  out.set_total_milliseconds(1000);
  v1::StageTime& stage = *out.add_stages();
  stage.set_stage("boxes");
  stage.set_milliseconds(ms / 2);
  out.mutable_counts()->set_tests(static_cast<uint64_t>(ms));
  out.mutable_counts()->set_candidates_edge_edge(1234567);
  out.mutable_counts()->set_contacts_vertex_triangle(7);
  return out;
}

BenchRun sample() {
  BenchRun run;
  run.name = "funnel";
  run.scene.set_device("CPU, 2 threads");
  run.scene.set_triangle_count(18504);
  run.scene.mutable_spec()->set_backend(v1::BACKEND_CPU);
  run.scene.mutable_spec()->set_accuracy(v1::ACCURACY_CERTIFIED);
  for (const uint64_t bytes : {1000, 234}) run.scene.add_memory()->set_bytes(bytes);
  for (int i = 1; i <= 40; ++i)
    run.steps.push_back(step(i, i < 40 ? v1::BROAD_PHASE_ENGINE_OCTREE : v1::BROAD_PHASE_ENGINE_LBVH, i == 1 ? 4 : 0));
  return run;
}

std::vector<std::string> keys(const Json& object) {
  std::vector<std::string> out;
  for (const auto& [name, value] : object.items()) out.push_back(name);
  return out;
}

TEST(Bench, ARunTellsTimesCountsAndMemory) {
  const Json run = run_json(sample());
  EXPECT_EQ(keys(run), (std::vector<std::string>{"scene", "triangles", "backend", "device", "engine", "accuracy",
                                                 "steps", "step_ms", "stage_ms", "counts", "device_bytes",
                                                 "allocations_per_step", "graph_launches_per_step"}));
  EXPECT_EQ(run["scene"], "funnel");
  EXPECT_EQ(run["triangles"], 18504);
  EXPECT_EQ(run["backend"], "cpu");
  EXPECT_EQ(run["engine"], "auto");
  EXPECT_EQ(run["accuracy"], "certified");
  EXPECT_EQ(run["steps"], 40);
  EXPECT_EQ(run["step_ms"], (Json{{"median", 20.5}, {"p95", 38}, {"min", 1}}));
  EXPECT_EQ(run["stage_ms"], (Json{{"boxes", 10.25}}));
  EXPECT_EQ(run["device_bytes"], 1234);
  EXPECT_EQ(run["allocations_per_step"], 0.1);
  EXPECT_EQ(run["graph_launches_per_step"], 2);
}

TEST(Bench, CountsAreThoseOfTheLastStepUnderTheProtocolsNames) {
  const Json counts = run_json(sample())["counts"];
  const std::set<std::string> names{"cells",
                                    "leaves",
                                    "top_level",
                                    "base_level",
                                    "registrations",
                                    "tests",
                                    "pairs",
                                    "candidates_vertex_triangle",
                                    "candidates_edge_edge",
                                    "contacts_vertex_triangle",
                                    "contacts_edge_edge",
                                    "contacts_triangle_triangle",
                                    "contacts_edge_triangle",
                                    "contacts_vertex_solid",
                                    "survivors_vertex_triangle",
                                    "survivors_edge_edge",
                                    "exact_decisions",
                                    "inside_out",
                                    "replays",
                                    "steps_by_engine"};
  const std::vector<std::string> found = keys(counts);
  EXPECT_EQ(std::set<std::string>(found.begin(), found.end()), names);
  EXPECT_EQ(counts["tests"], 40);
  EXPECT_EQ(counts["candidates_edge_edge"], 1234567);
  EXPECT_EQ(counts["contacts_vertex_triangle"], 7);
  EXPECT_EQ(counts["replays"], 40);
  EXPECT_EQ(counts["steps_by_engine"], (Json{{"octree", 39}, {"lbvh", 1}}));
}

TEST(Bench, AFileHasOneShapeForOneRunAndForMore) {
  for (const size_t count : {1, 3}) {
    const Json file = bench_json(std::vector<BenchRun>(count, sample()), 10, 0.5);
    EXPECT_EQ(keys(file), (std::vector<std::string>{"device", "settings", "runs"}));
    EXPECT_EQ(file["device"], "CPU, 2 threads");
    EXPECT_EQ(file["settings"]["warm_up"], 10);
    EXPECT_EQ(file["settings"]["scale"], 0.5);
    EXPECT_EQ(file["settings"]["position_format"], "f32");
    EXPECT_EQ(file["runs"].size(), count);
    EXPECT_EQ(file["runs"].back(), run_json(sample()));
  }
}

TEST(Bench, TheTableShowsTimesStagesAndCounts) {
  const std::string lines = bench_lines(run_json(sample()));
  for (const char* part :
       {"funnel", "auto (octree, lbvh)", "18,504", "20.5", "stages, ms: boxes 10.2", "contacts_vertex_triangle 7",
        "candidates_edge_edge 1,234,567", "device_bytes 1,234", "allocations_per_step 0.1"})
    EXPECT_NE(lines.find(part), std::string::npos) << part << " in\n" << lines;
  EXPECT_EQ(bench_head().size(), lines.find('\n') + 1);
}

TEST(Bench, AnEngineThatWasAskedForIsNamedOnce) {
  BenchRun run = sample();
  run.steps.pop_back();
  run.scene.mutable_spec()->set_broad_phase_engine(v1::BROAD_PHASE_ENGINE_OCTREE);
  EXPECT_EQ(bench_lines(run_json(run)).find('('), std::string::npos);
}

}  // namespace
}  // namespace collided::cli
