// The daemon's counters and limits.

#include <gtest/gtest.h>

#include "client/app/options/usage_error.hpp"
#include "client/measure/load/daemon/counters.hpp"
#include "client/measure/load/daemon/http_get.hpp"
#include "client/measure/load/daemon/limits.hpp"

namespace collided::cli::load {
namespace {

TEST(LoadCounters, SamplesAreReadByNameAndLabels) {
  const Samples samples = parse_samples(
      "# HELP collided_frames_total Frames\n# TYPE collided_frames_total counter\n"
      "collided_frames_total 12\n"
      "collided_rejected_total{reason=\"NOT FOUND\"} 3\n"
      "collided_frame_seconds_bucket{le=\"+Inf\"} 12\n"
      "collided_frame_seconds_sum 0.5e-1\n");
  EXPECT_EQ(samples.size(), 4U);
  EXPECT_EQ(samples.at("collided_rejected_total{reason=\"NOT FOUND\"}"), 3);
  EXPECT_EQ(samples.at("collided_frame_seconds_sum"), 0.05);
}

TEST(LoadCounters, ARunIsComparedWithWhatItAdded) {
  const Samples before = parse_samples("collided_frame_seconds_count 100\ncollided_frame_seconds_sum 9\n");
  const Samples after = parse_samples(
      "collided_frame_seconds_count 298\ncollided_frame_seconds_sum 9.396\n"
      "collided_rejected_total{reason=\"RESOURCE_EXHAUSTED\"} 7\n");
  Tally tally;
  tally.answered = 200;
  for (int i = 0; i < 200; ++i) tally.total.add(2);
  add(tally.refused, "RESOURCE_EXHAUSTED", "too many", 7);
  const Comparison comparison = compare(tally, growth(before, after));
  EXPECT_EQ(comparison.counts["answered"], (Json{{"tester", 200}, {"daemon", 198}}));
  EXPECT_EQ(comparison.counts["refused RESOURCE_EXHAUSTED"]["daemon"], 7);
  EXPECT_NEAR(comparison.counts["mean_frame_ms"]["daemon"].get<double>(), 2, 1e-9);
  EXPECT_NEAR(comparison.max_difference, 0.01, 1e-9);
  EXPECT_EQ(daemon_json(growth(before, after))["rejected"], (Json{{"RESOURCE_EXHAUSTED", 7}}));
}

TEST(LoadCounters, AddressesOfMetrics) {
  const auto words = [](const HttpUrl& url) { return url.host + " " + std::to_string(url.port) + " " + url.path; };
  EXPECT_EQ(words(parse_url("--metrics-url", "http://127.0.0.1:9464/metrics")), "127.0.0.1 9464 /metrics");
  EXPECT_EQ(words(parse_url("--metrics-url", "host:80")), "host 80 /metrics");
  EXPECT_EQ(words(parse_url("--metrics-url", "http://[::1]:80/m")), "::1 80 /m");
  for (const char* bad : {"", "host", "http://host/metrics", "https://host:1/metrics", ":80", "host:"})
    EXPECT_THROW(parse_url("--metrics-url", bad), UsageError) << bad;
}

TEST(LoadLimits, EachThatIsTooLowIsNamedWithTheValueThatIsNeeded) {
  v1::ServerLimits limits;
  limits.set_max_scenes(64);
  limits.set_max_scenes_per_client(16);
  limits.set_max_streams(256);
  limits.set_max_streams_per_client(64);
  limits.set_max_window(16);
  EXPECT_TRUE(limits_in_the_way(limits, {.clients = 4, .scenes = 4}).empty());
  const std::string text = explain(limits_in_the_way(limits, {.clients = 10, .scenes = 10, .window = 17}));
  EXPECT_EQ(text,
            "the daemon's limits are too low for this load: --max-scenes 64, --max-scenes-per-client 16, "
            "--max-streams-per-client 64, --max-window 16; start it with --max-scenes 100 --max-scenes-per-client 100 "
            "--max-streams-per-client 100 --max-window 17, or ask for fewer --clients, --scenes or a smaller --window");
}

TEST(LoadLimits, ARateThatWillBeRefusedInPartIsTold) {
  v1::ServerLimits limits;
  limits.set_max_frames_per_second(1000);
  EXPECT_EQ(rate_warning(limits, 1000), "");
  EXPECT_NE(rate_warning(limits, 1001).find("--max-frames-per-second"), std::string::npos);
}

}  // namespace
}  // namespace collided::cli::load
