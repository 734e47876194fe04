#include "apps/common/plot.h"

#include <fmt/format.h>
#include <glog/logging.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/files/atomic_file.h"
#include "core/system/process.h"

namespace kinegraph {
namespace {

// Okabe and Ito's palette. Yellow is last and only used on request, because it
// is hard to see on white.
const char* const kColours[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                "#E69F00", "#56B4E9", "#000000", "#F0E442"};
constexpr int kColourCount = 8;
constexpr int kCycledColours = kColourCount - 1;
// gnuplot's point types: filled circle, square, triangle, diamond and so on.
constexpr int kMarks[] = {7, 5, 9, 13, 11, 15, 6, 4, 8, 12};
constexpr int kMarkCount = 10;
constexpr size_t kCloud = 300;  // larger clouds are drawn as dots
// Relative to the distance between two categories.
constexpr double kBarGroupWidth = 0.8;

std::string Number(double value) { return fmt::format("{:.10g}", value); }

// Quotes a text for gnuplot's single quotes, in which only the quote is
// special.
std::string Quote(const std::string& text) {
  std::string quoted = "'";
  for (const char c : Printable(text, 200)) {
    quoted += c;
    if (c == '\'') quoted += c;
  }
  return quoted + "'";
}

bool Shown(const PlotAxis& axis, double value) {
  return std::isfinite(value) && (!axis.log || value > 0.0);
}

// gnuplot cannot choose the range of a plot without points.
std::string Range(const PlotAxis& axis, bool any_point, bool downwards) {
  std::optional<double> low = axis.low;
  std::optional<double> high = axis.high;
  if (!any_point) {
    low = low.value_or(1.0);
    high = high.value_or(10.0);
  }
  if (!axis.categories.empty()) {
    low = low.value_or(-0.6);
    high = high.value_or(static_cast<double>(axis.categories.size()) - 0.4);
  }
  if (downwards) std::swap(low, high);
  return fmt::format("[{}:{}]", low ? Number(*low) : "*",
                     high ? Number(*high) : "*");
}

bool AnyPoint(const Plot& plot) {
  for (const PlotSeries& series : plot.series) {
    for (size_t i = 0; i < series.x.size(); ++i) {
      if (Shown(plot.x, series.x[i]) && Shown(plot.y, series.y[i])) return true;
    }
  }
  return false;
}

void SetAxis(const std::string& name, const PlotAxis& axis, bool any_point,
             std::string* script) {
  const bool vertical = name == "y";
  *script += fmt::format(
      "set {0}label {1}\n{2} {0}\nset {0}range {3}\n", name, Quote(axis.label),
      axis.log ? "set logscale" : "unset logscale",
      Range(axis, any_point, vertical && !axis.categories.empty()));
  // Tilted labels avoid overlaps between many or long categories.
  size_t letters = 0;
  for (const std::string& category : axis.categories) {
    letters += category.size() + 2;
  }
  const bool tilted = !vertical && letters > 70;
  std::vector<std::string> names;
  for (const std::string& category : axis.categories) {
    names.push_back(fmt::format("{} {}", Quote(category), names.size()));
  }
  *script += fmt::format(
      "set {}tics {}{} {}\n", name, tilted ? "rotate by -35 left" : "norotate",
      tilted || vertical ? "" : " center",
      names.empty() ? "autofreq" : fmt::format("({})", fmt::join(names, ", ")));
}

// The gnuplot commands and data of one series; bars of several series are drawn
// side by side.
class SeriesScript {
 public:
  // `block` is the name of its data block; `bar`: its index among `bars`.
  SeriesScript(const Plot& plot, const PlotSeries& series, std::string block,
               int index, int bar, int bars)
      : plot_(plot),
        series_(series),
        block_("$" + std::move(block)),
        colour_(series.colour.value_or(index % kCycledColours)),
        dotted_(!series.colour && index >= kCycledColours),
        mark_(kMarks[series.colour.value_or(index) % kMarkCount]),
        bar_width_(kBarGroupWidth / std::max(1, bars)),
        shift_(series.style == PlotStyle::kBars
                   ? (bar - 0.5 * (bars - 1)) * bar_width_
                   : 0.0) {
    const size_t count = series.x.size();
    CHECK_EQ(series.y.size(), count) << "series " << series.name;
    for (const auto* ends :
         {&series.x_low, &series.x_high, &series.y_low, &series.y_high}) {
      CHECK(ends->empty() || ends->size() == count) << "ends " << series.name;
    }
  }

