// Tradeoffs as one picture. Each row has the time of the narrow phase to the right; upward, on the left, missed
// contacts and below them false ones; on the right how early the times of impact are. Best is bottom left.

#include "client/cli/tradeoff_plot.hpp"

#include <algorithm>
#include <cmath>

#include "client/cli/plot.hpp"
#include "client/measure/tradeoff/report.hpp"

namespace collided::cli {

namespace {

constexpr double kWidth = 1000, kRowHeight = 404, kMargin = 22, kHeader = 62, kMarker = 10;
constexpr double kTopOfPanels = 62, kBottomOfPanels = 346, kMissedHeight = 104, kStripGap = 34;  // in a row
constexpr Colour kAlarm{0.99, 0.94, 0.93}, kAlarmInk{0.72, 0.11, 0.11};

struct Level {
  const char* name;
  Colour colour;
};
/// Told apart with every kind of colour vision (Okabe and Ito's set).
constexpr Level kLevels[] = {{"fast", {0.84, 0.37, 0.00}},
                             {"guarded", {0.00, 0.45, 0.70}},
                             {"certified", {0.00, 0.55, 0.40}},
                             {"exact", {0.68, 0.35, 0.56}}};

Colour colour_of(const Run& run) {
  const auto level = std::find_if(std::begin(kLevels), std::end(kLevels),
                                  [&](const Level& candidate) { return run.level == candidate.name; });
  return level == std::end(kLevels) ? kMuted : level->colour;
}

Shape shape_of(const std::string& format) { return format == "f64" ? Shape::kDiamond : Shape::kCircle; }

bool is_same_series(const Run& a, const Run& b) { return a.level == b.level && a.format == b.format; }

double missed(const Run& run) { return static_cast<double>(sum(run.score).missed); }
double wrong(const Run& run) { return static_cast<double>(sum(run.score).wrong); }
double median_gap(const Run& run) { return run.score.gap ? run.score.gap->median : 0; }
double p99_gap(const Run& run) { return run.score.gap ? run.score.gap->p99 : 0; }
double worst_gap(const Run& run) { return run.score.gap ? run.score.gap->worst : 0; }

std::vector<double> values_of(const Tradeoff& result, std::initializer_list<double (*)(const Run&)> functions) {
  std::vector<double> out;
  for (const Run& run : result.runs)
    for (const auto f : functions) out.push_back(f(run));
  return out;
}

/// The runs of one result in one panel.
class RunsPanel {
 public:
  RunsPanel(Canvas& canvas, const Tradeoff& result, const Axes& axes, double (*value)(const Run&))
      : canvas_(canvas), result_(result), axes_(axes), value_(value), labels_(canvas, axes.area) {}

  void draw() {
    draw_lines();
    for (auto run = result_.runs.rbegin(); run != result_.runs.rend(); ++run) {  // so that fast, alone, lies on top
      const Point p = place(*run);
      canvas_.marker(shape_of(run->format), p, kMarker, colour_of(*run));
      labels_.keep_free({p.x - kMarker / 2, p.y - kMarker / 2, kMarker, kMarker});
    }
    labels_.keep_free({axes_.area.x, axes_.y->zero_end()}, {axes_.area.right(), axes_.y->zero_end()});
  }

  void draw_whiskers() {
    for (const Run& run : result_.runs) {
      const double x = place(run).x, low = axes_.y->place(median_gap(run)), high = axes_.y->place(worst_gap(run));
      canvas_.line({{x, low}, {x, high}}, {.colour = colour_of(run), .width = 1.2});
      labels_.keep_free({x, low}, {x, high});
      for (const double y : {low, high})
        canvas_.line({{x - 3, y}, {x + 3, y}}, {.colour = colour_of(run), .width = 1.2});
    }
  }

  void label_late() {
    for (const Run& run : result_.runs)
      if (const uint64_t late = sum(run.score).late; late > 0)
        labels_.put(count_text(late) + " late", place(run), 9, {.size = 11, .colour = kAlarmInk, .bold = true});
  }

  void label_levels() {
    for (const Level& level : kLevels) {
      const auto run =
          std::find_if(result_.runs.begin(), result_.runs.end(), [&](const Run& r) { return r.level == level.name; });
      if (run != result_.runs.end())
        labels_.put(level.name, place(*run), 9, {.size = 11.5, .colour = level.colour, .bold = true});
    }
  }

  /// Of the fastest series, on its left, and of the slowest, on its right: those between have the same order.
  void label_deltas() {
    std::vector<const Run*> joined;
    for (const Run& run : result_.runs)
      if (std::count_if(result_.runs.begin(), result_.runs.end(),
                        [&](const Run& other) { return is_same_series(run, other); }) > 1)
        joined.push_back(&run);
    if (joined.empty()) return;
    const auto [fastest, slowest] = std::minmax_element(
        joined.begin(), joined.end(), [](const Run* a, const Run* b) { return a->times.narrow < b->times.narrow; });
    for (const Run* run : joined) {
      const TextStyle style{.size = 10, .colour = colour_of(*run)};
      TextStyle left = style;
      left.align = Align::kRight;
      if (is_same_series(*run, **slowest))
        labels_.put(delta_text(*run->delta), place(*run), 8, style);
      else if (is_same_series(*run, **fastest))
        labels_.put(delta_text(*run->delta), place(*run), 8, left);
    }
  }

