// Plots on cairo. Text becomes outlines in the SVG, so that it looks the same wherever it is shown.

#include "client/cli/plot.hpp"

#include <cairo-svg.h>
#include <cairo.h>
#include <fontconfig/fontconfig.h>

#include <memory>
#include <numbers>
#include <stdexcept>

namespace collided::cli {

namespace {

constexpr double kPngScale = 2;
constexpr const char* kFont = "DejaVu Sans";

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using Context = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

/// Frees at its end, after every surface, the fonts that cairo and fontconfig keep: leak checkers see them otherwise.
struct FontCaches {
  FontCaches() = default;
  FontCaches(const FontCaches&) = delete;
  FontCaches& operator=(const FontCaches&) = delete;
  ~FontCaches() {
    cairo_debug_reset_static_data();
    FcFini();
  }
};

void check(cairo_status_t status, const std::filesystem::path& file) {
  if (status != CAIRO_STATUS_SUCCESS)
    throw std::runtime_error(file.string() + ": cannot be written: " + cairo_status_to_string(status));
}

void draw_on(cairo_surface_t* surface, double scale, const std::function<void(Canvas&)>& draw,
             const std::filesystem::path& file) {
  const Context context(cairo_create(surface), cairo_destroy);
  cairo_scale(context.get(), scale, scale);
  Canvas canvas(context.get());
  draw(canvas);
  check(cairo_status(context.get()), file);
}

void add_shape(cairo_t* cairo, Shape shape, Point at, double radius) {
  cairo_new_path(cairo);
  if (shape == Shape::kCircle) {
    cairo_arc(cairo, at.x, at.y, radius, 0, 2 * std::numbers::pi);
  } else {
    const double r = radius * 1.25;  // a diamond of a circle's area
    cairo_move_to(cairo, at.x, at.y - r);
    cairo_line_to(cairo, at.x + r, at.y);
    cairo_line_to(cairo, at.x, at.y + r);
    cairo_line_to(cairo, at.x - r, at.y);
  }
  cairo_close_path(cairo);
}

void add_rounded(cairo_t* cairo, const Rect& r, double corner) {
  constexpr double kQuarter = std::numbers::pi / 2;
  cairo_new_path(cairo);
  cairo_arc(cairo, r.right() - corner, r.y + corner, corner, -kQuarter, 0);
  cairo_arc(cairo, r.right() - corner, r.bottom() - corner, corner, 0, kQuarter);
  cairo_arc(cairo, r.x + corner, r.bottom() - corner, corner, kQuarter, 2 * kQuarter);
  cairo_arc(cairo, r.x + corner, r.y + corner, corner, 2 * kQuarter, 3 * kQuarter);
  cairo_close_path(cairo);
}

}  // namespace

void draw_files(const std::filesystem::path& svg, const std::filesystem::path& png, Point size,
                const std::function<void(Canvas&)>& draw) {
  const FontCaches caches;
  {
    const Surface surface(cairo_svg_surface_create(svg.c_str(), size.x, size.y), cairo_surface_destroy);
    draw_on(surface.get(), 1, draw, svg);
    cairo_surface_finish(surface.get());
    check(cairo_surface_status(surface.get()), svg);
  }
  const Surface surface(cairo_image_surface_create(CAIRO_FORMAT_ARGB32, static_cast<int>(size.x * kPngScale),
                                                   static_cast<int>(size.y * kPngScale)),
                        cairo_surface_destroy);
  draw_on(surface.get(), kPngScale, draw, png);
  check(cairo_surface_write_to_png(surface.get(), png.c_str()), png);
}

void Canvas::set_colour(Colour c) { cairo_set_source_rgb(cairo_, c.red, c.green, c.blue); }

void Canvas::set_font(const TextStyle& style) {
  cairo_select_font_face(cairo_, kFont, CAIRO_FONT_SLANT_NORMAL,
                         style.bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo_, style.size);
  set_colour(style.colour);
}

void Canvas::fill(const Rect& rect, Colour colour, double corner) {
  set_colour(colour);
  add_rounded(cairo_, rect, corner);
  cairo_fill(cairo_);
}

void Canvas::line(const std::vector<Point>& points, const Stroke& stroke) {
  set_colour(stroke.colour);
  cairo_set_line_width(cairo_, stroke.width);
  constexpr double kDash[] = {4, 3};
  cairo_set_dash(cairo_, kDash, stroke.dashed ? 2 : 0, 0);
  cairo_new_path(cairo_);
  for (const Point& p : points) cairo_line_to(cairo_, p.x, p.y);
  cairo_stroke(cairo_);
}

void Canvas::marker(Shape shape, Point at, double size, Colour colour) {
  add_shape(cairo_, shape, at, size / 2);
  set_colour(colour);
  cairo_fill_preserve(cairo_);
  set_colour(kPaper);
  cairo_set_dash(cairo_, nullptr, 0, 0);
  cairo_set_line_width(cairo_, 1);
  cairo_stroke(cairo_);
}

double Canvas::text_width(const std::string& text, const TextStyle& style) {
  set_font(style);
  cairo_text_extents_t extents;
  cairo_text_extents(cairo_, text.c_str(), &extents);
  return extents.x_advance;
}

void Canvas::text(const std::string& text, Point at, const TextStyle& style) {
  const double width = text_width(text, style);
  const double part = style.align == Align::kLeft ? 0 : style.align == Align::kCentre ? 0.5 : 1;
  const Point from{at.x - part * width, at.y + 0.36 * style.size};
  if (style.halo) {
    cairo_new_path(cairo_);
    cairo_move_to(cairo_, from.x, from.y);
    cairo_text_path(cairo_, text.c_str());
    cairo_set_dash(cairo_, nullptr, 0, 0);
    cairo_set_line_width(cairo_, 3);
    set_colour(kPaper);
    cairo_stroke(cairo_);
    set_colour(style.colour);
  }
  cairo_move_to(cairo_, from.x, from.y);
  cairo_show_text(cairo_, text.c_str());
}

void Canvas::vertical_text(const std::string& text, Point at, const TextStyle& style) {
  cairo_save(cairo_);
  cairo_translate(cairo_, at.x, at.y);
  cairo_rotate(cairo_, -std::numbers::pi / 2);
  TextStyle centred = style;
  centred.align = Align::kCentre;
  this->text(text, {0, 0}, centred);
  cairo_restore(cairo_);
}

}  // namespace collided::cli
