// Smooth edges without supersampling: the distance of a pixel from a line or a mark decides how much it is covered. The
// transition is one pixel wide.
#include "models/drawing/plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace sandglass::host {

namespace {

constexpr int k_width = 900, k_height = 620;
constexpr int k_left = 110, k_right = 30, k_top = 60, k_bottom = 84;  // margins
constexpr Colour k_ink = {40, 40, 44}, k_grid = {226, 226, 230}, k_paper = {255, 255, 255};
constexpr int k_text = 2;  // pixels per font pixel
constexpr int k_letter = 7 * k_text;
constexpr double k_line = 1.5, k_mark = 5.5, k_dash = 9.0;  // in pixels: half width, radius, length of a dash

struct Canvas {
  Picture picture{k_width, k_height, k_paper};
  bool clipped = false;  // draws only inside the frame

  void cover(int x, int y, double share, Colour colour) {
    if (share <= 0.0 || x < 0 || y < 0 || x >= k_width || y >= k_height) return;
    if (clipped && (x < k_left || x > k_width - k_right || y < k_top || y > k_height - k_bottom)) return;
    uint8_t* pixel = picture.at(x, y);
    const uint8_t to[3] = {colour.r, colour.g, colour.b};
    const double amount = std::min(share, 1.0);
    for (int k = 0; k < 3; ++k) pixel[k] = static_cast<uint8_t>(std::lround(pixel[k] + amount * (to[k] - pixel[k])));
  }

  template <class Distance>
  void shape(double x0, double y0, double x1, double y1, Colour colour, const Distance& distance) {
    const auto clamped = [](double value, int high) {
      return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(high)));
    };
    for (int y = clamped(y0 - 1.0, k_height - 1); y <= clamped(y1 + 2.0, k_height - 1); ++y)
      for (int x = clamped(x0 - 1.0, k_width - 1); x <= clamped(x1 + 2.0, k_width - 1); ++x)
        cover(x, y, 0.5 - distance(x + 0.5, y + 0.5), colour);
  }

  // `along` is the length of the line before this piece. It lets dashes go on around corners.
  void line(double x0, double y0, double x1, double y1, double half, Colour colour, bool dashed, double along) {
    const double dx = x1 - x0, dy = y1 - y0, run = std::hypot(dx, dy);
    if (!(run > 0.0) || !std::isfinite(run)) return;
    shape(std::min(x0, x1) - half, std::min(y0, y1) - half, std::max(x0, x1) + half, std::max(y0, y1) + half, colour,
          [&](double x, double y) {
            const double t = std::clamp(((x - x0) * dx + (y - y0) * dy) / (run * run), 0.0, 1.0);
            if (dashed && std::fmod(along + t * run, 2.0 * k_dash) > k_dash) return 1.0;
            return std::hypot(x - x0 - t * dx, y - y0 - t * dy) - half;
          });
  }

  void mark(PlotSeries::Mark kind, double cx, double cy, Colour colour) {
    if (kind == PlotSeries::Mark::none || !std::isfinite(cx) || !std::isfinite(cy)) return;
    shape(cx - k_mark, cy - k_mark, cx + k_mark, cy + k_mark, colour, [&](double x, double y) {
      const double round = std::hypot(x - cx, y - cy) - k_mark;
      if (kind == PlotSeries::Mark::square) return std::max(std::fabs(x - cx), std::fabs(y - cy)) - k_mark + 1.0;
      return kind == PlotSeries::Mark::ring ? std::fabs(round + 1.0) - 1.0 : round;
    });
  }
};

double share_of(const PlotAxis& axis, double value) {
  if (!axis.logarithmic) return (value - axis.low) / (axis.high - axis.low);
  if (!(value > 0.0)) return -std::numeric_limits<double>::infinity();
  return std::log(value / axis.low) / std::log(axis.high / axis.low);
}

double pixel_x(const Plot& plot, double value) {
  return k_left + share_of(plot.x, value) * (k_width - k_left - k_right);
}
double pixel_y(const Plot& plot, double value) {
  return k_height - k_bottom - share_of(plot.y, value) * (k_height - k_top - k_bottom);
}

