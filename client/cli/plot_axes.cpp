// Logarithmic axes with a row for zero, and labels that keep out of each other's way.

#include <algorithm>
#include <array>
#include <cmath>

#include "client/cli/plot.hpp"

namespace collided::cli {

namespace {

constexpr double kZeroRow = 26;           // pixels
constexpr double kTickRoom[] = {36, 15};  // pixels from label to label, at least, along x and along y
constexpr double kRoom = 1.2;             // between a value and the end of an axis, at least
constexpr double kMaxDecades = 40;        // of an axis: what lies below is put at its low end
constexpr TextStyle kTickText{.size = 11, .colour = kMuted};

/// 0.01 to 9999 as they are, other powers of ten with an exponent.
std::string value_label(int mantissa, int exponent) {
  if (exponent >= -2 && exponent <= 3) {
    std::string text = std::to_string(mantissa);
    if (exponent >= 0) return text + std::string(static_cast<size_t>(exponent), '0');
    return "0." + std::string(static_cast<size_t>(-exponent - 1), '0') + text;
  }
  constexpr std::array<const char*, 10> kRaised{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = (mantissa == 1 ? "10" : std::to_string(mantissa) + "·10") + std::string(exponent < 0 ? "⁻" : "");
  for (const char digit : std::to_string(std::abs(exponent))) text += kRaised[static_cast<size_t>(digit - '0')];
  return text;
}

/// The decimal logarithm of the next 1, 2 or 5 of a decade, downward or upward.
double snap(double value, bool is_up) {
  const double decade = std::floor(std::log10(value));
  const double mantissa = value / std::pow(10, decade);
  const std::array<double, 4> steps{1, 2, 5, 10};
  const auto above = std::find_if(steps.begin(), steps.end() - 1, [&](double step) { return step >= mantissa; });
  return decade + std::log10(is_up || *above == mantissa ? *above : *(above - 1));
}

bool overlap(const Rect& a, const Rect& b) {
  return a.x < b.right() && b.x < a.right() && a.y < b.bottom() && b.y < a.bottom();
}

}  // namespace

LogAxis::LogAxis(const std::vector<double>& values, double from, double to, Zero zero)
    : from_(from), decades_from_(from), to_(to), zero_(zero) {
  if (zero == Zero::kRow) decades_from_ += to > from ? kZeroRow : -kZeroRow;
  double low = INFINITY, high = 0;
  for (const double v : values) {
    if (!(v > 0)) continue;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  if (high == 0) return;
  high_ = snap(high * kRoom, true);
  low_ = std::max(snap(low / kRoom, false), high_ - kMaxDecades);
}

double LogAxis::place(double value) const {
  if (!(value > 0) && has_zero()) return (from_ + decades_from_) / 2;
  const double part = value > 0 ? (std::log10(value) - low_) / (high_ - low_) : 0;
  return decades_from_ + std::clamp(part, 0.0, 1.0) * (to_ - decades_from_);
}

std::vector<Tick> LogAxis::ticks() const {
  std::vector<Tick> out;
  if (has_zero()) out.push_back({place(0), "0"});
  const double decade = std::abs(to_ - decades_from_) / (high_ - low_);
  const double room = kTickRoom[to_ < from_];
  const int step = std::max(1, static_cast<int>(std::ceil(room / decade)));
  constexpr double kRounding = 1e-9;
  const auto add = [&](int mantissa, int exponent) {
    const double value = std::log10(mantissa) + exponent;
    // The end of the row for zero has no label: it would stand too close to that of zero.
    if (value < low_ + (has_zero() ? kRounding : -kRounding) || value > high_ + kRounding) return;
    out.push_back({place(mantissa * std::pow(10, exponent)), value_label(mantissa, exponent)});
  };
  for (int e = static_cast<int>(std::floor(low_)); e <= static_cast<int>(high_); ++e) {
    if (e % step == 0) add(1, e);
    if (decade * std::log10(2) < room) continue;
    for (const int mantissa : {2, 5}) add(mantissa, e);
  }
  return out;
}

void draw_axes(Canvas& canvas, const Axes& axes) {
  const Rect& area = axes.area;
  for (const Tick& tick : axes.x->ticks()) {
    canvas.line({{tick.at, area.y}, {tick.at, area.bottom()}}, {.colour = kGrid});
    TextStyle style = kTickText;
    style.align = Align::kCentre;
    if (!axes.x_title.empty()) canvas.text(tick.label, {tick.at, area.bottom() + 12}, style);
  }
  for (const Tick& tick : axes.y->ticks()) {
    canvas.line({{area.x, tick.at}, {area.right(), tick.at}}, {.colour = kGrid});
    TextStyle style = kTickText;
    style.align = Align::kRight;
    canvas.text(tick.label, {area.x - 6, tick.at}, style);
  }
  if (axes.y->has_zero()) {
    const double y = axes.y->zero_end();
    canvas.line({{area.x, y}, {area.right(), y}}, {.colour = kMuted, .width = 0.8, .dashed = true});
  }
  canvas.line({{area.x, area.y}, {area.x, area.bottom()}, {area.right(), area.bottom()}}, {.colour = kMuted});
  canvas.text(axes.title, {area.x, area.y - 11}, {.size = 12.5, .bold = true});
  canvas.text(axes.x_title, {area.x + area.width / 2, area.bottom() + 30}, {.colour = kMuted, .align = Align::kCentre});
  canvas.vertical_text(axes.y_title, {area.x - 50, area.y + area.height / 2}, {.colour = kMuted});
}

bool Labels::is_free(const Rect& rect, Lines lines) const {
  const auto hits = [&](const Rect& other) { return overlap(rect, other); };
  return rect.x >= area_.x && rect.y >= area_.y && rect.right() <= area_.right() && rect.bottom() <= area_.bottom() &&
         std::none_of(taken_.begin(), taken_.end(), hits) &&
         (lines == Lines::kCross || std::none_of(lines_.begin(), lines_.end(), hits));
}

void Labels::keep_free(Point from, Point to) {
  constexpr double kGrain = 3;
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  for (double at = 0; at <= length; at += kGrain) {
    const double part = length > 0 ? at / length : 0;
    lines_.push_back({from.x + part * (to.x - from.x) - 1, from.y + part * (to.y - from.y) - 1, 2, 2});
  }
}

void Labels::put(const std::string& text, Point at, double distance, TextStyle style) {
  const double width = canvas_.text_width(text, style), height = style.size * 1.1;
  const double beside = (style.align == Align::kRight ? -1 : 1) * (distance + width / 2);
  const double above = distance + height / 2;
  const std::array<Point, 10> offsets{{{beside, 0},
                                       {-beside, 0},
                                       {0, -above},
                                       {0, above},
                                       {beside, -above},
                                       {-beside, -above},
                                       {0, -1.7 * above},
                                       {beside, -1.7 * above},
                                       {-beside, -1.7 * above},
                                       {0, -2.6 * above}}};
  style.align = Align::kCentre;
  style.halo = true;
  for (const Lines lines : {Lines::kKeepFree, Lines::kCross})
    for (const Point& offset : offsets) {
      const Point centre{at.x + offset.x, at.y + offset.y};
      const Rect rect{centre.x - width / 2, centre.y - height / 2, width, height};
      if (!is_free(rect, lines)) continue;
      keep_free(rect);
      return canvas_.text(text, centre, style);
    }
}

}  // namespace collided::cli
