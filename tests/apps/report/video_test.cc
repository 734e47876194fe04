// Videos behind the panels, in a real browser: after any jump the displayed
// image is that of the frame.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/report/page.h"
#include "apps/report/page_data.h"
#include "apps/report/view_images.h"
#include "core/base/error.h"
#include "core/io/files/text_file.h"
#include "tests/support/browser.h"
#include "tests/support/rig.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::Browser;
using ::testing::HasSubstr;

constexpr int kFirstPicture = 100;
// Two more than the images of the video.
constexpr int kPictures = 42;

// A recording without people, so that nothing is drawn over the images.
PageInput EmptyRecording() {
  PageInput input;
  input.title = "take";
  input.cameras = testing::RingOfCameras(2);
  TrackSequence tracks;
  tracks.header.skeleton = Coco17();
  tracks.header.view_names = {"one", "two"};
  tracks.header.frame_rate_hz = 30.0;
  for (int f = 0; f < kPictures; ++f) {
    TrackFrame frame;
    frame.frame = kFirstPicture + f;
    // The tracks state 30 Hz; the videos have 29.97 Hz.
    frame.time = FrameClock(30.0).TimeOf(frame.frame);
    tracks.frames.push_back(frame);
  }
  input.results.push_back({"take", ResultRole::kTracks, tracks});
  input.detections = testing::SeenBy(input.cameras, 0,
                                     [](int) { return std::vector<Pose3d>(); });
  input.detections->header.view_names = {"one", "two"};
  return input;
}

std::string Bars(const std::string& ending) {
  return testing::ProjectFile("tests/apps/report/videos/bars." + ending)
      .string();
}

std::string ImagesFlag() {
  const std::string first = "@" + std::to_string(kFirstPicture);
  return "one=" + Bars("mp4") + first + ";two=" + Bars("webm") + first;
}

class VideoPanels : public ::testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    if (!Browser::IsInstalled()) {
      GTEST_SKIP() << "needs a browser: apt-get install chromium";
    }
    const bool embedded = GetParam();
    PageInput input = EmptyRecording();
    const std::string path = (folder_.path() / "page.html").string();
    AddVideos(ReadViewImages(ImagesFlag(), input), path, embedded ? 100000 : 0,
              &input);
    folder_.Write("page.html", MakePage(input.title, MakePageData(input).json));
    browser_ = std::make_unique<Browser>();
    browser_->Open(path);
    ASSERT_TRUE(browser_->WaitFor("window.kinegraph"));
    // Panels are filled once they are scrolled into view.
    browser_->MiddleOf("figure canvas");
    ASSERT_TRUE(
        browser_->WaitFor("kinegraph.panels.every((panel) => panel.seen &&"
                          "panel.video.node.readyState >= 2)"));
  }

  // Waits until both videos are at their positions.
  void WaitUntilThere() {
    EXPECT_TRUE(browser_->WaitFor(
        "kinegraph.panels.every((panel) => !panel.video.node.seeking &&"
        "Math.abs(panel.video.node.currentTime -"
        "panel.video.at[kinegraph.state.frame]) < 1e-3)"));
    browser_->Evaluate(
        "(() => { window.enough = kinegraph.state.pictures + 3; })()");
    EXPECT_TRUE(browser_->WaitFor("kinegraph.state.pictures > enough"));
  }

  // The number shown by the image of a panel on the screen.
  int NumberOn(int panel) {
    const std::string path = (folder_.path() / "screen.png").string();
    browser_->MiddleOf("figure canvas");
    browser_->SaveScreenshot(path);
    // A page may not read a canvas with a linked video, but may read a
    // screenshot.
    browser_->Evaluate(
        "(() => { window.shot = undefined; const image = new Image();"
        "image.onload = () => { const canvas = document.createElement("
        "'canvas'); canvas.width = image.width; canvas.height = image.height;"
        "const pen = canvas.getContext('2d'); pen.drawImage(image, 0, 0);"
        "window.shot = pen; }; image.src = 'data:image/png;base64," +
        Base64(ReadBytes(path)) + "'; })()");
    EXPECT_TRUE(browser_->WaitFor("window.shot !== undefined"));
    // Panels cover images with 35 % white: black becomes 89, white stays 255.
    return browser_
        ->Evaluate(
            "(() => { const box = kinegraph.panels[" + std::to_string(panel) +
            "].canvas.getBoundingClientRect(); let number = 0;"
            "for (let column = 0; column < 8; ++column) { const x = box.left +"
            "box.width * (column + 0.5) / 8, y = box.top + box.height / 2;"
            "if (shot.getImageData(x, y, 1, 1).data[1] > 172)"
            "number += 1 << column; } return number; })()")
        .get<int>();
  }

  const testing::TemporaryFolder folder_;
  std::unique_ptr<Browser> browser_;
};

