// How 'collidectl bench --end-to-end' reports its times.

#include "client/measure/end_to_end/report.hpp"

#include <gtest/gtest.h>

namespace collided::cli {
namespace {

EndToEndRun sample() {
  EndToEndRun run;
  run.name = "funnel";
  run.scale = 0.5;
  run.scene.set_device("CPU, 2 threads");
  run.scene.set_triangle_count(18504);
  run.transports.push_back({.name = "grpc tcp", .frames = {}});
  for (int i = 1; i <= 100; ++i) {
    run.transports[0].frames.push_back({.latency = 10.0 + i, .engine = 10, .decode = 1, .encode = 2, .queue = 3});
    run.bare.tcp.push_back(0.5);
    run.bare.unix_stream.push_back(i * 0.01);
    run.held.tcp.push_back(2.5);
    run.held.unix_stream.push_back(0.7);
    run.held_control.push_back(0.1);
    run.bytes_up.push_back(1200);
    run.bytes_down.push_back(i);
  }
  return run;
}

TEST(EndToEnd, ARunTellsOverheadAndBareSockets) {
  const Json run = end_to_end_json(sample());
  EXPECT_EQ(run["frames"], 100);
  EXPECT_EQ(run["bytes_in"], 1200);
  EXPECT_EQ(run["bytes_out"], 50.5);
  EXPECT_EQ(run["bare_ms"]["tcp"], (Json{{"p50", 0.5}, {"p99", 0.5}}));
  EXPECT_EQ(run["bare_ms"]["unix"]["p99"], 0.99);
  EXPECT_EQ(run["bare_ms"]["unix, held"]["p50"], 0.7);
  EXPECT_EQ(run["bare_ms"]["few bytes, held"]["p50"], 0.1);
  const Json& transport = run["transports"][0];
  EXPECT_EQ(transport["latency_ms"], (Json{{"p50", 60.5}, {"p99", 109}}));
  EXPECT_EQ(transport["overhead_ms"], (Json{{"p50", 50.5}, {"p99", 99}}));
  EXPECT_EQ(transport["overhead_to_bare_tcp"], 101);
  EXPECT_EQ(transport["overhead_to_held_tcp"], 20.2);
  EXPECT_EQ(transport["decode_ms"], 1);
  EXPECT_EQ(transport["encode_ms"], 2);
  EXPECT_EQ(transport["queue_ms"], 3);
}

TEST(EndToEnd, TheTableNamesEveryTransport) {
  const std::string lines = end_to_end_lines(end_to_end_json(sample()));
  for (const char* part : {"funnel, scale 0.5: 18,504 triangles, 1,200 bytes up", "grpc tcp", "60.5", "101.00", "20.20",
                           "bare unix", "bare tcp, held", "bare few bytes, held"})
    EXPECT_NE(lines.find(part), std::string::npos) << part << " in\n" << lines;
}

TEST(EndToEnd, TheEnginesTimeIsTheDaemonsOwn) {
  v1::FrameMetrics metrics;
  for (const double ms : {1, 2}) metrics.add_stages()->set_milliseconds(ms);
  EXPECT_EQ(frame_time(5, metrics).engine, 3);
  metrics.set_engine_milliseconds(4);
  metrics.set_decode_milliseconds(0.5);
  EXPECT_EQ(frame_time(5, metrics).engine, 4);
  EXPECT_EQ(frame_time(5, metrics).decode, 0.5);
}

}  // namespace
}  // namespace collided::cli
