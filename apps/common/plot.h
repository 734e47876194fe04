// Plots as SVG files, drawn by gnuplot.
//
//   Plot plot;
//   plot.title = "Held-out-camera error";
//   plot.x.label = "cut-off [Hz]";
//   plot.y.label = "error [px]";
//   plot.series.push_back(
//       {"Butterworth", PlotStyle::kLinePoints, {2, 4}, {5.1, 4.8}});
//   WritePlot({plot}, folder.PathOf("tuning.svg"));
//
// The same description gives the same bytes with one version of gnuplot.
// Colours are those of Okabe and Ito (2008, "Color Universal Design"), which
// colour-blind people can distinguish; series of points also differ in their
// marks, except clouds of more than 300 points, and lines are dotted when all
// colours are in use.
#ifndef KINEGRAPH_APPS_COMMON_PLOT_H_
#define KINEGRAPH_APPS_COMMON_PLOT_H_

#include <optional>
#include <string>
#include <vector>

#include "core/evaluation/statistics.h"

namespace kinegraph {

enum class PlotStyle {
  kLine,
  kPoints,
  kLinePoints,
  // From zero, unless the y axis is logarithmic or has `low`; bars of several
  // series are side by side.
  kBars,
};

// A curve, a set of points or of bars. Everything except `x` and `y` may be
// empty.
struct PlotSeries {
  std::string name;  // in the legend
  PlotStyle style = PlotStyle::kLine;
  std::vector<double> x = {};
  std::vector<double> y = {};  // as many as x; NaN breaks a line
  // Ends of the error bars; NaN: none.
  std::vector<double> x_low = {}, x_high = {};
  std::vector<double> y_low = {}, y_high = {};
  // Index into the palette; by default the index of the series.
  std::optional<int> colour = {};
  bool dashed = false;

  void Add(double x_value, double y_value) {
    x.push_back(x_value);
    y.push_back(y_value);
  }
  // Adds a point with an error bar in y.
  void Add(double x_value, double y_value, const Interval& interval) {
    Add(x_value, y_value);
    y_low.push_back(interval.low);
    y_high.push_back(interval.high);
  }
};

struct PlotAxis {
  std::string label;  // with the unit: "error [px]"
  bool log = false;   // values that are not positive are left out
  std::optional<double> low, high;
  // Names of the values 0, 1, 2, ...; a y axis with names runs downwards.
  std::vector<std::string> categories;
};

enum class PlotLegend { kNone, kInside, kOutside, kBelow };

struct Plot {
  std::string title;
  PlotAxis x, y;
  std::vector<PlotSeries> series;
  PlotLegend legend = PlotLegend::kOutside;
};

struct PlotSize {
  int width_px = 800;  // of the whole image
  int height_px = 500;
  int columns = 1;  // of panels
};

// Draws the panels of one image, row by row, as SVG. Throws std::runtime_error
// with one line if gnuplot is missing or fails.
std::string RenderPlot(const std::vector<Plot>& panels,
                       const PlotSize& size = {});
void WritePlot(const std::vector<Plot>& panels, const std::string& path,
               const PlotSize& size = {});

// Throws the error of a missing gnuplot before any work is done.
void RequirePlotTool();

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_PLOT_H_
