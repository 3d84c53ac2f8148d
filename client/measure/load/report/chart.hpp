#pragma once
// A line chart as inline SVG: no script, no other file. Points tell their values when the pointer rests on them.
// No charting library replaces it: the smallest from npm that draws such lines, uPlot 1.6, would put 51 kB of script into a page of
// 27 kB, has no tooltips, shows nothing where scripts are blocked, and a C++ program would need npm to build.

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace collided::cli::load {

/// Where a value of an axis is written out.
struct Tick {
  double value = 0;
  std::string text;
};

struct Axis {
  std::string label;
  double min = 0, max = 1;
  bool is_log = false;  ///< then min > 0
  std::vector<Tick> ticks = {};
};

/// From 0 to at least `max`, in steps of 1, 2 or 5.
Axis linear_axis(const std::string& label, double max);
/// Whole decades around `min` and `max`, which are > 0, in milliseconds.
Axis log_ms_axis(const std::string& label, double min, double max);

struct Line {
  std::string name;
  std::vector<std::pair<double, double>> points;
  std::vector<std::string> hints = {};  ///< of the points
};

struct Chart {
  std::string title;
  Axis x, y;
  std::vector<Line> lines;           ///< at most three
  std::optional<double> bound = {};  ///< a horizontal line
  std::string bound_name = {};
};

std::string chart_svg(const Chart& chart);

}  // namespace collided::cli::load
