#include "client/cli/live/table.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace collided::cli {
namespace {

using std::chrono::milliseconds;

client::WatchedFrame frame(uint64_t id, double total_ms, uint64_t contacts, uint64_t skipped = 0) {
  client::WatchedFrame out;
  out.frame_id = id;
  out.skipped_frames = skipped;
  out.done.set_contact_count(contacts);
  v1::FrameMetrics& metrics = *out.done.mutable_metrics();
  metrics.set_total_milliseconds(total_ms);
  v1::StageTime& stage = *metrics.add_stages();
  stage.set_stage("search");
  stage.set_milliseconds(total_ms / 2);
  metrics.mutable_counts()->set_contacts_vertex_triangle(contacts);
  return out;
}

v1::SceneSpec spec_of(v1::Report report, v1::DetectionMode mode = v1::DETECTION_MODE_CCD) {
  v1::SceneSpec spec;
  spec.set_report(report);
  spec.set_mode(mode);
  return spec;
}

/// Frames 1, 2, 3 at 100 ms; one was missed before the last.
History three_frames() {
  History history;
  const History::Clock::time_point start{};
  history.add(frame(1, 4, 0), spec_of(v1::REPORT_ALL), start);
  history.add(frame(2, 8, 1234), spec_of(v1::REPORT_ALL), start + milliseconds(100));
  history.add(frame(4, 2, 7, 1), spec_of(v1::REPORT_ALL), start + milliseconds(200));
  return history;
}

std::string line_with(const std::vector<std::string>& lines, const std::string& name) {
  const auto found = std::find_if(lines.begin(), lines.end(), [&](const auto& line) { return line.starts_with(name); });
  return found == lines.end() ? "no line " + name : *found;
}

TEST(History, CountsFramesThatWereNotShownInTheRate) {
  const History history = three_frames();
  EXPECT_EQ(history.frames(), 3u);
  EXPECT_EQ(history.skipped(), 1u);
  EXPECT_EQ(history.last_frame_id(), 4u);
  EXPECT_DOUBLE_EQ(history.rate(), 15);  // three frames after the first, in 0.2 s
  EXPECT_EQ(History().rate(), 0);
}

TEST(History, KeepsTheLastFramesAlone) {
  History history;
  for (uint64_t id = 1; id <= 2 * History::kFrames; ++id)
    history.add(frame(id, static_cast<double>(id), 1), spec_of(v1::REPORT_ALL),
                History::Clock::time_point(milliseconds(id)));
  EXPECT_EQ(history.frames(), 2 * History::kFrames);
  EXPECT_EQ(history.series()[0].values.size(), History::kFrames);
  EXPECT_EQ(history.series()[0].values.front(), History::kFrames + 1);
  EXPECT_DOUBLE_EQ(history.rate(), 1000);
}

TEST(History, StagesAndCountsStandWithTheirKind) {
  History history;
  history.add(frame(1, 4, 0), spec_of(v1::REPORT_ALL), {});
  client::WatchedFrame later = frame(2, 4, 1);
  later.done.mutable_metrics()->add_stages()->set_stage("exact");
  history.add(later, spec_of(v1::REPORT_ALL), {});
  std::vector<std::string> names;
  for (const Series& series : history.series()) names.push_back(series.name);
  EXPECT_EQ(names, (std::vector<std::string>{"total", "queue", "step", "  search", "  exact", "contacts",
                                             "  contacts_vertex_triangle", "bytes_in", "bytes_out", "device_bytes"}));
}

TEST(History, AStageThatDidNotRunTookNoTime) {
  History history = three_frames();
  client::WatchedFrame without = frame(5, 3, 7);
  without.done.mutable_metrics()->mutable_stages(0)->set_stage("exact");
  history.add(without, spec_of(v1::REPORT_ALL), History::Clock::time_point(milliseconds(300)));
  const auto values_of = [&](const std::string& name) {
    const auto found = std::find_if(history.series().begin(), history.series().end(),
                                    [&](const Series& series) { return series.name == name; });
    return found == history.series().end() ? std::deque<double>{} : found->values;
  };
  EXPECT_EQ(values_of("  search"), (std::deque<double>{2, 4, 1, 0}));
  EXPECT_EQ(values_of("  exact"), (std::deque<double>{1.5}));
}

TEST(History, AStageAndACountMayHaveTheSameName) {
  History history;
  client::WatchedFrame both = frame(1, 4, 1);
  both.done.mutable_metrics()->mutable_counts()->set_pairs(99);
  v1::StageTime& stage = *both.done.mutable_metrics()->add_stages();
  stage.set_stage("pairs");
  stage.set_milliseconds(0.5);
  history.add(both, spec_of(v1::REPORT_ALL), {});
  std::vector<double> values;
  for (const Series& series : history.series())
    if (series.name == "  pairs") values.insert(values.end(), series.values.begin(), series.values.end());
  EXPECT_EQ(values, (std::vector<double>{0.5, 99}));
}

TEST(History, WhatIsNotCountedIsNotShown) {
  History history;
  history.add(frame(1, 4, 5), spec_of(v1::REPORT_ANY_HIT), {});
  for (const Series& series : history.series()) EXPECT_EQ(series.name.find("contacts"), std::string::npos);
}

TEST(Table, ShowsLastLeastMedianAndGreatest) {
  const auto lines = table_lines({"knot"}, three_frames(), {.columns = 100, .rows = 40});
  EXPECT_EQ(lines[0], "knot");
  EXPECT_EQ(lines[1], "frame 4   15.0 frames/s   1 skipped   no contact");
  EXPECT_EQ(line_with(lines, "total"), "total                            2 ms       2 ms       4 ms       8 ms  ▅█▃");
  EXPECT_EQ(line_with(lines, "  search"),
            "  search                         1 ms       1 ms       2 ms       4 ms  ▅█▃");
  EXPECT_EQ(line_with(lines, "contacts"),
            "contacts                            7          0          7      1,234  ▁█▁");
}

TEST(Table, HasATimeWhereFramesHave) {
  client::WatchedFrame found = frame(1, 4, 5);
  found.done.set_any_contact(true);
  found.done.set_earliest_toi(0.25);
  const auto shown = [&](v1::DetectionMode mode) {
    History history;
    history.add(found, spec_of(v1::REPORT_ALL, mode), {});
    return table_lines({"knot"}, history, {.columns = 100, .rows = 40})[1];
  };
  EXPECT_TRUE(shown(v1::DETECTION_MODE_CCD).ends_with("   earliest 0.25"));
  EXPECT_TRUE(shown(v1::DETECTION_MODE_DCD).ends_with("   a contact"));
}

TEST(Table, FitsTheTerminal) {
  for (const size_t columns : {1, 10, 40, 79, 80, 81, 200})
    for (const size_t rows : {1, 2, 5, 6, 24}) {
      const auto lines = table_lines({std::string(300, 'x')}, three_frames(), {columns, rows, false});
      EXPECT_LE(lines.size(), rows);
      for (const std::string& line : lines) EXPECT_LE(line.size(), columns);
    }
  const auto cut = table_lines({"knot"}, three_frames(), {.columns = 100, .rows = 6});
  EXPECT_EQ(cut.back(), "and 8 more; a larger window shows them");
}

TEST(Table, WithoutFramesSaysSo) {
  EXPECT_EQ(table_lines({"knot"}, {}, {}), (std::vector<std::string>{"knot", "no frame yet"}));
}

TEST(Table, ANameDoesNotSteerTheTerminal) {
  v1::Scene scene;
  scene.mutable_spec()->set_display_name("knot\x1b[2J\n\x9b");
  scene.set_scene_id("0123");
  EXPECT_EQ(table_title(scene)[0], "knot?[2J??, scene 0123");
}

TEST(Curve, IsHigherForLargerValues) {
  EXPECT_EQ(curve({0, 1, 2, 4, 8}, 80, true), "▁▂▃▅█");
  EXPECT_EQ(curve({0, 1, 2, 4, 8}, 80, false), "_.-=#");
  EXPECT_EQ(curve({9, 9, 0, 8}, 2, false), "_#");
  EXPECT_EQ(curve({0, 0}, 80, false), "__");
  EXPECT_EQ(curve({}, 80, false), "");
}

}  // namespace
}  // namespace collided::cli