TEST_P(VideoPanels, ShowThePictureOfTheFrame) {
  for (const int f : {0, 1, 2, 7, 14, 15, 16, 31, 39, 38, 3}) {
    browser_->Evaluate("kinegraph.setFrame(" + std::to_string(f) + ")");
    WaitUntilThere();
    // A busy browser reports the position before it shows the image.
    constexpr int kTries = 20;
    for (int i = 0; i < kTries; ++i) {
      if (NumberOn(0) == f && NumberOn(1) == f) break;
    }
    EXPECT_EQ(NumberOn(0), f) << "MP4";
    EXPECT_EQ(NumberOn(1), f) << "WebM";
  }
  EXPECT_TRUE(browser_->problems().empty()) << browser_->problems().front();
}

TEST_P(VideoPanels, PlayWithTheFramesAndStopAtTheDisplayedFrame) {
  browser_->Evaluate("kinegraph.state.speed = 0.25");
  browser_->Click("#play");
  ASSERT_TRUE(browser_->WaitFor("kinegraph.state.frame >= 6"));
  EXPECT_EQ(browser_->Evaluate("kinegraph.panels[0].video.node.paused"), false);
  browser_->Click("#play");
  ASSERT_TRUE(browser_->WaitFor("!kinegraph.state.playing"));
  browser_->MiddleOf("figure canvas");
  WaitUntilThere();
  const int frame = browser_->Evaluate("kinegraph.state.frame");
  EXPECT_GE(frame, 6);
  EXPECT_EQ(NumberOn(0), frame);
  EXPECT_EQ(NumberOn(1), frame);
  EXPECT_EQ(browser_->Evaluate("kinegraph.panels[0].video.node.paused"), true);
}

TEST_P(VideoPanels, FramesBeyondTheVideoAreMarked) {
  browser_->Evaluate("kinegraph.setFrame(" + std::to_string(kPictures - 1) +
                     ")");
  EXPECT_THAT(browser_->Evaluate("kinegraph.panels[0].facts.textContent")
                  .get<std::string>(),
              HasSubstr("no image of this frame"));
  // The page may read embedded videos, which are therefore part of the saved
  // pictures, but not linked ones.
  browser_->Evaluate("kinegraph.setFrame(5)");
  WaitUntilThere();
  const std::string drawing = browser_->Evaluate("kinegraph.svgPicture()");
  EXPECT_EQ(drawing.find("data:image/jpeg") != std::string::npos, GetParam());
  EXPECT_EQ(drawing.find(".mp4"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Ways, VideoPanels, ::testing::Bool(),
                         [](const auto& test) {
                           return test.param ? "Embedded" : "Linked";
                         });

TEST(ViewImages, ErrorsNameTheCause) {
  PageInput input = EmptyRecording();
  const auto error_of = [&](const std::string& images) -> std::string {
    try {
      ReadViewImages(images, input);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(error_of(ImagesFlag()), "");
  EXPECT_THAT(error_of("one=" + Bars("mp4")),
              HasSubstr("has the frames 0..39, expected frame 100"));
  EXPECT_THAT(error_of("one=" + Bars("mp4") + "@1x"), HasSubstr("after @"));
  EXPECT_THAT(error_of("one=none.mp4"), HasSubstr("expected a video"));
  EXPECT_THAT(error_of("one=a.avi"), HasSubstr("do not play"));
  EXPECT_THAT(error_of("one=a.jpg"), HasSubstr("or a video"));
  EXPECT_THAT(error_of("three=a.mp4"), HasSubstr("with one of one, two"));
  const ViewImages images = ReadViewImages(ImagesFlag(), input);
  EXPECT_EQ(FramesWithout(*images.videos[0], input), 2u);
  try {
    AddVideos(images, "page.html", 1000, &input);
    ADD_FAILURE() << "not refused";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("does not fit into the page"));
  }
}

// Each of the 42 pictures has 40 bytes of text. Ten of them fit into 400 bytes:
// every fifth, nine in all.
TEST(EmbedPicturesTest, ProgressReachesTheNumberOfFrames) {
  const testing::TemporaryFolder folder;
  PageInput input = EmptyRecording();
  for (int f = 0; f < kPictures; ++f) {
    folder.Write(std::to_string(kFirstPicture + f) + ".jpg",
                 "\xff\xd8\xff" + std::string(27, 'x'));
  }
  std::vector<int64_t> steps;
  const EmbeddedPictures embedded = EmbedPictures(
      {(folder.path() / "%d.jpg").string(), ""}, 400,
      [&](int64_t frames) { steps.push_back(frames); }, &input);
  EXPECT_EQ(embedded.stride, 5);
  EXPECT_EQ(embedded.count, 9u);
  EXPECT_THAT(steps,
              ::testing::ElementsAre(5, 10, 15, 20, 25, 30, 35, 40, kPictures));
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
