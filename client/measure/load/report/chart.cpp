// A line chart as inline SVG.

#include "client/measure/load/report/chart.hpp"

#include <algorithm>
#include <cmath>

#include "client/app/output/markup.hpp"
#include "client/app/report/numbers.hpp"

namespace collided::cli::load {

namespace {

constexpr double kWidth = 720, kHeight = 300, kLeft = 64, kRight = 16, kTop = 34, kBottom = 44;
constexpr size_t kMaxDots = 400;  // more would hide the line

std::string number(double x) { return format_double("%.1f", x); }

std::string time_text(double ms) {
  if (ms >= 1000) return format_double("%g s", ms / 1000);
  return ms < 1 ? format_double("%g us", ms * 1000) : format_double("%g ms", ms);
}

/// Where a value lies between the ends of its axis, 0 to 1.
double place(const Axis& axis, double value) {
  const auto scaled = [&](double x) { return axis.is_log ? std::log10(x) : x; };
  const double clamped = std::clamp(value, axis.min, axis.max);
  return (scaled(clamped) - scaled(axis.min)) / (scaled(axis.max) - scaled(axis.min));
}

class Drawing {
 public:
  explicit Drawing(const Chart& chart) : chart_(chart) {}

  std::string svg() {
    out_ = "<figure><svg viewBox=\"0 0 " + number(kWidth) + " " + number(kHeight) + "\" role=\"img\" aria-label=\"" +
           escape_markup(chart_.title) + "\">\n";
    text("title", 0, 14, "start", chart_.title);
    draw_axes();
    draw_bound();
    for (size_t i = 0; i < chart_.lines.size(); ++i) draw_line(i);
    draw_legend();
    return out_ + "</svg></figure>\n";
  }

 private:
  double x_of(double value) const { return kLeft + place(chart_.x, value) * (kWidth - kLeft - kRight); }
  double y_of(double value) const { return kHeight - kBottom - place(chart_.y, value) * (kHeight - kTop - kBottom); }

  void text(const char* kind, double x, double y, const char* anchor, const std::string& words) {
    out_ += std::string("<text class=\"") + kind + "\" x=\"" + number(x) + "\" y=\"" + number(y) + "\" text-anchor=\"" +
            anchor + "\">" + escape_markup(words) + "</text>\n";
  }
  void stroke(const std::string& kind, double x0, double y0, double x1, double y1) {
    out_ += "<line class=\"" + kind + "\" x1=\"" + number(x0) + "\" y1=\"" + number(y0) + "\" x2=\"" + number(x1) +
            "\" y2=\"" + number(y1) + "\"/>\n";
  }

  void draw_axes() {
    for (const Tick& tick : chart_.y.ticks) {
      stroke("grid", kLeft, y_of(tick.value), kWidth - kRight, y_of(tick.value));
      text("tick", kLeft - 8, y_of(tick.value) + 4, "end", tick.text);
    }
    for (const Tick& tick : chart_.x.ticks) {
      stroke("grid", x_of(tick.value), kHeight - kBottom, x_of(tick.value), kHeight - kBottom + 4);
      text("tick", x_of(tick.value), kHeight - kBottom + 18, "middle", tick.text);
    }
    text("tick", kWidth - kRight, kHeight - 6, "end", chart_.x.label);
  }
  void draw_bound() {
    if (!chart_.bound) return;
    stroke("bound", kLeft, y_of(*chart_.bound), kWidth - kRight, y_of(*chart_.bound));
    text("tick", kWidth - kRight, y_of(*chart_.bound) - 5, "end", chart_.bound_name);
  }
  void draw_line(size_t index) {
    const Line& line = chart_.lines[index];
    const std::string kind = "line" + std::to_string(index);
    out_ += "<polyline class=\"" + kind + "\" points=\"";
    for (const auto& [x, y] : line.points) out_ += number(x_of(x)) + "," + number(y_of(y)) + " ";
    out_ += "\"/>\n";
    for (size_t i = 0; i < line.points.size() && line.points.size() <= kMaxDots; ++i)
      draw_dot(kind, line.points[i], line.name + (i < line.hints.size() ? ", " + line.hints[i] : ""));
  }
  void draw_dot(const std::string& kind, const std::pair<double, double>& point, const std::string& hint) {
    out_ += "<circle class=\"" + kind + "\" cx=\"" + number(x_of(point.first)) + "\" cy=\"" +
            number(y_of(point.second)) + "\" r=\"2.5\"><title>" + escape_markup(hint) + "</title></circle>\n";
  }
  /// On the right, above the plot.
  void draw_legend() {
    constexpr double kLetter = 7.2, kSwatch = 18, kGap = 16;
    double x = kWidth - kRight;
    for (size_t i = chart_.lines.size(); i-- > 0;) {
      const std::string& name = chart_.lines[i].name;
      text("tick", x, 14, "end", name);
      x -= kLetter * static_cast<double>(name.size()) + 10;
      stroke("line" + std::to_string(i), x - kSwatch, 10, x, 10);
      x -= kSwatch + kGap;
    }
  }

  const Chart& chart_;
  std::string out_;
};

}  // namespace

Axis linear_axis(const std::string& label, double max) {
  constexpr int kSteps = 5;
  const double rough = std::max(max, 1e-9) / kSteps, magnitude = std::pow(10, std::floor(std::log10(rough)));
  const double ratio = rough / magnitude, step = magnitude * (ratio <= 1 ? 1 : ratio <= 2 ? 2 : ratio <= 5 ? 5 : 10);
  Axis axis{.label = label, .min = 0, .max = step * std::ceil(max / step - 1e-9)};
  axis.max = std::max(axis.max, step);
  for (int i = 0; i * step <= axis.max * (1 + 1e-9); ++i)
    axis.ticks.push_back({i * step, format_double("%g", i * step)});
  return axis;
}

Axis log_ms_axis(const std::string& label, double min, double max) {
  const double first = std::floor(std::log10(min) + 1e-9),
               last = std::max(std::ceil(std::log10(max) - 1e-9), first + 1);
  Axis axis{.label = label, .min = std::pow(10, first), .max = std::pow(10, last), .is_log = true};
  for (double power = first; power <= last; ++power)
    axis.ticks.push_back({std::pow(10, power), time_text(std::pow(10, power))});
  return axis;
}

std::string chart_svg(const Chart& chart) { return Drawing(chart).svg(); }

}  // namespace collided::cli::load
