// Small files that accompany a recording.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "core/io/configuration/recording_files.h"
#include "tests/core/io/input_error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::TemporaryFolder;

TEST(ReadHeldOutSet, CamerasBecomeViews) {
  const TemporaryFolder folder;
  const auto write = [&](const std::string& camera) {
    return folder.Write("set.json",
                        R"({"confidence_at_least": 0.3, "cap_px": 100, )"
                        R"("pairing_gate_m": 0.5, "set": [{"camera": )" +
                            camera +
                            R"(, "frame": 1, "detection": 0, "person": 0}]})");
  };
  const auto view = [&](const std::string& camera,
                        const std::vector<std::string>& views) {
    return ReadHeldOutSet(write(camera), views).detections[0].view_name;
  };
  EXPECT_EQ(view("4", {}), "4");
  EXPECT_EQ(view("\"left\"", {}), "left");
  EXPECT_EQ(view("4", {"cam4", "cam14"}), "cam4");
  EXPECT_EQ(view("4", {"cam04", "4"}), "4");
  EXPECT_EQ(view("\"left\"", {"right", "left"}), "left");
  EXPECT_THROW(view("4", {"cam04", "cam4"}), InputError);
  EXPECT_THROW(view("5", {"cam4"}), InputError);
  EXPECT_THROW(view("\"left\"", {"right"}), InputError);
  EXPECT_THROW(view("-1", {}), InputError);
  EXPECT_THROW(view("null", {}), InputError);
}

TEST(ViewBiasFileTest, IsReadBackExactly) {
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

TEST(ViewBiasFileTest, ErrorsNameTheFault) {
  TemporaryFolder folder;
  const auto message = [&](const std::string& text) {
    const std::string path = folder.Write("take.bias.json", text);
    return InputErrorOf([&] { ReadViewBias(path); });
  };
  EXPECT_THAT(message("{\"kinegraph_bias\": 2}"), HasSubstr("expected 1"));
  EXPECT_THAT(message("{\"kinegraph_bias\": 1, \"azimuth_deg\": 1}"),
              HasSubstr("joints"));
  const std::string few = message(
      "{\"kinegraph_bias\": 1, \"azimuth_deg\": 1, \"joints\": [{\"joint\": "
      "\"hip\", \"used\": true, \"observations\": 1, \"gain\": 0, "
      "\"gain_error\": 0, \"across_m\": [1, 2], \"along_m\": []}]}");
  EXPECT_THAT(few, HasSubstr("expected 10 numbers"));
  EXPECT_THAT(few, HasSubstr("take.bias.json"));
}

}  // namespace
}  // namespace kinegraph
