#include "apps/common/plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <pugixml.hpp>
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
  PlotSeries line = {"Butterworth_2",
                     PlotStyle::kLinePoints,
                     {1.0, 2.0, 3.0, 4.0},
                     {4.0, kNan, 2.0, 3.0}};
  line.y_low = {3.0, kNan, 1.5, kNan};
  line.y_high = {5.0, kNan, 2.5, kNan};
  PlotSeries points = {
      "Savitzky & Golay", PlotStyle::kPoints, {1.5, 2.5}, {1.0, 2.0}};
  points.x_low = {1.0, 2.0};
  points.x_high = {2.0, 3.0};
  plot.series = {line, points};
  return plot;
}

bool IsXml(const std::string& text) {
  return pugi::xml_document().load_string(text.c_str());
}

class PlotTest : public ::testing::Test {
 protected:
  static void ExpectTexts(const std::string& svg,
                          const std::vector<std::string>& texts) {
    for (const std::string& text : texts) EXPECT_THAT(svg, HasSubstr(text));
  }
  void SetUp() override {
    if (std::system("command -v gnuplot > /dev/null") != 0) {
      GTEST_SKIP() << "gnuplot is not installed";
    }
  }
};

TEST_F(PlotTest, WritesTheSameSvgEachTime) {
  const testing::TemporaryFolder folder;
  const std::string path = (folder.path() / "plot.svg").string();
  WritePlot({SamplePlot()}, path);
  const std::string svg = testing::ContentOf(path);
  EXPECT_TRUE(IsXml(svg));
  ExpectTexts(svg, {"<svg", "Error &amp; 'lag' &lt;of", "cut-off [Hz]",
                    "error [px]", "Butterworth_2", "Savitzky &amp; Golay"});
  EXPECT_THAT(svg, Not(HasSubstr("NaN")));
  EXPECT_EQ(svg, RenderPlot({SamplePlot()}));
}

TEST_F(PlotTest, DrawsPanelsBarsAndNamesOnBothAxes) {
  Plot named;
  named.title = "Strategies";
  named.y.categories = {"raw DLT", "batch"};
  named.x.log = true;
  PlotSeries points = {"", PlotStyle::kPoints, {0.1, 10.0}, {0, 1}};
  points.x_low = {-1.0, 5.0};  // cannot be drawn on a log axis
  points.x_high = {1.0, 20.0};
  named.series = {points};
  Plot bars;
  bars.x.categories = {"trunk", "wrist", "ankle"};
  bars.series = {{"rough", PlotStyle::kBars, {0, 1, 2}, {1, 2, 3}},
                 {"smooth", PlotStyle::kBars, {0, 1, 2}, {1, 2, 3}}};
  Plot empty;
  empty.title = "Nothing";
  Plot without_values = SamplePlot();
  without_values.series[0].y.assign(4, kNan);
  const std::string svg = RenderPlot(
      {named, SamplePlot(), bars, empty, without_values}, {900, 900, 2});
  EXPECT_TRUE(IsXml(svg));
  ExpectTexts(svg, {"Strategies", "raw DLT", "batch", "Butterworth_2", "trunk",
                    "wrist", "ankle", "rough", "smooth"});
}

TEST(Plot, MissingGnuplotIsAOneLineError) {
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
