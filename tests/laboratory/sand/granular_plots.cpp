// The plots of the granular study. Measurements are marks, laws are lines, and wrong settings are rings.
#include "tests/laboratory/sand/granular_plots.h"

#include <cmath>

namespace sandglass::host {

namespace {

constexpr Colour k_measured = {196, 98, 16}, k_law = {60, 60, 66}, k_wrong = {150, 150, 158};

// A law over a range, at points that are evenly spaced in the logarithm.
template <class Law>
PlotSeries law(const char* name, double low, double high, Colour colour, bool dashed, const Law& value) {
  constexpr int k_points = 120;
  PlotSeries series;
  series.name = name;
  series.colour = colour;
  series.line = true;
  series.dashed = dashed;
  series.mark = PlotSeries::Mark::none;
  for (int i = 0; i <= k_points; ++i) {
    const double x = low * std::pow(high / low, static_cast<double>(i) / k_points);
    series.x.push_back(x);
    series.y.push_back(value(x));
  }
  return series;
}

PlotSeries points(const char* name, const std::vector<double>& x, const std::vector<double>& y, Colour colour,
                  PlotSeries::Mark mark) {
  PlotSeries series;
  series.name = name;
  series.x = x;
  series.y = y;
  series.colour = colour;
  series.mark = mark;
  return series;
}

Plot runout(const GranularCurves& c) {
  Plot plot;
  plot.title = "Run-out of a collapsing column";
  plot.x = {"aspect ratio a = H/R0", 0.4, 10.0, true};
  plot.y = {"(R - R0)/R0", 0.3, 8.0, true};
  plot.series = {law("Lube 2004: 1.24 a, 1.6 sqrt(a)", 0.4, 10.0, k_law, false, lube_runout),
                 law("+-25 %", 0.4, 10.0, k_wrong, true, [](double a) { return 1.25 * lube_runout(a); }),
                 law("", 0.4, 10.0, k_wrong, true, [](double a) { return 0.75 * lube_runout(a); }),
                 points("Sandglass, defaults", c.aspects, c.runouts, k_measured, PlotSeries::Mark::disk),
                 points("control: mu = 0.05", c.wrong_aspects, c.wrong_runouts, k_wrong, PlotSeries::Mark::ring)};
  return plot;
}

Plot flow(const GranularCurves& c) {
  const auto rates = [](const DischargeCurve& curve, std::vector<double>* x, std::vector<double>* y) {
    for (const Discharge& point : curve.points) x->push_back(point.orifice_d), y->push_back(point.rate);
  };
  std::vector<double> x, y, wrong_x, wrong_y;
  rates(c.discharge, &x, &y);
  rates(c.wrong_discharge, &wrong_x, &wrong_y);
  // The law goes through the mean of the measured logarithms, because only its exponent is compared.
  double offset = 0.0;
  for (size_t i = 0; i < x.size(); ++i)
    offset += (std::log(y[i]) - 2.5 * std::log(x[i] - 1.4)) / static_cast<double>(x.size());
  Plot plot;
  plot.title = "Discharge through an orifice";
  plot.x = {"orifice D/d", 4.5, 11.0, false};
  plot.y = {"particles a second", 60.0, 5000.0, true};
  plot.series = {law("Beverloo: power 2.5 of D - 1.4 d", 4.5, 11.0, k_law, false,
                     [offset](double d) { return std::exp(offset) * std::pow(d - 1.4, 2.5); }),
                 points("Sandglass, defaults", x, y, k_measured, PlotSeries::Mark::disk),
                 points("control: one long step a frame", wrong_x, wrong_y, k_wrong, PlotSeries::Mark::ring)};
  return plot;
}

}  // namespace

std::vector<GranularPlot> granular_plots(const GranularCurves& curves) {
  std::vector<GranularPlot> plots;
  if (!curves.aspects.empty()) plots.push_back({"runout", runout(curves)});
  if (!curves.discharge.points.empty()) plots.push_back({"discharge", flow(curves)});
  for (GranularPlot& plot : plots) plot.plot.legend_right = true;
  return plots;
}

}  // namespace sandglass::host