  // Rows of x, y, x_low, x_high, y_low, y_high.
  std::string Data() const {
    std::string data = block_ + " << EOD\n";
    for (size_t i = 0; i < series_.x.size(); ++i) {
      const double x = series_.x[i] + shift_;
      const double y = series_.y[i];
      if (!Shown(plot_.x, x) || !Shown(plot_.y, y)) {
        data += "\n";  // an empty line interrupts the curve
        continue;
      }
      data += fmt::format("{} {} {} {} {} {}\n", Number(x), Number(y),
                          End(plot_.x, series_.x_low, i, x),
                          End(plot_.x, series_.x_high, i, x),
                          End(plot_.y, series_.y_low, i, y),
                          End(plot_.y, series_.y_high, i, y));
    }
    return data + "EOD\n";
  }

  // Elements of the plot command.
  std::vector<std::string> Elements() const {
    const std::string colour =
        fmt::format(" lc rgb '{}'", kColours[colour_ % kColourCount]);
    std::vector<std::string> elements = {
        block_ + " using 1:2" + With() + colour +
        (series_.style == PlotStyle::kBars ? " fs solid 0.85 noborder" : "") +
        (series_.name.empty() ? " notitle" : " title " + Quote(series_.name))};
    // Drawn as vectors: gnuplot's own error bars leave a gap in their middle.
    const std::string bar =
        " with vectors heads size screen 0.004,90 lw 1.5" +
        (series_.style == PlotStyle::kBars ? " lc rgb '#000000'" : colour) +
        " notitle";
    if (!series_.x_low.empty()) {
      elements.push_back(block_ + " using 3:2:($4-$3):(0)" + bar);
    }
    if (!series_.y_low.empty()) {
      elements.push_back(block_ + " using 1:5:(0):($6-$5)" + bar);
    }
    return elements;
  }

 private:
  std::string With() const {
    const int dash = series_.dashed ? 2 : dotted_ ? 4 : 1;
    switch (series_.style) {
      case PlotStyle::kBars:
        return ":(" + Number(bar_width_) + ") with boxes";
      case PlotStyle::kLine:
        return fmt::format(" with lines lw 2 dt {}", dash);
      case PlotStyle::kPoints:
        // In a cloud, overlapping dots show density.
        return series_.x.size() > kCloud
                   ? " with points ps 0.25 pt 7"
                   : fmt::format(" with points ps 0.9 pt {}", mark_);
      case PlotStyle::kLinePoints:
        return fmt::format(" with linespoints lw 2 ps 0.8 dt {} pt {}", dash,
                           mark_);
    }
    return "";
  }

  static std::string End(const PlotAxis& axis, const std::vector<double>& ends,
                         size_t i, double value) {
    if (ends.empty() || std::isnan(ends[i])) return "NaN";
    // An end that a log axis cannot show is clipped at a tenth of the value.
    if (!Shown(axis, ends[i])) return Number(0.1 * value);
    return Number(ends[i]);
  }

