#pragma once
// Plots on cairo: a canvas that is drawn to SVG and PNG alike, logarithmic axes with a row for zero, markers, labels.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

using cairo_t = struct _cairo;

namespace collided::cli {

struct Point {
  double x = 0, y = 0;
};

/// y grows downward.
struct Rect {
  double x = 0, y = 0, width = 0, height = 0;
  double right() const { return x + width; }
  double bottom() const { return y + height; }
};

struct Colour {
  double red = 0, green = 0, blue = 0;
};
inline constexpr Colour kInk{0.13, 0.15, 0.18}, kMuted{0.38, 0.41, 0.45}, kGrid{0.90, 0.91, 0.93}, kPaper{1, 1, 1};

enum class Shape { kCircle, kDiamond };
enum class Align { kLeft, kCentre, kRight };

struct TextStyle {
  double size = 12;
  Colour colour = kInk;
  bool bold = false;
  Align align = Align::kLeft;
  bool halo = false;  ///< white around the letters
};

struct Stroke {
  Colour colour = kInk;
  double width = 1;
  bool dashed = false;
};

class Canvas {
 public:
  explicit Canvas(cairo_t* cairo) : cairo_(cairo) {}
  void fill(const Rect& rect, Colour colour, double corner = 0);
  void line(const std::vector<Point>& points, const Stroke& stroke);
  /// Filled, with a white rim that keeps markers apart where they overlap.
  void marker(Shape shape, Point at, double size, Colour colour);
  /// `at` is on the left, in the middle or on the right of the text, at half the height of its letters.
  void text(const std::string& text, Point at, const TextStyle& style);
  /// Upward, centred at `at`.
  void vertical_text(const std::string& text, Point at, const TextStyle& style);
  double text_width(const std::string& text, const TextStyle& style);

 private:
  void set_colour(Colour colour);
  void set_font(const TextStyle& style);
  cairo_t* cairo_;
};

/// Draws the same picture to both files, the PNG at twice the size. Throws std::runtime_error naming the file.
void draw_files(const std::filesystem::path& svg, const std::filesystem::path& png, Point size,
                const std::function<void(Canvas&)>& draw);

struct Tick {
  double at = 0;  ///< pixel
  std::string label;
};

/// Values to pixels: from 1, 2 or 5 of a decade to 1, 2 or 5, and below, if asked for, a row for zero and less.
class LogAxis {
 public:
  enum class Zero { kNone, kRow };
  /// `from` is the pixel of the low end. Without a positive value the axis has the decade from 1 to 10.
  LogAxis(const std::vector<double>& values, double from, double to, Zero zero = Zero::kNone);
  double place(double value) const;
  std::vector<Tick> ticks() const;
  bool has_zero() const { return zero_ == Zero::kRow; }
  /// Where the row for zero ends.
  double zero_end() const { return decades_from_; }

 private:
  double from_, decades_from_, to_;
  double low_ = 0, high_ = 1;  ///< decimal logarithms
  Zero zero_;
};

/// Frame, grid, ticks and titles of one panel. An empty title is left out, as are the labels of its axis.
struct Axes {
  Rect area;
  const LogAxis* x;
  const LogAxis* y;
  std::string title, x_title, y_title;
};
void draw_axes(Canvas& canvas, const Axes& axes);

/// Puts labels next to points where nothing else is; one that finds no place is left out.
class Labels {
 public:
  Labels(Canvas& canvas, const Rect& area) : canvas_(canvas), area_(area) {}
  void keep_free(const Rect& rect) { taken_.push_back(rect); }
  void keep_free(Point from, Point to);  ///< a line, which a label may cross if there is no other place
  /// On the right of the point where there is room; with Align::kRight, so that the text ends at the point, on its
  /// left.
  void put(const std::string& text, Point at, double distance, TextStyle style);

 private:
  enum class Lines { kKeepFree, kCross };
  bool is_free(const Rect& rect, Lines lines) const;
  Canvas& canvas_;
  Rect area_;
  std::vector<Rect> taken_, lines_;
};

}  // namespace collided::cli
