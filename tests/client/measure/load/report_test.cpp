// What a load's report says.

#include <gtest/gtest.h>

#include "client/measure/load/report/chart.hpp"
#include "client/measure/load/report/html.hpp"
#include "client/measure/load/report/outcome.hpp"
#include "client/measure/load/report/text.hpp"

namespace collided::cli::load {
namespace {

LoadSettings open_loop() {
  LoadSettings settings;
  settings.pace.profile.emplace(100, 3);
  return settings;
}

/// 300 frames, the n-th of which takes n milliseconds.
Outcome sample() {
  Outcome outcome;
  outcome.input = "<funnel> & co";
  outcome.version = "1.2.3", outcome.host = "lab", outcome.date = "2026-11-27T16:00:00Z";
  outcome.scene.set_device("some GPU");
  outcome.connections = 1;
  outcome.threads = 2;
  Tally& tally = outcome.result.tally;
  for (int i = 1; i <= 300; ++i) {
    tally.latency.add(i);
    tally.service.add(i / 2.0);
    tally.total.add(1);
    tally.delay.add(0.01);
  }
  tally.sent = tally.answered = 300;
  outcome.result.seconds = 3;
  outcome.result.cost = {.cpu_seconds = 0.03, .busiest_thread = 0.01};
  for (int i = 0; i < 3; ++i)
    outcome.result.series.push_back(
        {.begin = 1.0 * i, .end = 1.0 + i, .sent = 100, .answered = 100, .p50 = 50, .p99 = 99, .max = 100});
  outcome.counted += tally;
  return outcome;
}

TEST(LoadReport, JsonHasPercentilesThroughputAndTheTestersOwnCost) {
  const Json json = outcome_json(open_loop(), sample());
  EXPECT_NEAR(json["latency_ms"]["p99"].get<double>(), 297, 0.3);
  EXPECT_NEAR(json["service_ms"]["p50"].get<double>(), 75, 0.1);
  EXPECT_EQ(json["latency_ms"]["max"], 300);
  EXPECT_EQ(json["frames"]["answered"], 300);
  EXPECT_EQ(json["throughput"]["frames_per_second"], 100);
  EXPECT_DOUBLE_EQ(json["tester"]["cpu_ms_per_frame"].get<double>(), 0.1);
  EXPECT_EQ(json["series"].size(), 3U);
  EXPECT_EQ(json["latency_curve"].back(), (Json{100, 300}));
  EXPECT_EQ(json["load"]["loop"], "open");
  EXPECT_EQ(json["warnings"], Json::array());
}

TEST(LoadReport, EveryFormSaysWhatWasMeasuredWhereAndWhen) {
  const Json json = outcome_json(open_loop(), sample());
  EXPECT_EQ((std::vector<std::string>{json["version"], json["host"], json["device"], json["date"]}),
            (std::vector<std::string>{"1.2.3", "lab", "some GPU", "2026-11-27T16:00:00Z"}));
  const std::string said = "collided 1.2.3 on some GPU, tested from lab, 2026-11-27T16:00:00Z";
  EXPECT_TRUE(outcome_text(json).starts_with(said + "\n")) << outcome_text(json);
  EXPECT_NE(outcome_html(json).find(said), std::string::npos);
}

TEST(LoadReport, AClosedLoopSaysWhatItCannotShow) {
  LoadSettings settings;
  const std::string text = outcome_text(outcome_json(settings, sample()));
  EXPECT_NE(text.find("no queue beyond the window is seen"), std::string::npos) << text;
  EXPECT_EQ(text.find("from when sent"), std::string::npos) << text;
}

TEST(LoadReport, WarnsOfASlowTesterOfEndedStreamsAndOfOtherCounts) {
  Outcome outcome = sample();
  outcome.result.cost.busiest_thread = 0.9;
  for (int i = 0; i < 10; ++i) outcome.result.tally.delay.add(100);
  add(outcome.result.ended, "UNAVAILABLE", "gone");
  outcome.daemon = Samples{{"collided_frame_seconds_count", 310}, {"collided_frame_seconds_sum", 0.31}};
  const std::vector<std::string> warnings = warnings_of(open_loop(), outcome);
  ASSERT_EQ(warnings.size(), 4U);
  EXPECT_EQ(warnings[0], "1 of 1 streams ended early: UNAVAILABLE: gone");
  EXPECT_NE(warnings[1].find("90 %"), std::string::npos);
  EXPECT_NE(warnings[2].find("100 ms late"), std::string::npos);
  EXPECT_NE(warnings[3].find("3.2 %"), std::string::npos) << warnings[3];
}

TEST(LoadReport, APageNeedsNoOtherFileAndEscapesWhatItShows) {
  const std::string page = outcome_html(outcome_json(open_loop(), sample()));
  EXPECT_NE(page.find("&lt;funnel&gt; &amp; co"), std::string::npos);
  for (const char* part : {"Latency by percentile", "Frames a second", "prefers-color-scheme: dark", "p99.99"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  for (const char* other : {"http:", "https:", "src=", "href=", "<script", "nan,", ">nan"})
    EXPECT_EQ(page.find(other), std::string::npos) << other;
}

TEST(LoadReport, TrialsAreShownWithTheHighestRate) {
  LoadSettings settings;
  settings.find_max.p99_ms = 5;
  Outcome outcome = sample();
  outcome.trials = {{.rate = 10, .failure = "", .p50 = 1, .p99 = 2, .max = 3, .answered = 20},
                    {.rate = 20, .failure = "p99 too high", .p50 = 1, .p99 = 9, .max = 30, .answered = 40}};
  outcome.best = 10;
  const Json json = outcome_json(settings, outcome);
  EXPECT_EQ(json["find_max"]["frames_per_second"], 10);
  EXPECT_EQ(json["find_max"]["trials"][1]["held"], false);
  EXPECT_NE(outcome_text(json).find("highest rate with a p99 of at most 5 ms: 10 frames/s"), std::string::npos);
  EXPECT_NE(outcome_html(json).find("bound, 5 ms"), std::string::npos);
}

TEST(LoadReport, AxesEndAtRoundNumbers) {
  const Axis linear = linear_axis("", 230);
  EXPECT_EQ(linear.max, 250);
  EXPECT_EQ(linear.ticks[1].text, "50");
  const Axis log = log_ms_axis("", 0.3, 1500);
  EXPECT_EQ(log.ticks.front().text, "100 us");
  EXPECT_EQ(log.ticks.back().text, "10 s");
}

}  // namespace
}  // namespace collided::cli::load