std::string tick_label(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

// Draws the text turned by a quarter, so that it reads upward.
void draw_upward(Picture* picture, int x, int middle, const std::string& text) {
  const int length = text_width(k_text, text);
  Picture flat(std::max(length, 1), k_letter, k_paper);
  draw_text(&flat, 0, 0, k_text, text, k_ink);
  for (int v = 0; v < flat.height; ++v)
    for (int u = 0; u < flat.width; ++u) {
      const int px = x + v, py = middle + length / 2 - u;
      if (px < 0 || py < 0 || px >= picture->width || py >= picture->height) continue;
      std::copy_n(flat.at(u, v), 3, picture->at(px, py));
    }
}

void draw_series(Canvas* canvas, const Plot& plot, const PlotSeries& series) {
  const size_t count = std::min(series.x.size(), series.y.size());
  double along = 0.0;
  for (size_t i = 0; i + 1 < count && series.line; ++i) {
    const double x0 = pixel_x(plot, series.x[i]), y0 = pixel_y(plot, series.y[i]);
    const double x1 = pixel_x(plot, series.x[i + 1]), y1 = pixel_y(plot, series.y[i + 1]);
    canvas->line(x0, y0, x1, y1, k_line, series.colour, series.dashed, along);
    along += std::hypot(x1 - x0, y1 - y0);
  }
  for (size_t i = 0; i < count; ++i)
    canvas->mark(series.mark, pixel_x(plot, series.x[i]), pixel_y(plot, series.y[i]), series.colour);
}

void draw_legend(Canvas* canvas, const Plot& plot) {
  constexpr int k_row = 26, k_sample = 44, k_gap = 16;
  int rows = 0, widest = 0;
  for (const PlotSeries& series : plot.series) {
    if (series.name.empty()) continue;
    ++rows;
    widest = std::max(widest, text_width(k_text, series.name));
  }
  const int width = k_sample + widest + 2 * k_gap, height = rows * k_row;
  const int left = plot.legend_right ? k_width - k_right - width - k_gap : k_left + k_gap;
  int y = plot.legend_right ? k_height - k_bottom - height - k_gap : k_top + k_gap;
  if (rows > 0) fill_rectangle(&canvas->picture, left, y - 4, width, height + 2, k_paper);
  for (const PlotSeries& series : plot.series) {
    if (series.name.empty()) continue;
    const double middle = y + 0.5 * k_letter;
    if (series.line)
      canvas->line(left + 6, middle, left + 6 + k_sample - 8, middle, k_line, series.colour, series.dashed, 0.0);
    canvas->mark(series.mark, left + 6 + 0.5 * (k_sample - 8), middle, series.colour);
    draw_text(&canvas->picture, left + k_sample + k_gap / 2, y, k_text, series.name, k_ink);
    y += k_row;
  }
}

}  // namespace

std::vector<double> plot_ticks(const PlotAxis& axis) {
  std::vector<double> ticks;
  const double slack = 1e-9;
  if (axis.logarithmic) {
    const bool decades = axis.high / axis.low >= 100.0;
    for (int power = static_cast<int>(std::floor(std::log10(axis.low))); std::pow(10.0, power) <= axis.high; ++power)
      for (const double factor : {1.0, 2.0, 3.0, 5.0}) {
        if (decades && factor != 1.0) break;
        const double value = factor * std::pow(10.0, power);
        if (value >= axis.low * (1.0 - slack) && value <= axis.high * (1.0 + slack)) ticks.push_back(value);
      }
    return ticks;
  }
  constexpr double k_most = 8.0;
  const double range = axis.high - axis.low;
  double step = std::pow(10.0, std::floor(std::log10(range / k_most)));
  for (const double factor : {1.0, 2.0, 5.0, 10.0})
    if (range / (step * factor) <= k_most) {
      step *= factor;
      break;
    }
  for (double k = std::ceil(axis.low / step - slack); k * step <= axis.high + slack * range; k += 1.0)
    ticks.push_back(k * step + 0.0);  // no minus zero
  return ticks;
}

Picture draw_plot(const Plot& plot) {
  Canvas canvas;
  const int bottom = k_height - k_bottom, right = k_width - k_right;
  for (const double tick : plot_ticks(plot.x)) {
    const double x = pixel_x(plot, tick);
    canvas.line(x, k_top, x, bottom, 0.5, k_grid, false, 0.0);
    canvas.line(x, bottom, x, bottom + 6, 0.75, k_ink, false, 0.0);
    const std::string label = tick_label(tick);
    draw_text(&canvas.picture, static_cast<int>(x) - text_width(k_text, label) / 2, bottom + 12, k_text, label, k_ink);
  }
  for (const double tick : plot_ticks(plot.y)) {
    const double y = pixel_y(plot, tick);
    canvas.line(k_left, y, right, y, 0.5, k_grid, false, 0.0);
    canvas.line(k_left - 6, y, k_left, y, 0.75, k_ink, false, 0.0);
    const std::string label = tick_label(tick);
    draw_text(&canvas.picture, k_left - 12 - text_width(k_text, label), static_cast<int>(y) - k_letter / 2, k_text,
              label, k_ink);
  }
  canvas.clipped = true;
  for (const PlotSeries& series : plot.series) draw_series(&canvas, plot, series);
  canvas.clipped = false;
  canvas.line(k_left, k_top, k_left, bottom, 0.75, k_ink, false, 0.0);
  canvas.line(k_left, bottom, right, bottom, 0.75, k_ink, false, 0.0);
  canvas.line(right, k_top, right, bottom, 0.75, k_ink, false, 0.0);
  canvas.line(k_left, k_top, right, k_top, 0.75, k_ink, false, 0.0);
  draw_legend(&canvas, plot);
  draw_text(&canvas.picture, (k_left + right - text_width(k_text, plot.title)) / 2, 24, k_text, plot.title, k_ink);
  draw_text(&canvas.picture, (k_left + right - text_width(k_text, plot.x.label)) / 2, k_height - 32, k_text,
            plot.x.label, k_ink);
  draw_upward(&canvas.picture, 14, (k_top + bottom) / 2, plot.y.label);
  return canvas.picture;
}

}  // namespace sandglass::host
