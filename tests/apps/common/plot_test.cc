#include "apps/common/plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/constants.h"
#include "tests/support/program.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Plot SamplePlot() {
  Plot plot;
  plot.title = "Error & 'lag' <of> {filters}_1";
  plot.x.label = "cut-off [Hz]";
  plot.y.label = "error [px]";
  PlotSeries line;
  line.name = "Butterworth_2";
  line.style = PlotStyle::kLinePoints;
  line.x = {1.0, 2.0, 3.0, 4.0};
  line.y = {4.0, kNan, 2.0, 3.0};
  line.y_low = {3.0, kNan, 1.5, kNan};
  line.y_high = {5.0, kNan, 2.5, kNan};
  line.labels = {"first \"point\"", "", "", "last"};
  PlotSeries points;
  points.name = "Savitzky & Golay";
  points.style = PlotStyle::kPoints;
  points.x = {1.5, 2.5};
  points.y = {1.0, 2.0};
  points.x_low = {1.0, 2.0};
  points.x_high = {2.0, 3.0};
  plot.series = {line, points};
  return plot;
}

// Elements opened and closed, attributes quoted, no stray "&": enough of XML to
// catch a label that was not escaped.
::testing::AssertionResult IsXml(const std::string& text) {
  std::vector<std::string> open;
  size_t at = 0;
  while ((at = text.find('<', at)) != std::string::npos) {
    const size_t end = text.find('>', at);
    if (end == std::string::npos) {
      return ::testing::AssertionFailure() << "'<' without '>' at " << at;
    }
    const std::string tag = text.substr(at + 1, end - at - 1);
    at = end + 1;
    if (tag.empty()) return ::testing::AssertionFailure() << "an empty tag";
    if (tag[0] == '?' || tag[0] == '!' || tag.back() == '/') continue;
    const std::string name =
        tag.substr(tag[0] == '/' ? 1 : 0,
                   tag.find_first_of(" \t\n", 1) - (tag[0] == '/' ? 1 : 0));
    if (tag[0] != '/') {
      open.push_back(name);
    } else if (open.empty() || open.back() != name) {
      return ::testing::AssertionFailure() << "stray </" << name << ">";
    } else {
      open.pop_back();
    }
  }
  if (!open.empty()) {
    return ::testing::AssertionFailure() << "<" << open.back() << "> is open";
  }
  for (at = 0; (at = text.find('&', at)) != std::string::npos; ++at) {
    const size_t end = text.find(';', at);
    if (end == std::string::npos || end - at > 8) {
      return ::testing::AssertionFailure() << "stray & at " << at;
    }
  }
  return ::testing::AssertionSuccess();
}

class PlotTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::system("command -v gnuplot > /dev/null") != 0) {
      GTEST_SKIP() << "gnuplot is not installed";
    }
  }
};

TEST_F(PlotTest, WritesSvgWithItsTexts) {
  const testing::TemporaryFolder folder;
  const std::string path = (folder.path() / "plot.svg").string();
  WritePlot({SamplePlot()}, path);
  const std::string svg = testing::ContentOf(path);
  EXPECT_TRUE(IsXml(svg));
  for (const char* text :
       {"<svg", "Error &amp; 'lag' &lt;of", "cut-off [Hz]", "error [px]",
        "Butterworth_2", "Savitzky &amp; Golay", "first 'point'"}) {
    EXPECT_THAT(svg, HasSubstr(text));
  }
  EXPECT_THAT(svg, Not(HasSubstr("NaN")));
}

TEST_F(PlotTest, GivesTheSameBytesAgain) {
  EXPECT_EQ(RenderPlot({SamplePlot()}), RenderPlot({SamplePlot()}));
}

TEST_F(PlotTest, DrawsBarsOfCategoriesSideBySide) {
  Plot plot;
  plot.title = "By joint class";
  plot.x.categories = {"trunk", "wrist", "ankle"};
  for (const char* name : {"raw", "smooth"}) {
    PlotSeries bars;
    bars.name = name;
    bars.style = PlotStyle::kBars;
    bars.x = {0, 1, 2};
    bars.y = {1, 2, 3};
    plot.series.push_back(bars);
  }
  const std::string svg = RenderPlot({plot});
  EXPECT_TRUE(IsXml(svg));
  for (const char* text : {"trunk", "wrist", "ankle", "raw", "smooth"}) {
    EXPECT_THAT(svg, HasSubstr(text));
  }
}

TEST_F(PlotTest, DrawsPanelsAndNamesOnBothAxes) {
  Plot named;
  named.title = "Strategies";
  named.y.categories = {"raw DLT", "batch"};
  named.x.log = true;
  PlotSeries points;
  points.style = PlotStyle::kPoints;
  points.x = {0.1, 10.0};
  points.y = {0, 1};
  points.x_low = {-1.0, 5.0};  // no place on a log axis
  points.x_high = {1.0, 20.0};
  named.series = {points};
  Plot empty;
  empty.title = "Nothing";
  const std::string svg =
      RenderPlot({named, SamplePlot(), empty}, {900, 900, 2});
  EXPECT_TRUE(IsXml(svg));
  for (const char* text : {"Strategies", "raw DLT", "batch", "Butterworth_2"}) {
    EXPECT_THAT(svg, HasSubstr(text));
  }
}

TEST_F(PlotTest, TakesASeriesWithoutAnyValue) {
  Plot plot = SamplePlot();
  plot.series[0].y.assign(4, kNan);
  EXPECT_TRUE(IsXml(RenderPlot({plot})));
}

TEST(Plot, SaysInOneLineThatGnuplotIsMissing) {
  const char* const path = std::getenv("PATH");
  const std::string kept = path == nullptr ? "" : path;
  ASSERT_EQ(setenv("PATH", "/nowhere", 1), 0);
  std::string message;
  try {
    RequirePlotTool();
  } catch (const std::runtime_error& error) {
    message = error.what();
  }
  setenv("PATH", kept.c_str(), 1);
  EXPECT_THAT(message, HasSubstr("gnuplot-nox"));
  EXPECT_THAT(message, Not(HasSubstr("\n")));
}

}  // namespace
}  // namespace kinegraph
