#include "core/io/configuration/held_out_set.h"

#include <gtest/gtest.h>

#include <string>

#include "core/base/error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

TEST(ReadHeldOutSet, CamerasBecomeViews) {
  const testing::TemporaryFolder folder;
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

}  // namespace
}  // namespace kinegraph
