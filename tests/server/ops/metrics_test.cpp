// The metrics, checked by Prometheus's own promtool.
#include "server/ops/metrics.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

namespace collided::server {
namespace {

void expect_line(const Metrics& metrics, const std::string& line) {
  const auto text = metrics.text();
  EXPECT_NE(("\n" + text).find("\n" + line + "\n"), std::string::npos) << line << " is not in\n" << text;
}

size_t count_of(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

void fill(Metrics& metrics) {
  metrics.observe_phase(Phase::kQueue, 60e-6);
  metrics.observe_phase(Phase::kEncode, 2);
  metrics.observe_stage("narrow", 3e-3);
  metrics.count_frame({.seconds = 0.01, .contacts = 5, .bytes_in = 100, .bytes_out = 200, .replays = 1});
  metrics.count_engine("lbvh", "faster");
  metrics.count(CounterId::kSkippedFrames, 3);
  metrics.count_rejected("INVALID_ARGUMENT");
  metrics.count(CounterId::kReconnects);
  metrics.count_call("CreateScene", "OK");
  metrics.count_call("CreateScene", "OK");
  metrics.set_gauges([] {
    return Gauges{.scenes = 2,
                  .streams = 3,
                  .calls = 6,
                  .device_bytes = 4,
                  .queued_frames = 5,
                  .max_scenes = 7,
                  .max_streams = 8,
                  .max_device_bytes = 9,
                  .is_ready = true};
  });
}

TEST(Metrics, CountWhatHappened) {
  Metrics metrics;
  fill(metrics);
  for (const auto* line : {"collided_frames_total 1",
                           "collided_contacts_total 5",
                           "collided_received_bytes_total 100",
                           "collided_sent_bytes_total 200",
                           "collided_replays_total 1",
                           "collided_skipped_frames_total 3",
                           "collided_rejected_total{reason=\"INVALID_ARGUMENT\"} 1",
                           "collided_reconnects_total 1",
                           "collided_calls_total{code=\"OK\",method=\"CreateScene\"} 2",
                           "collided_broad_phase_frames_total{engine=\"lbvh\",reason=\"faster\"} 1",
                           "collided_scenes 2",
                           "collided_streams 3",
                           "collided_calls_in_work 6",
                           "collided_device_bytes 4",
                           "collided_queued_frames 5",
                           "collided_outgoing_bytes 0",
                           "collided_max_scenes 7",
                           "collided_max_streams 8",
                           "collided_max_device_bytes 9",
                           "collided_ready 1",
                           "collided_phase_seconds_bucket{phase=\"queue\",le=\"5e-05\"} 0",
                           "collided_phase_seconds_bucket{phase=\"queue\",le=\"0.0001\"} 1",
                           "collided_phase_seconds_bucket{phase=\"encode\",le=\"1\"} 0",
                           "collided_phase_seconds_bucket{phase=\"encode\",le=\"+Inf\"} 1",
                           "collided_phase_seconds_sum{phase=\"encode\"} 2",
                           "collided_phase_seconds_count{phase=\"decode\"} 0",
                           "collided_stage_seconds_count{stage=\"narrow\"} 1",
                           "collided_frame_seconds_count 1",
                           "collided_build_info{version=\"" COLLIDED_VERSION "\"} 1"})
    expect_line(metrics, line);
}

TEST(Metrics, GaugesAreThoseOfTheScrape) {
  Metrics metrics;
  uint64_t scenes = 1;
  metrics.set_gauges([&] { return Gauges{.scenes = scenes}; });
  expect_line(metrics, "collided_scenes 1");
  scenes = 9;
  expect_line(metrics, "collided_scenes 9");
  metrics.set_gauges({});
  expect_line(metrics, "collided_scenes 0");
}

TEST(Metrics, NamesWithoutEndShareOne) {
  Metrics metrics;
  for (int i = 0; i < 1000; ++i) {
    metrics.observe_stage("stage" + std::to_string(i), 1e-3);
    metrics.count_rejected("reason" + std::to_string(i));
    metrics.count_call("method" + std::to_string(i), "OK");
  }
  const auto text = metrics.text();
  EXPECT_EQ(count_of(text, "\ncollided_stage_seconds_count"), 65u);
  expect_line(metrics, "collided_stage_seconds_count{stage=\"other\"} 936");
  expect_line(metrics, "collided_rejected_total{reason=\"other\"} 968");
  EXPECT_EQ(count_of(text, "\ncollided_calls_total"), 513u);
  expect_line(metrics, "collided_calls_total{code=\"other\",method=\"other\"} 488");
}

TEST(Metrics, HostileNamesAreEscaped) {
  Metrics metrics;
  metrics.count_call("a\"\nb", "");
  metrics.count_call("", "");
  expect_line(metrics, "collided_calls_total{code=\"\",method=\"a\\\"\\nb\"} 1");
}

TEST(Metrics, ThreadsCountTogether) {
  Metrics metrics;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (int i = 0; i < 500; ++i) {
        metrics.observe_stage(i % 2 ? "odd" : "even", 1e-3);
        metrics.count_frame({});
        if (i % 100 == 0) metrics.text();
      }
    });
  for (auto& thread : threads) thread.join();
  expect_line(metrics, "collided_frames_total 2000");
  expect_line(metrics, "collided_stage_seconds_count{stage=\"odd\"} 1000");
}

TEST(Metrics, PromtoolHasNothingToSay) {
  if (!std::filesystem::exists(COLLIDED_PROMTOOL)) GTEST_SKIP() << "promtool is not installed";
  Metrics metrics;
  fill(metrics);
  const auto path = std::filesystem::temp_directory_path() / ("collided-metrics-" + std::to_string(getpid()));
  std::ofstream(path) << metrics.text();
  FILE* tool = popen((std::string(COLLIDED_PROMTOOL) + " check metrics <" + path.string() + " 2>&1").c_str(), "r");
  ASSERT_NE(tool, nullptr);
  std::string said(4096, '\0');
  said.resize(fread(said.data(), 1, said.size(), tool));
  EXPECT_EQ(pclose(tool), 0);
  EXPECT_EQ(said, "");
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace collided::server