 private:
  Point place(const Run& run) const { return {axes_.x->place(run.times.narrow), axes_.y->place(value_(run))}; }

  void draw_lines() {
    for (size_t i = 1; i < result_.runs.size(); ++i) {
      const Run &a = result_.runs[i - 1], &b = result_.runs[i];
      if (!is_same_series(a, b)) continue;
      canvas_.line({place(a), place(b)}, {.colour = colour_of(a), .width = 1.2});
      labels_.keep_free(place(a), place(b));
    }
  }

  Canvas& canvas_;
  const Tradeoff& result_;
  const Axes& axes_;
  double (*value_)(const Run&);
  Labels labels_;
};

/// From 1 up, however large all counts are.
LogAxis count_axis(const Tradeoff& result, double (*value)(const Run&), const Rect& area) {
  std::vector<double> values = values_of(result, {value});
  values.push_back(1);
  return {values, area.bottom(), area.y, LogAxis::Zero::kRow};
}

void draw_missed(Canvas& canvas, const Tradeoff& result, const Rect& area) {
  const LogAxis x(values_of(result, {[](const Run& run) { return run.times.narrow; }}), area.x, area.right());
  const LogAxis y = count_axis(result, missed, area);
  canvas.fill({area.x, area.y, area.width, y.zero_end() - area.y}, kAlarm);
  const Axes axes{area, &x, &y, "Missed contacts", "", ""};
  draw_axes(canvas, axes);
  RunsPanel panel(canvas, result, axes, missed);
  panel.draw();
  panel.label_levels();
}

void draw_false(Canvas& canvas, const Tradeoff& result, const Rect& area) {
  const LogAxis x(values_of(result, {[](const Run& run) { return run.times.narrow; }}), area.x, area.right());
  const LogAxis y = count_axis(result, wrong, area);
  const Axes axes{area, &x, &y, "False contacts", "narrow phase, ms", ""};
  draw_axes(canvas, axes);
  RunsPanel panel(canvas, result, axes, wrong);
  panel.draw();
  panel.label_deltas();
}

void draw_gap(Canvas& canvas, const Tradeoff& result, const Rect& area) {
  const LogAxis x(values_of(result, {[](const Run& run) { return run.times.narrow; }}), area.x, area.right());
  const LogAxis y(values_of(result, {median_gap, p99_gap, worst_gap}), area.bottom(), area.y, LogAxis::Zero::kRow);
  const Axes axes{area, &x, &y, "Time of impact: how early, in parts of the step", "narrow phase, ms", ""};
  draw_axes(canvas, axes);
  RunsPanel panel(canvas, result, axes, p99_gap);
  panel.draw_whiskers();
  panel.draw();
  panel.label_late();
  panel.label_deltas();
}

void draw_row(Canvas& canvas, const Tradeoff& result, double top) {
  canvas.text(result.name, {kMargin, top + 14}, {.size = 15, .bold = true});
  const double after = kMargin + canvas.text_width(result.name, {.size = 15, .bold = true}) + 12;
  canvas.text(count_text(result.triangles) + " triangles, " + result.device, {after, top + 15}, {.colour = kMuted});
  const double panels = top + kTopOfPanels, height = kBottomOfPanels - kTopOfPanels, width = kWidth / 2 - 80;
  draw_missed(canvas, result, {60, panels, width, kMissedHeight});
  draw_false(canvas, result, {60, panels + kMissedHeight + kStripGap, width, height - kMissedHeight - kStripGap});
  draw_gap(canvas, result, {kWidth / 2 + 55, panels, width, height});
}

/// One entry of the legend; gives where the next one starts.
double draw_entry(Canvas& canvas, double x, double y, const std::string& text) {
  canvas.text(text, {x + 11, y}, {});
  return x + 11 + canvas.text_width(text, {}) + 20;
}

void draw_legend(Canvas& canvas, double y) {
  double x = kMargin + 6;
  for (const Level& level : kLevels) {
    canvas.fill({x - 6, y - 6, 12, 12}, level.colour, 2);
    x = draw_entry(canvas, x, y, level.name);
  }
  for (const auto& [format, text] : {std::pair{"f32", "float positions"}, std::pair{"f64", "double positions"}}) {
    canvas.marker(shape_of(format), {x, y}, kMarker + 1, kInk);
    x = draw_entry(canvas, x, y, text);
  }
  canvas.line({{x, y - 7}, {x, y + 7}}, {.width = 1.2});
  for (const double end : {y - 7, y + 7}) canvas.line({{x - 3, end}, {x + 3, end}}, {.width = 1.2});
  canvas.marker(Shape::kCircle, {x, y - 1}, 6, kInk);
  x = draw_entry(canvas, x, y, "median, 99 %, worst");
  canvas.text("numbers: delta", {x - 6, y}, {.colour = kMuted});
}

}  // namespace

void plot_tradeoffs(std::span<const Tradeoff> results, const std::filesystem::path& svg,
                    const std::filesystem::path& png) {
  const double height = kHeader + kRowHeight * static_cast<double>(results.size());
  draw_files(svg, png, {kWidth, height}, [&](Canvas& canvas) {
    canvas.fill({0, 0, kWidth, height}, kPaper, 8);
    draw_legend(canvas, 28);
    for (size_t i = 0; i < results.size(); ++i)
      draw_row(canvas, results[i], kHeader + kRowHeight * static_cast<double>(i));
  });
}

}  // namespace collided::cli