  const Plot& plot_;
  const PlotSeries& series_;
  std::string block_;
  int colour_;
  bool dotted_;  // the colours have all been used
  int mark_;
  double bar_width_;
  double shift_;
};

// Zero, or nullopt if bars go below it: gnuplot then includes zero itself.
std::optional<double> LeastBarEnd(const Plot& plot) {
  for (const PlotSeries& series : plot.series) {
    for (const auto* values : {&series.y, &series.y_low}) {
      for (const double value : *values) {
        if (value < 0.0) return std::nullopt;
      }
    }
  }
  return 0.0;
}

void AddPanel(const Plot& plot, size_t panel, std::string* script) {
  const int bars = static_cast<int>(std::count_if(
      plot.series.begin(), plot.series.end(),
      [](const PlotSeries& s) { return s.style == PlotStyle::kBars; }));
  std::vector<std::string> elements;
  int bar = 0;
  for (size_t s = 0; s < plot.series.size(); ++s) {
    const SeriesScript series(
        plot, plot.series[s],
        "data_" + std::to_string(panel) + "_" + std::to_string(s),
        static_cast<int>(s), bar, bars);
    if (plot.series[s].style == PlotStyle::kBars) ++bar;
    *script += series.Data();
    for (std::string& element : series.Elements()) {
      elements.push_back(std::move(element));
    }
  }
  *script += "set title " + Quote(plot.title) + "\n";
  SetAxis("x", plot.x, AnyPoint(plot), script);
  PlotAxis y = plot.y;
  // Bars are compared by length, so they start at zero.
  if (bars > 0 && !y.low && !y.log) y.low = LeastBarEnd(plot);
  SetAxis("y", y, AnyPoint(plot), script);
  // One gnuplot command per PlotLegend, in its order.
  constexpr const char* kKeys[] = {
      "unset key", "set key on inside top right vertical Left reverse",
      "set key on outside right top vertical Left reverse",
      "set key on outside bottom center horizontal Left reverse"};
  // gnuplot rejects an empty list.
  if (elements.empty()) elements.push_back("NaN notitle");
  *script += fmt::format("{}\nplot {}\n", kKeys[static_cast<int>(plot.legend)],
                         fmt::join(elements, ", \\\n  "));
}

std::string Script(const std::vector<Plot>& panels, const PlotSize& size) {
  const int count = static_cast<int>(panels.size());
  const int columns = std::min(std::max(1, size.columns), count);
  const int rows = (count + columns - 1) / columns;
  std::string script = fmt::format(
      "set encoding utf8\n"
      "set terminal svg size {},{} dynamic noenhanced font 'sans-serif,12' "
      "background '#FFFFFF' name 'kinegraph'\n"
      "set border 3 lc rgb '#444444'\n"
      "set tics nomirror out\n"
      "set grid lc rgb '#DDDDDD' dt 1 lw 0.5\n"
      "set bars small\n",
      size.width_px, size.height_px);
  if (count > 1) {
    script += fmt::format("set multiplot layout {},{}\n", rows, columns);
  }
  for (size_t p = 0; p < panels.size(); ++p) AddPanel(panels[p], p, &script);
  if (count > 1) script += "unset multiplot\n";
  return script;
}

// Replaces gnuplot's generic image title, which browsers show and screen
// readers read, by the title of the plot.
std::string WithTitle(std::string svg, const std::string& title) {
  const std::string standard = "<title>Gnuplot</title>";
  const size_t at = svg.find(standard);
  if (at == std::string::npos) return svg;
  return svg.replace(at, standard.size(),
                     "<title>" + HtmlText(Printable(title, 200)) + "</title>");
}

// ---- Running gnuplot ----

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using PlotFile = std::unique_ptr<std::FILE, FileCloser>;

PlotFile TemporaryFile() {
  PlotFile file(std::tmpfile());
  if (file == nullptr) {
    throw std::runtime_error("no temporary file for a plot: " +
                             std::string(std::strerror(errno)));
  }
  return file;
}

std::string AllOf(const PlotFile& file) {
  std::rewind(file.get());
  std::string content;
  char buffer[1 << 14];
  size_t size;
  while ((size = std::fread(buffer, 1, sizeof(buffer), file.get())) > 0) {
    content.append(buffer, size);
  }
  return content;
}

// The output of gnuplot for `script`, run without the user's settings. Throws
// std::runtime_error if it is not installed or fails.
std::string RunGnuplot(const std::string& script) {
  const PlotFile input = TemporaryFile();
  const PlotFile output = TemporaryFile();
  const PlotFile errors = TemporaryFile();
  std::fwrite(script.data(), 1, script.size(), input.get());
  std::fflush(input.get());
  std::rewind(input.get());

  // No start-up files; decimal points as in C.
  const ProcessEnd end =
      RunWithStreams({"gnuplot", "-d", "-"}, input.get(), output.get(),
                     errors.get(), "LC_ALL=C.UTF-8");
  if (end.not_started != 0) {
    throw std::runtime_error(
        "plots need gnuplot (Debian: gnuplot-nox), which cannot be started: " +
        std::string(std::strerror(end.not_started)));
  }
  const std::string complaints = AllOf(errors);
  if (!end.well()) {
    throw std::runtime_error("gnuplot failed: " + Printable(complaints, 300));
  }
  return AllOf(output);
}

}  // namespace

std::string RenderPlot(const std::vector<Plot>& panels, const PlotSize& size) {
  CHECK(!panels.empty());
  return WithTitle(RunGnuplot(Script(panels, size)), panels.front().title);
}

void WritePlot(const std::vector<Plot>& panels, const std::string& path,
               const PlotSize& size) {
  WriteTextFile(path, RenderPlot(panels, size));
}

void RequirePlotTool() { RunGnuplot("exit\n"); }

}  // namespace kinegraph
