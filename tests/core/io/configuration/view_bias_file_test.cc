#include "core/io/configuration/view_bias_file.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/core/io/input_error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::InputErrorOf;
using testing::TemporaryFolder;

TEST(ViewBiasFileTest, RoundTrip) {
  ViewBias bias;
  bias.azimuth_deg = 285.0;
  ViewBias::OfJoint& hip = bias.joints.emplace_back();
  hip.joint = "hip";
  hip.used = true;
  hip.observations = 4711;
  hip.gain = 0.25;
  hip.gain_error = 1.0 / 3.0;
  hip.across_m[3] = -0.1;
  hip.along_m[9] = 1e-17;
  TemporaryFolder folder;
  const std::string path = (folder.path() / "take.bias.json").string();
  WriteViewBias(path, bias);
  const ViewBias read = ReadViewBias(path);
  EXPECT_EQ(read.azimuth_deg, 285.0);
  ASSERT_EQ(read.joints.size(), 1u);
  EXPECT_EQ(read.joints[0].joint, "hip");
  EXPECT_TRUE(read.joints[0].used);
  EXPECT_EQ(read.joints[0].observations, 4711);
  EXPECT_EQ(read.joints[0].gain, 0.25);
  EXPECT_EQ(read.joints[0].gain_error, 1.0 / 3.0);
  EXPECT_EQ(read.joints[0].across_m, hip.across_m);
  EXPECT_EQ(read.joints[0].along_m, hip.along_m);
}

TEST(ViewBiasFileTest, WrongFilesAreNamed) {
  TemporaryFolder folder;
  const auto message = [&](const std::string& text) {
    const std::string path = folder.Write("take.bias.json", text);
    return InputErrorOf([&] { ReadViewBias(path); });
  };
  EXPECT_NE(message("{\"kinegraph_bias\": 2}").find("expected 1"),
            std::string::npos);
  EXPECT_NE(
      message("{\"kinegraph_bias\": 1, \"azimuth_deg\": 1}").find("joints"),
      std::string::npos);
  const std::string few = message(
      "{\"kinegraph_bias\": 1, \"azimuth_deg\": 1, \"joints\": [{\"joint\": "
      "\"hip\", \"used\": true, \"observations\": 1, \"gain\": 0, "
      "\"gain_error\": 0, \"across_m\": [1, 2], \"along_m\": []}]}");
  EXPECT_NE(few.find("expected 10 numbers"), std::string::npos) << few;
  EXPECT_NE(few.find("take.bias.json"), std::string::npos) << few;
}

}  // namespace
}  // namespace kinegraph
