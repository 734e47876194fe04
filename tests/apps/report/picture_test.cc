// Pictures: what is written comes back; what is no picture is refused.
#include "apps/report/picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "apps/report/view_images.h"
#include "core/base/error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::TemporaryFolder;

TEST(PictureTest, JpegComesBackAlmostTheSame) {
  Picture picture = MakePicture(64, 48, {40, 120, 200});
  Pen(&picture).Disc({20.0, 20.0}, 9.0, {250, 250, 10});
  const TemporaryFolder folder;
  const std::string path = folder.Write("a.jpg", EncodeJpeg(picture, 95));
  const Picture back = ReadPicture(path);
  ASSERT_EQ(back.width, 64);
  ASSERT_EQ(back.height, 48);
  // Far from the edge of the disc JPEG changes a colour by a few steps.
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(back.At(20, 20)[c], picture.At(20, 20)[c], 8);
    EXPECT_NEAR(back.At(60, 44)[c], picture.At(60, 44)[c], 8);
  }
}

TEST(PictureTest, ScalingDownKeepsTheMean) {
  Picture picture = MakePicture(100, 50, {});
  for (int y = 0; y < 50; ++y) {
    for (int x = 0; x < 100; ++x) picture.At(x, y)[0] = x % 2 == 0 ? 0 : 200;
  }
  const Picture small = ScaledDown(picture, 50);
  ASSERT_EQ(small.width, 50);
  ASSERT_EQ(small.height, 25);
  for (int x = 0; x < 50; ++x) EXPECT_EQ(small.At(x, 7)[0], 100);
  EXPECT_EQ(ScaledDown(picture, 400).width, 100) << "never up";
}

TEST(PictureTest, WhatIsBrokenIsRefusedByName) {
  const TemporaryFolder folder;
  const std::string whole = EncodeJpeg(MakePicture(32, 32, {9, 9, 9}), 80);
  for (const std::string& bytes :
       {std::string("no picture"), std::string("\xff\xd8\xff"),
        whole.substr(0, 60), std::string("\x89PNG\r\n\x1a\nrest")}) {
    const std::string path = folder.Write("x.jpg", bytes);
    try {
      ReadPicture(path);
      FAIL() << "was read";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr("x.jpg"));
    }
  }
}

TEST(PenTest, ALineCoversItsPixelsAndStaysInside) {
  Picture picture = MakePicture(20, 20, {});
  Pen pen(&picture);
  pen.Line({2.0, 10.0}, {1000.0, 10.0}, {{255, 255, 255}, 3.0, 1.0});
  for (int x = 3; x < 20; ++x) {
    EXPECT_EQ(picture.At(x, 10)[0], 255);
    EXPECT_EQ(picture.At(x, 11)[0], 255) << "half of 3 px and a soft edge";
    EXPECT_EQ(picture.At(x, 13)[0], 0);
  }
  pen.Line({-1e9, -1e9}, {-1e8, -1e8}, {{255, 0, 0}, 3.0, 1.0});
  pen.Number(-120, {-50.0, 500.0}, 12.0, {1, 2, 3}, {4, 5, 6});
}

TEST(PicturePathTest, TakesOneNumber) {
  EXPECT_EQ(PicturePath("a/%06d.jpg", 42), "a/000042.jpg");
  EXPECT_EQ(PicturePath("%d", 1234567), "1234567");
  for (const char* pattern : {"a.jpg", "%s", "%d%d", "%", "100%"}) {
    EXPECT_THROW(PicturePath(pattern, 1), InputError) << pattern;
  }
}

}  // namespace
}  // namespace kinegraph
