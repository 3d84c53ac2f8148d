// What 'collidectl bench --end-to-end' makes of its times, and the sockets that it compares with.

#include <gtest/gtest.h>

#include "client/cli/echo_peer.hpp"
#include "client/cli/end_to_end_report.hpp"

namespace collided::cli {
namespace {

EndToEndRun sample() {
  EndToEndRun run;
  run.name = "funnel";
  run.scale = 0.5;
  run.scene.set_device("CPU, 2 threads");
  run.scene.set_triangle_count(18504);
  run.ways.push_back({.name = "grpc tcp", .frames = {}});
  for (int i = 1; i <= 100; ++i) {
    run.ways[0].frames.push_back({.latency = 10.0 + i, .engine = 10, .decode = 1, .encode = 2, .queue = 3});
    run.bare_tcp.push_back(0.5);
    run.bare_unix.push_back(i * 0.01);
    run.bytes_up.push_back(1200);
    run.bytes_down.push_back(i);
  }
  run.skipped.emplace_back("local socket", "it is off");
  return run;
}

TEST(EndToEnd, ARunTellsOverheadBesideBareSockets) {
  const Json run = end_to_end_json(sample());
  EXPECT_EQ(run["frames"], 100);
  EXPECT_EQ(run["bytes_up"], 1200);
  EXPECT_EQ(run["bytes_down"], 50.5);
  EXPECT_EQ(run["bare_ms"]["tcp"], (Json{{"p50", 0.5}, {"p99", 0.5}}));
  EXPECT_EQ(run["bare_ms"]["unix"]["p99"], 0.99);
  const Json& way = run["transports"][0];
  EXPECT_EQ(way["latency_ms"], (Json{{"p50", 60.5}, {"p99", 109}}));
  EXPECT_EQ(way["overhead_ms"], (Json{{"p50", 50.5}, {"p99", 99}}));
  EXPECT_EQ(way["overhead_to_bare_tcp"], 101);
  EXPECT_EQ(way["decode_ms"], 1);
  EXPECT_EQ(way["encode_ms"], 2);
  EXPECT_EQ(way["queue_ms"], 3);
}

TEST(EndToEnd, TheTableNamesEveryWayAndWhyOneIsLeftOut) {
  const std::string lines = end_to_end_lines(end_to_end_json(sample()));
  for (const char* part : {"funnel, scale 0.5: 18,504 triangles, 1,200 bytes up", "grpc tcp", "60.5", "101.00",
                           "bare unix", "local socket is left out: it is off"})
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

TEST(EchoPeer, TakesAndGivesAnySizes) {
  EchoPeer echo;
  for (const size_t up : {size_t{0}, size_t{1}, size_t{5'000'000}})
    for (const size_t down : {size_t{0}, size_t{3}, size_t{1'000'000}}) {
      EXPECT_GT(echo.tcp_ms(up, down), 0);
      EXPECT_GT(echo.unix_ms(up, down), 0);
    }
}

}  // namespace
}  // namespace collided::cli
