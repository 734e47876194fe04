#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/io/calibration/calibration.h"
#include "core/io/text/json.h"
#include "tests/core/io/input_error.h"
#include "tests/support/base64.h"
#include "tests/support/opencap_pickles.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::ExpectInputError;
using testing::FromBase64;
using testing::InputErrorOf;
using testing::kOpencapProtocol2;
using testing::kOpencapProtocol5;
using testing::TemporaryFolder;

std::string Replaced(std::string text, const std::string& from,
                     const std::string& to) {
  for (size_t at = text.find(from); at != std::string::npos;
       at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
  return text;
}

void ExpectTheCamera(const CameraRig& cameras, const std::string& name) {
  ASSERT_EQ(cameras.size(), 1u);
  const Camera& camera = cameras.front();
  EXPECT_EQ(camera.name(), name);
  EXPECT_EQ(camera.width_px(), 1280);
  EXPECT_EQ(camera.height_px(), 720);
  Eigen::Matrix3d K;
  K << 1300.5, 0, 640.25, 0, 1301.5, 360.75, 0, 0, 1;
  EXPECT_EQ(camera.K(), K);
  Eigen::Matrix3d R;
  R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  EXPECT_EQ(camera.R(), R);
  // 100 / 1000 is rounded once.
  EXPECT_LT((camera.t() - Eigen::Vector3d(0.1, -0.2, 3.0)).norm(), 1e-15);
  ASSERT_NE(camera.lens(), nullptr);
  EXPECT_EQ(camera.lens()->parameters(),
            (std::vector<double>{0.1, -0.2, 0.001, -0.002, 0.05}));
}

TEST(OpenCapCalibration, IsReadInEveryProtocol) {
  const TemporaryFolder folder;
  for (const char* text : {kOpencapProtocol2, kOpencapProtocol5}) {
    const std::string path = folder.Write(
        "Cam0/cameraIntrinsicsExtrinsics.pickle", FromBase64(text));
    ExpectTheCamera(ReadCameras(path), "Cam0");
  }
}

// NumPy 2 calls its modules numpy._core; the names' lengths stand before them.
TEST(OpenCapCalibration, IsReadAsNumPy2WritesIt) {
  const TemporaryFolder folder;
  std::string bytes = FromBase64(kOpencapProtocol5);
  bytes = Replaced(bytes, std::string("\x8c\x12") + "numpy.core.numeric",
                   std::string("\x8c\x13") + "numpy._core.numeric");
  ASSERT_NE(bytes.find("numpy._core"), std::string::npos);
  ExpectTheCamera(ReadCameras(folder.Write("left.pickle", bytes)), "left");
}

TEST(OpenCapCalibration, ASessionIsAFolderACamera) {
  const TemporaryFolder folder;
  const std::string bytes = FromBase64(kOpencapProtocol2);
  for (const char* camera : {"Cam10", "Cam2", "Cam0"}) {
    folder.Write("session/Videos/" + std::string(camera) +
                     "/cameraIntrinsicsExtrinsics.pickle",
                 bytes);
  }
  folder.Write("session/Videos/mappingCamDevice.pickle", "anything");
  for (const char* where : {"session", "session/Videos"}) {
    const CameraRig cameras = ReadCameras(folder.path() / where);
    ASSERT_EQ(cameras.size(), 3u);
    EXPECT_EQ(cameras[0].name(), "Cam0");
    EXPECT_EQ(cameras[1].name(), "Cam2");
    EXPECT_EQ(cameras[2].name(), "Cam10");
  }
  CameraReadOptions metres;
  metres.unit = LengthUnit::kMetre;
  EXPECT_NEAR(ReadCameras(folder.path() / "session", metres)[0].t().z(), 3000.0,
              1e-12);
}

TEST(OpenCapCalibration, AFileOfTheLensAloneSaysSo) {
  const TemporaryFolder folder;
  const std::string path =
      folder.Write("cameraIntrinsics.pickle",
                   Replaced(FromBase64(kOpencapProtocol5), "\x8c\x08rotation",
                            "\x8c\x08_otation"));
  ExpectInputError([&] { ReadCameras(path); }, "has no rotation");
}

TEST(Pickle, ValuesOfPythonArePlain) {
  // {'a': [1, -2, 2.5, None, True, (b-less text 'x',)], 'big': -129}
  const std::string bytes = std::string(
                                "\x80\x02}(U\x01"
                                "a](K\x01J\xfe\xff\xff\xffG\x40\x04") +
                            std::string(6, '\0') + "N\x88X\x01" +
                            std::string(3, '\0') + "x\x85" +
                            "eU\x03"
                            "big\x8a\x02\x7f\xff"
                            "u.";
  EXPECT_EQ(ParsePickle(bytes, "f").dump(),
            R"({"a":[1,-2,2.5,null,true,["x"]],"big":-129})");
}

// {'columns': float32 by columns, 'size': int64, 'share': np.float64(0.5)} in
// protocol 4.
TEST(Pickle, ArraysAreRowsOfRows) {
  constexpr const char* kArrays =
      "gASVTwEAAAAAAAB9lCiMB2NvbHVtbnOUjBVudW1weS5jb3JlLm11bHRpYXJyYXmUjAxfcmVj"
      "b25zdHJ1Y3SUk5SMBW51bXB5lIwHbmRhcnJheZSTlEsAhZRDAWKUh5RSlChLAUsCSwOGlGgF"
      "jAVkdHlwZZSTlIwCZjSUiYiHlFKUKEsDjAE8lE5OTkr/////Sv////9LAHSUYohDGAAAgD8A"
      "AIBAAAAAQAAAoEAAAEBAAADAQJR0lGKMBHNpemWUaARoB0sAhZRoCYeUUpQoSwFLAoWUaA6M"
      "Amk4lImIh5RSlChLA2gSTk5OSv////9K/////0sAdJRiiUMQ0AIAAAAAAAAABQAAAAAAAJR0"
      "lGKMBXNoYXJllGgCjAZzY2FsYXKUk5RoDowCZjiUiYiHlFKUKEsDaBJOTk5K/////0r/////"
      "SwB0lGJDCAAAAAAAAOA/lIaUUpR1Lg==";
  EXPECT_EQ(ParsePickle(FromBase64(kArrays), "f").dump(),
            R"({"columns":[[1.0,2.0,3.0],[4.0,5.0,6.0]],)"
            R"("size":[720.0,1280.0],"share":0.5})");
}

TEST(Pickle, NothingIsExecuted) {
  const std::string two = "\x80\x02";
  const std::vector<std::pair<std::string, const char*>> attacks = {
      {two + "cos\nsystem\nU\x02ls\x85R.", "'os.system'"},
      {two + "c__builtin__\neval\nU\x01" + "1\x85R.", "'__builtin__.eval'"},
      {"\x80\x04\x8c\x05posix\x8c\x06system\x93\x8c\x02ls\x85R.",
       "'posix.system'"},
      {two + "cos\nsystem\n)\x81.", "instruction 129"},  // a class
      {two + "\x82\x01.", "instruction 130"},            // an extension
      {two + "Pname\n.", "instruction 80"},              // a persistent object
      {two + "}}\x85" + "b.", "state"},
      {two + "cnumpy.core.multiarray\n_reconstruct\n" +
           "cos\nsystem\nK\x01\x85U\x01" + "b\x87R.",  // a subclass
       "_reconstruct"},
      {two + "cos\nsystem\n.", "no number"},
      {two + "cnumpy\ndtype\nU\x02O8\x85R.", "no number"},
      {"print('x')", "no pickle"},
      {"(dp0\nS'a'\np1\n.", "no pickle"}};  // protocol 0
  for (const auto& [bytes, says] : attacks) {
    ExpectInputError([&bytes = bytes] { ParsePickle(bytes, "f"); }, says);
  }
}

// Bytes that a C string would end at.
std::string Bytes(std::initializer_list<int> codes) {
  std::string bytes;
  for (const int code : codes) bytes += static_cast<char>(code);
  return bytes;
}

TEST(Pickle, BrokenOnesEndWithAMessage) {
  const std::string whole = FromBase64(kOpencapProtocol2);
  for (size_t length = 0; length < whole.size(); ++length) {
    EXPECT_NE(InputErrorOf([&] { ParsePickle(whole.substr(0, length), "f"); }),
              "");
  }
  // A list in itself, a value that was never made, an empty stack, a huge text.
  for (const std::string& bytes :
       {Bytes({0x80, 2, ']', 'q', 0, 'h', 0, 'a', '.'}),
        Bytes({0x80, 2, 'h', 7, '.'}), Bytes({0x80, 2, '.'}),
        Bytes({0x80, 2, '(', '.'}), Bytes({0x80, 2, 'a', '.'}),
        Bytes({0x80, 4, 0x8d, 255, 255, 255, 255, 255, 255, 255, 255, '.'}),
        Bytes({0x80, 2, 0x8a, 200, '.'})}) {
    EXPECT_NE(InputErrorOf([&] { ParsePickle(bytes, "f"); }), "");
  }
}

// Twenty tuples, each twice the last, would be a million values.
TEST(Pickle, RepetitionIsBounded) {
  std::string bytes = Bytes({0x80, 2, 'K', 1});
  for (int i = 0; i < 30; ++i) {
    bytes += Bytes({'q', i, 'h', i, 0x86});
  }
  ExpectInputError([&] { ParsePickle(bytes + ".", "f"); }, "too many values");
}

}  // namespace
}  // namespace kinegraph
