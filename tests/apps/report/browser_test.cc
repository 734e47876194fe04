// The page in a real browser, operated by keys, mouse and touch, on screens
// from phone to desktop.
#include "tests/support/browser.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/report/page.h"
#include "apps/report/page_data.h"
#include "core/base/error.h"
#include "core/io/files/text_file.h"
#include "tests/support/rig.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::Browser;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::PagePoint;
using testing::Screen;

constexpr const char* kHostile = "</script><img src=x onerror='hacked=1'>";

constexpr Screen kDesk = {1400, 1000, 1.0, false};
// A common phone: 390 x 844 CSS pixels, at a device pixel ratio of 3.
constexpr Screen kPhone = {390, 844, 3.0, true};
constexpr Screen kPhoneOnItsSide = {844, 390, 3.0, true};
constexpr Screen kSmallPhone = {320, 640, 2.0, true};
constexpr Screen kTablet = {768, 1024, 2.0, true};

constexpr int kFrames = 100;
constexpr int kFirstFrame = 300;
constexpr int kJumpFrame = 342;  // of person 0's left wrist
constexpr size_t kLeftWrist = 9;
constexpr size_t kRightWrist = 10;
const Eigen::Vector3d kSigmaM(0.02, 0.03, 0.04);
const Eigen::Vector2d kShiftPx(70.0, 0.0);  // of a joint that is rejected

// Three people who walk side by side; person 2 is absent after 60 frames. Four
// views: in view 0 a wrist of person 0 is an outlier, one of person 1 was not
// found, and there is an unmatched detection; view 1 misses person 2.
struct Recording {
  TrackSequence tracks;
  DetectionSequence detections;
  CameraRig cameras = testing::RingOfCameras(4);
};

Recording MakeRecording() {
  Recording recording;
  TrackHeader& header = recording.tracks.header;
  header.skeleton = Coco17();
  header.view_names = {kHostile, "two", "three", "four"};
  recording.detections.header.skeleton = Coco17();
  recording.detections.header.view_names = header.view_names;
  for (int f = 0; f < kFrames; ++f) {
    TrackFrame frame;
    frame.frame = kFirstFrame + f;
    frame.time = FrameClock(25.0).TimeOf(frame.frame);
    DetectionFrame seen;
    seen.frame = frame.frame;
    seen.views.resize(recording.cameras.size());
    for (int p = 0; p < (f < 60 ? 3 : 2); ++p) {
      PersonPose person;
      person.id = TrackId(p);
      person.joints = testing::StandingPerson(0.02 * f - 1.0, p - 1.0);
      person.joints[3].status = JointStatus::kInferred;
      person.inlier_views.assign(17, 3);
      person.covariances.assign(
          17, Eigen::Matrix3d(kSigmaM.cwiseAbs2().asDiagonal()));
      for (int v = 0; v < 4; ++v) {
        if (p == 2 && v == 1) continue;
        auto& in_view = seen.views[static_cast<size_t>(v)].detections;
        Detection detection = testing::Project(
            person.joints, recording.cameras[static_cast<size_t>(v)]);
        detection.index_in_file = static_cast<int>(in_view.size());
        ViewMatch match{v, detection.index_in_file, {}};
        match.weights.assign(17, 1.0);
        if (v == 0 && p == 0) {
          detection.joints[kLeftWrist].px += kShiftPx;
          match.weights[kLeftWrist] = 0.0;
        }
        if (v == 0 && p == 1) {
          detection.joints[kRightWrist].found = false;
          match.weights[kRightWrist] = std::nullopt;
        }
        in_view.push_back(detection);
        person.matches.push_back(match);
      }
      if (frame.frame == kJumpFrame && p == 0) {
        person.joints[kLeftWrist].position_m.x() += 0.3;
      }
      frame.people.push_back(person);
    }
    Detection nobody = testing::Project(testing::StandingPerson(1.5, 2.0),
                                        recording.cameras[0]);
    nobody.index_in_file = static_cast<int>(seen.views[0].detections.size());
    seen.views[0].detections.push_back(nobody);
    recording.tracks.frames.push_back(frame);
    recording.detections.frames.push_back(seen);
  }
  return recording;
}

// The page with all its parts, and names that contain markup.
std::string WholePage(const Recording& recording) {
  PageInput input;
  input.title = kHostile;
  input.results.push_back({kHostile, ResultRole::kTracks, recording.tracks});
  TrackSequence hostile = recording.tracks;
  std::vector<std::string> joints = Coco17().joints();
  joints[0] = kHostile;
  hostile.header.skeleton = Skeleton("x", joints, Coco17().bones());
  input.results.push_back({"second", ResultRole::kTracks, hostile});
  input.results.push_back(
      {"truth", ResultRole::kGroundTruth, recording.tracks});
  input.cameras = recording.cameras;
  input.detections = recording.detections;
  PageOptions options;
  options.with_covariance = true;
  return MakePage(input.title, MakePageData(input, options).json);
}

class PageInBrowser : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!Browser::IsInstalled()) {
      GTEST_SKIP() << "needs a browser: apt-get install chromium";
    }
  }

  // No test may leave errors in the browser.
  void TearDown() override {
    if (browser_ == nullptr) return;
    EXPECT_THAT(browser_->problems(), IsEmpty());
    EXPECT_THAT(browser_->requests(), ElementsAre("file://" + page_))
        << "everything is in the file";
  }

  Browser& Open(const Screen& screen, bool dark = false) {
    return Open(screen, WholePage(recording_), dark);
  }
  Browser& Open(const Screen& screen, const std::string& html, bool dark) {
    page_ = folder_.Write("page.html", html);
    browser_ = std::make_unique<Browser>(screen);
    browser_->PreferDark(dark);
    browser_->Open(page_);
    EXPECT_TRUE(browser_->WaitFor("window.kinegraph"));
    EXPECT_EQ(browser_->Evaluate("kinegraph.scene !== null"), true) << "WebGL";
    return *browser_;
  }

  int Frame() { return browser_->Evaluate("kinegraph.state.frame"); }

  // The text of the first element that a selector finds.
  std::string TextOf(const std::string& selector) {
    return browser_->Evaluate("document.querySelector('" + selector +
                              "').textContent");
  }

  // Selects an entry of a list, with the event of a user's change.
  void Choose(const std::string& id, const std::string& value) {
    browser_->Evaluate("(() => { const list = document.getElementById('" + id +
                       "'); list.value = '" + value +
                       "'; list.dispatchEvent(new Event('change')); })()");
  }

  // The frame shown by the state, the slider, the clock and the bodies in 3D;
  // -1 if they disagree.
  int FrameEverywhere() {
    const Json shown = browser_->Evaluate(R"((() => {
      const f = kinegraph.state.frame, result = kinegraph.results[0];
      const p = result.start[f], matrix = new THREE.Matrix4();
      kinegraph.scene.bodies[0][result.person[p]].joints.getMatrixAt(0, matrix);
      const apart = Math.abs(matrix.elements[12] - result.xyz[p * 17 * 3]);
      return {frame: f, slider: Number(document.getElementById('scrub').value),
              clock: document.getElementById('clock').textContent, apart: apart,
              cursor: document.querySelector('.cursor').style.transform};
    })())");
    const int frame = shown["frame"];
    char clock[64];
    std::snprintf(clock, sizeof(clock), "frame %d \u00b7 %.2f s",
                  kFirstFrame + frame, (kFirstFrame + frame) / 25.0);
    const bool agree = shown["slider"] == frame && shown["clock"] == clock &&
                       shown["apart"].get<double>() < 1e-6;
    EXPECT_TRUE(agree) << shown;
    return agree ? frame : -1;
  }

  // The 3D view's camera: position, target, distance.
  Json Eye() {
    return browser_->Evaluate(
        "(() => { const view = kinegraph.scene;"
        "return {at: view.camera.position.toArray(),"
        "target: view.controls.target.toArray(),"
        "distance: view.camera.position.distanceTo(view.controls.target)};"
        "})()");
  }

  const testing::TemporaryFolder folder_;
  const Recording recording_ = MakeRecording();
  std::string page_;
  std::unique_ptr<Browser> browser_;
};

TEST_F(PageInBrowser, KeysSelectTheRightFrame) {
  Browser& browser = Open(kDesk);
  EXPECT_EQ(FrameEverywhere(), 0);
  const std::vector<std::tuple<const char*, bool, int>> presses = {
      {"ArrowRight", false, 1}, {"ArrowRight", true, 11},
      {"ArrowLeft", false, 10}, {"ArrowLeft", true, 0},
      {"ArrowLeft", false, 0},  {"End", false, 99},
      {"ArrowRight", true, 99}, {"ArrowLeft", false, 98},
      {"q", false, 98},         {"Home", false, 0}};
  for (const auto& [key, shift, frame] : presses) {
    browser.Press(key, shift);
    EXPECT_EQ(FrameEverywhere(), frame) << key;
  }
  for (const auto& [key, speed] :
       {std::pair{"+", 2.0}, {"-", 1.0}, {"-", 0.5}}) {
    browser.Press(key);
    EXPECT_EQ(browser.Evaluate("kinegraph.state.speed"), speed) << key;
  }
  EXPECT_EQ(browser.Evaluate("document.getElementById('speed').value"), "0.5");
}

TEST_F(PageInBrowser, ScrubbingSelectsTheRightFrame) {
  Browser& browser = Open(kDesk);
  for (const int frame : {17, 99, 0}) {
    browser.Evaluate(
        "(() => { const scrub = document.getElementById('scrub');"
        "scrub.value = " +
        std::to_string(frame) +
        "; scrub.dispatchEvent(new Event('input')); })()");
    EXPECT_EQ(FrameEverywhere(), frame);
  }
  // The middle of the slider and of a timeline is the middle of the recording,
  // 49.5: one of the two adjacent frames.
  browser.Press("Home");
  browser.Click("#scrub");
  EXPECT_NEAR(FrameEverywhere(), 49.5, 1.0);
  // Labels occupy the left 110 px of a timeline.
  browser.Press("Home");
  PagePoint plot = browser.MiddleOf(".plot");
  plot.x += 0.5 * 110.0;
  browser.DragMouse(plot, plot);
  EXPECT_NEAR(FrameEverywhere(), 49.5, 1.0);
  browser.Click("#step-on");
  browser.Click("#step-on");
  browser.Click("#step-back");
  EXPECT_NEAR(FrameEverywhere(), 50.5, 1.0);
}

TEST_F(PageInBrowser, PlaybackKeepsTimeAndStopsAtTheEnd) {
  Browser& browser = Open(kDesk);
  const auto state = [&] {
    return browser.Evaluate("[kinegraph.state.time, performance.now() / 1000]");
  };
  browser.Click("#play");
  ASSERT_TRUE(browser.WaitFor("kinegraph.state.frame > 4"));
  const Json first = state();
  ASSERT_TRUE(browser.WaitFor("kinegraph.state.frame > 20"));
  const Json second = state();
  const double played_s = second[0].get<double>() - first[0].get<double>();
  const double passed_s = second[1].get<double>() - first[1].get<double>();
  // Playback is never ahead of the clock by more than one image (below 0.25 s);
  // how far it falls behind depends on the machine.
  EXPECT_GT(played_s, 0.0);
  EXPECT_LT(played_s, passed_s + 0.25);
  browser.Press("Home");
  EXPECT_EQ(browser.Evaluate("kinegraph.state.playing"), false);
  // The button still has the focus, and Space presses it: once, not twice.
  browser.Press(" ");
  EXPECT_EQ(browser.Evaluate("kinegraph.state.playing"), true);
  browser.Press("+");
  browser.Press("+");
  ASSERT_TRUE(browser.WaitFor("!kinegraph.state.playing"));
  EXPECT_EQ(FrameEverywhere(), 99);
  EXPECT_EQ(TextOf("#play"), "Play");
  // At the end, playback starts again from the beginning.
  browser.Click("#play");
  EXPECT_LT(Frame(), 90);
}

TEST_F(PageInBrowser, ClickOnAWorstMomentSelectsItsFrame) {
  Browser& browser = Open(kDesk);
  // The largest change of velocity is at the return, a frame after the jump.
  Choose("moment-kind", "speed");
  EXPECT_THAT(TextOf("#moments button"), HasSubstr("left wrist"));
  browser.Click("#moments button");
  EXPECT_EQ(FrameEverywhere(), kJumpFrame + 1 - kFirstFrame);
  Choose("moment-kind", "end");
  browser.Click("#moments button");
  EXPECT_EQ(FrameEverywhere(), 59) << "person 2 is lost";
}

TEST_F(PageInBrowser, HostileNamesStayText) {
  Browser& browser = Open(kDesk);
  EXPECT_EQ(browser.Evaluate("document.title"), kHostile);
  EXPECT_EQ(TextOf("#title"), kHostile);
  EXPECT_EQ(TextOf("figcaption b"), kHostile);
  EXPECT_THAT(TextOf("#results"), HasSubstr(kHostile));
  browser.Press("End");
  EXPECT_EQ(browser.Evaluate("document.querySelectorAll('img').length"), 0);
  EXPECT_EQ(browser.Evaluate("typeof hacked"), "undefined");
}

// ---- Panels and ellipsoids

// Colour of a panel's canvas at a point of the image: red, green, blue, alpha.
std::string PixelAt(int view, const Eigen::Vector2d& px) {
  return "(() => { const panel = kinegraph.panels[" + std::to_string(view) +
         "]; return Array.from(panel.canvas.getContext('2d').getImageData("
         "Math.round(" +
         std::to_string(px.x()) +
         " * panel.scale - 0.5),"
         "Math.round(" +
         std::to_string(px.y()) + " * panel.scale - 0.5), 1, 1).data); })()";
}

TEST_F(PageInBrowser, PanelsCountMatchedRejectedAndMissing) {
  Browser& browser = Open(kDesk);
  browser.MiddleOf("#panels");
  browser.Press("Home");
  for (const auto& [figure, caption] :
       {std::pair{1, "detections 4, matched 3; joints rejected 1, not found 1"},
        {2, "detections 2, matched 2; joints rejected 0, not found 0"},
        {3, "detections 3, matched 3; joints rejected 0, not found 0"}}) {
    EXPECT_EQ(TextOf("figure:nth-child(" + std::to_string(figure) +
                     ") figcaption span"),
              caption);
  }

  const auto expect_colour = [&](int view, const Eigen::Vector2d& px,
                                 const std::vector<int>& rgb) {
    const Json pixel = browser.Evaluate(PixelAt(view, px));
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(pixel[c].get<int>(), rgb[c], 12) << pixel;
    }
    EXPECT_GT(pixel[3].get<int>(), 150) << pixel;
  };
  const std::vector<PersonPose>& people = recording_.tracks.frames[0].people;
  // The rejected wrist has a cross at the detection.
  const auto wrist =
      recording_.cameras[0].Project(people[0].joints[kLeftWrist].position_m);
  ASSERT_TRUE(wrist.has_value());
  expect_colour(0, *wrist + kShiftPx, {0xb3, 0x33, 0x0c});
  // In view 1, person 2 is not covered by a detection; with the other results
  // hidden, the thick line has that person's colour.
  browser.Evaluate(
      "document.querySelectorAll('#results input').forEach((box, i) =>"
      "{ if (i > 0) box.click(); })");
  const auto knee =
      recording_.cameras[1].Project(0.5 * (people[2].joints[13].position_m +
                                           people[2].joints[15].position_m));
  ASSERT_TRUE(knee.has_value());
  expect_colour(1, *knee, {0x00, 0x9e, 0x73});
  // A detection is labelled with its person; an unmatched one has no label.
  browser.Evaluate(
      "window.names = []; window.plain = CanvasRenderingContext2D.prototype"
      ".fillText; CanvasRenderingContext2D.prototype.fillText ="
      "function (text) { if (this.canvas === kinegraph.panels[0].canvas)"
      "names.push(text); plain.apply(this, arguments); }");
  browser.Press("Home");
  EXPECT_EQ(browser.Evaluate("names"), Json::array({"0", "1", "2"}));
}

TEST_F(PageInBrowser, SceneShowsTheSelectedElements) {
  Browser& browser = Open(kDesk);
  const auto of = [&](const std::string& what) {
    return browser.Evaluate("kinegraph.scene." + what);
  };
  const std::string body = "bodies[0][0].";
  // Inferred joints are faint: joint 3, an ear, and the bones that end in it,
  // l_eye to l_ear and l_ear to l_shoulder.
  for (const auto& [what, value] :
       {std::pair<const char*, Json>{"joints.count", 16},
        {"inferredJoints.count", 1},
        {"joints.material.opacity", 1.0},
        {"inferredJoints.material.opacity < 0.5", true},
        {"inferredBones.count", 2},
        {"bones.count", Coco17().bones().size() - 2},
        {"ellipsoids === null", true}}) {
    EXPECT_EQ(of(body + what), value) << what;
  }
  // Ellipsoids show two standard deviations.
  browser.Click("#show-ellipsoids");
  EXPECT_EQ(of(body + "ellipsoids.visible"), true);
  EXPECT_EQ(of(body + "ellipsoids.count"), 17);
  const Json axes = browser.Evaluate(
      "(() => { const m = new THREE.Matrix4();"
      "kinegraph.scene.bodies[0][0].ellipsoids.getMatrixAt(0, m);"
      "return [0, 5, 10].map((i) => m.elements[i]); })()");
  for (int k = 0; k < 3; ++k) {
    // Factors of covariances are stored to 0.1 mm, rounded: two sigmas are
    // accurate to 0.1 mm.
    EXPECT_NEAR(axes[static_cast<size_t>(k)].get<double>(), 2.0 * kSigmaM[k],
                1.01e-4);
  }
  browser.Click("#show-ellipsoids");
  EXPECT_EQ(of(body + "ellipsoids.visible"), false);
  // A result and layers can be hidden.
  EXPECT_EQ(of("bodies[1][0].joints.visible"), true);
  browser.Click("#results label:nth-child(2) input");
  EXPECT_EQ(of("bodies[1][0].joints.visible"), false);
  // Labels change when the next image is drawn, so their check waits.
  for (const char* layer : {"floor", "cameras", "labels", "trails"}) {
    browser.Click(std::string("#show-") + layer);
  }
  for (const char* what : {"floor", "cameraGroup", "bodies[0][0].trail"}) {
    EXPECT_EQ(of(std::string(what) + ".visible"), false) << what;
  }
  EXPECT_TRUE(
      browser.WaitFor("!document.querySelector('#labels span:not([hidden])')"));
}

TEST_F(PageInBrowser, TimelinesAreDrawn) {
  Browser& browser = Open(kDesk);
  EXPECT_EQ(
      browser.Evaluate("Array.from(document.querySelectorAll("
                       "'.chart .head b'), (b) => b.textContent)"),
      Json::array({"Tracked people, by number of views", "Residual per camera",
                   "Distance to the truth", "Mean speed of joints",
                   "Joint angle", "Bone length"}));
  // Each canvas is not empty right of its labels.
  EXPECT_EQ(browser.Evaluate(
                "Array.from(document.querySelectorAll('.plot canvas'), (c) =>"
                "c.getContext('2d').getImageData(100, 0, c.width - 100,"
                "c.height).data.some((v, i) => i % 4 === 3 && v > 0))"),
            Json::array({true, true, true, true, true, true}));
  // A different angle gives a different drawing; its interval is a band.
  EXPECT_EQ(browser.Evaluate(
                "(() => { const select = document.getElementById('angle');"
                "const chart = select.closest('.chart');"
                "const shot = () => chart.querySelector('canvas').toDataURL();"
                "const before = shot();"
                "select.value = 'r_elbow_flexion';"
                "select.dispatchEvent(new Event('change'));"
                "return [select.selectedOptions[0].textContent,"
                "shot() !== before,"
                "chart.textContent.includes('95 % intervals')]; })()"),
            Json::array({"right elbow flexion", true, true}));
  // Person 2 is present for 60 of 100 frames: its row ends there.
  EXPECT_EQ(browser.Evaluate(
                "[0.3, 0.55, 0.65, 0.9].map((share) => { const c ="
                "document.querySelector('.plot canvas'); return "
                "c.getContext('2d').getImageData(Math.round(share * c.width),"
                "2 * 15 + 7, 1, 1).data[3] > 0; })"),
            Json::array({true, true, false, false}));
}

// A timeline spaces frames evenly, also across a gap in time, so the label of a
// time must stand at the frame of that time.
TEST_F(PageInBrowser, TimelineLabelsStandAtTheirFrames) {
  Recording gapped = MakeRecording();
  for (size_t f = kFrames / 2; f < kFrames; ++f) {  // after a gap of 3 s
    gapped.tracks.frames[f].frame += 75;
    gapped.tracks.frames[f].time += FromSeconds(3.0);
    gapped.detections.frames[f].frame += 75;
  }
  Browser& browser = Open(kDesk, WholePage(gapped), false);
  browser.Evaluate(
      "window.places = {}; window.plain = CanvasRenderingContext2D.prototype"
      ".fillText; CanvasRenderingContext2D.prototype.fillText ="
      "function (text, x) { if (this.canvas === "
      "document.querySelector('.plot canvas')) places[text] = x;"
      "plain.apply(this, arguments); };"
      "window.dispatchEvent(new Event('resize'))");
  browser.Evaluate("kinegraph.setFrame(75)");
  ASSERT_THAT(TextOf("#clock"), HasSubstr("18.00 s"));
  const double cursor_px = browser.Evaluate(
      "parseFloat(document.querySelector('.cursor').style.transform"
      ".slice('translateX('.length))");
  const Json places = browser.Evaluate("places");
  ASSERT_TRUE(places.contains("18.0 s")) << places;
  // Labels of rows occupy the left 110 px.
  EXPECT_NEAR(places["18.0 s"].get<double>() + 110.0, cursor_px, 2.0);
}

// The least difference (CIE 1976) of any two colours for normal vision and
// three kinds of dichromats, after Machado, Oliveira and Fernandes, "A
// Physiologically-based Model for Simulation of Color Vision Deficiency"
// (2009), severity 1.
constexpr const char* kLeastColourDifference = R"((() => {
  const kinds = [[1, 0, 0, 0, 1, 0, 0, 0, 1],
    [0.152286, 1.052583, -0.204868, 0.114503, 0.786281, 0.099216, -0.003882, -0.048116, 1.051998],
    [0.367322, 0.860646, -0.227968, 0.280085, 0.672501, 0.047413, -0.011820, 0.042940, 0.968881],
    [1.255528, -0.076749, -0.178779, -0.078411, 0.930809, 0.147602, 0.004733, 0.691367, 0.303900]];
  const times = (m, v) => [0, 3, 6].map((r) => m[r] * v[0] + m[r + 1] * v[1] + m[r + 2] * v[2]);
  const linear = (text) => [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16) / 255)
    .map((v) => v <= 0.04045 ? v / 12.92 : Math.pow((v + 0.055) / 1.055, 2.4));
  const lab = (rgb) => {
    const xyz = times([0.4124, 0.3576, 0.1805, 0.2126, 0.7152, 0.0722, 0.0193, 0.1192, 0.9505], rgb.map((v) => Math.min(1, Math.max(0, v))));
    const f = xyz.map((v, i) => v / [0.9505, 1, 1.089][i]).map((v) => v > 0.008856 ? Math.cbrt(v) : 7.787 * v + 16 / 116);
    return [116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])];
  };
  let least = 1e9;
  kinds.forEach((kind) => {
    const seen = kinegraph.palette.map((colour) => lab(times(kind, linear(colour))));
    seen.forEach((a, i) => seen.slice(i + 1).forEach((b) => { least = Math.min(least, Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2])); }));
  });
  return least;
})())";

// The doctor's findings come before the 3D view; the summary has its verdict.
TEST_F(PageInBrowser, WarningsAndFindingsComeFirst) {
  PageInput input;
  input.title = "take";
  input.results.push_back({"take", ResultRole::kTracks, recording_.tracks});
  input.doctor_json =
      R"({"verdict": "suspect", "findings": [{"kind": "swapped_views",)"
      R"("camera": "two", "confidence": 0.9, "before_px": 41.0,)"
      R"("after_px": 3.2, "fix": "--set=cameras.map.two=three",)"
      R"("evidence": "<b>agreement</b> 0.9"}], "notes": []})";
  Browser& browser =
      Open(kPhone, MakePage(input.title, MakePageData(input).json), false);
  const std::string text =
      browser.Evaluate("document.getElementById('findings').innerText");
  EXPECT_THAT(text, HasSubstr("swapped views of two, confidence 0.90"));
  EXPECT_THAT(text, HasSubstr("41 to 3.2 px; <b>agreement</b> 0.9"));
  EXPECT_THAT(text, HasSubstr("Try: --set=cameras.map.two=three"));
  EXPECT_EQ(browser.Evaluate(
                "document.getElementById('findings').getBoundingClientRect()"
                ".bottom <= document.getElementById('stage')"
                ".getBoundingClientRect().top"),
            true);
  EXPECT_THAT(TextOf("#summary"), HasSubstr("Doctor: suspect"));
}

// The saved SVG is well formed, with bodies and a frame number; the PNG is not
// empty.
TEST_F(PageInBrowser, SavedPicturesShowTheDisplayedFrame) {
  Browser& browser = Open(kDesk);
  browser.Evaluate("kinegraph.setFrame(7)");
  const Json drawing = browser.Evaluate(
      "(() => { const text = kinegraph.svgPicture();"
      "const root = new DOMParser().parseFromString(text, 'image/svg+xml');"
      "return {broken: root.querySelectorAll('parsererror').length,"
      "name: root.documentElement.tagName,"
      "paths: root.querySelectorAll('path').length,"
      "texts: Array.from(root.querySelectorAll('text'), (t) => t.textContent),"
      "odd: /NaN|undefined|Infinity/.test(text)}; })()");
  EXPECT_EQ(drawing.at("broken"), 0);
  EXPECT_EQ(drawing.at("name"), "svg");
  EXPECT_EQ(drawing.at("odd"), false);
  // A body has about twenty bones, in the 3D view and in each panel.
  EXPECT_GT(drawing.at("paths").get<int>(), 40);
  bool names_frame = false;
  for (const auto& text : drawing.at("texts")) {
    names_frame |= text.get<std::string>().find("frame ") != std::string::npos;
  }
  EXPECT_TRUE(names_frame);
  // An empty picture of 1600 px takes less than 20 kB.
  EXPECT_EQ(browser.Evaluate("kinegraph.pngUrl().slice(0, 22)"),
            "data:image/png;base64,");
  EXPECT_GT(browser.Evaluate("kinegraph.pngUrl().length").get<int>(), 30000);
  EXPECT_TRUE(browser.problems().empty());
}

TEST_F(PageInBrowser, ColoursDifferForEveryKindOfColourVision) {
  Browser& browser = Open(kDesk);
  EXPECT_EQ(browser.Evaluate("kinegraph.palette.length"), 8);
  // 2.3 is just noticeable side by side; the least difference in Okabe and
  // Ito's palette is 16.
  EXPECT_GT(browser.Evaluate(kLeastColourDifference).get<double>(), 15.0);
}

TEST_F(PageInBrowser, MouseRotatesZoomsAndMovesTheView) {
  Browser& browser = Open(kDesk);
  const PagePoint middle = browser.MiddleOf("#scene");
  const PagePoint beside = {middle.x + 90.0, middle.y + 20.0};
  const Json start = Eye();
  browser.DragMouse(middle, beside);
  const Json turned = Eye();
  EXPECT_NE(turned["at"], start["at"]);
  EXPECT_EQ(turned["target"], start["target"]);
  EXPECT_NEAR(turned["distance"], start["distance"], 1e-6);
  browser.Wheel(middle, -240.0);
  EXPECT_TRUE(
      browser.WaitFor("kinegraph.scene.camera.position.distanceTo("
                      "kinegraph.scene.controls.target) < 0.98 * " +
                      start["distance"].dump()))
      << "nearer";
  const Json zoomed = Eye();
  browser.DragMouse(middle, beside, "right");
  EXPECT_NE(Eye()["target"], zoomed["target"]) << "moved";
}

// ---- Touch

TEST_F(PageInBrowser, FingersRotateZoomAndMoveTheView) {
  Browser& browser = Open(kPhone);
  const PagePoint middle = browser.MiddleOf("#scene");
  const auto beside = [&](double dx, double dy) {
    return PagePoint{middle.x + dx, middle.y + dy};
  };
  const double scroll = browser.Evaluate("scrollY");
  const Json start = Eye();
  browser.Drag({beside(-60, 0)}, {beside(60, 20)});
  const Json turned = Eye();
  EXPECT_NE(turned["at"], start["at"]) << "one finger rotates";
  EXPECT_EQ(turned["target"], start["target"]);
  EXPECT_NEAR(turned["distance"], start["distance"], 1e-6);
  browser.Drag({beside(-20, 0), beside(20, 0)},
               {beside(-80, 0), beside(80, 0)});
  const Json zoomed = Eye();
  EXPECT_LT(zoomed["distance"].get<double>(),
            0.9 * turned["distance"].get<double>())
      << "spreading two fingers zooms in";
  browser.Drag({beside(-40, 0), beside(40, 0)},
               {beside(-40, 60), beside(40, 60)});
  EXPECT_NE(Eye()["target"], zoomed["target"])
      << "two parallel fingers move the view";
  EXPECT_EQ(browser.Evaluate("scrollY"), scroll) << "the page stays";
  browser.Tap("#reset-view");
  EXPECT_NEAR(Eye()["distance"], start["distance"], 1e-6);
}

TEST_F(PageInBrowser, FingersScrubPlayAndJump) {
  Browser& browser = Open(kPhone);
  browser.MiddleOf("#scene");
  const Json slider = browser.Evaluate(
      "(() => { const box = document.getElementById('scrub')"
      ".getBoundingClientRect(); return [box.left, box.width,"
      "box.top + box.height / 2]; })()");
  const double left = slider[0];
  const double width = slider[1];
  const double y = slider[2];
  browser.Drag({{left + 10.0, y}}, {{left + 0.5 * width, y}});
  // The middle of the slider is the middle of the recording; a frame is 3
  // pixels wide, and the thumb keeps the distance at which it was grabbed (10
  // px).
  EXPECT_NEAR(FrameEverywhere(), 49.5, 5.0);
  // Plays slowly, so that even on a busy machine the recording does not end
  // before the second tap.
  browser.Evaluate("kinegraph.state.speed = 0.1");
  browser.Tap("#play");
  const int from = Frame();
  EXPECT_TRUE(
      browser.WaitFor("kinegraph.state.frame > " + std::to_string(from + 3)));
  browser.Tap("#play");
  EXPECT_EQ(browser.Evaluate("kinegraph.state.playing"), false);
  browser.Tap("#moments button");
  EXPECT_EQ(FrameEverywhere(),
            browser.Evaluate("Number(document.querySelector("
                             "'#moments button').dataset.at)"));
  // A tap on a timeline jumps; a finger that scrolls the page does not. On a
  // phone, labels occupy the left 58 px of it.
  PagePoint plot = browser.MiddleOf(".plot");
  plot.x += 0.5 * 58.0;
  browser.Tap(plot);
  EXPECT_NEAR(FrameEverywhere(), 49.5, 1.0);
  browser.Press("Home");
  const double before = browser.Evaluate("scrollY");
  browser.Drag({plot}, {{plot.x, plot.y + 200.0}});
  EXPECT_TRUE(browser.WaitFor("scrollY < " + std::to_string(before - 50.0)));
  EXPECT_EQ(FrameEverywhere(), 0);
}

// ---- Layout

// Pairs of overlapping visible elements, elements that extend beyond the page,
// and clipped text. Elements floating over the 3D view are compared with each
// other only.
constexpr const char* kFaults = R"((() => {
  scrollTo(0, document.documentElement.scrollHeight);
  const list = document.getElementById('moments').getBoundingClientRect();
  const faults = [];
  const [stage, bar] = ['stage', 'transport'].map((id) => document.getElementById(id));
  // On a phone the 3D view and playback stay at the top. Of elements that scroll
  // beneath them only the part below their lower edge is checked.
  const stays = getComputedStyle(stage).position === 'sticky';
  const lid = stays ? bar.getBoundingClientRect().bottom : -Infinity;
  if (stays) {
    for (let y = 2; y < lid - 2; y += 7) {
      for (const x of [3, innerWidth / 2, innerWidth - 3]) {
        const top = document.elementFromPoint(x, y);
        if (!stage.contains(top) && !bar.contains(top)) faults.push('seen through the 3D view: ' + (top.id || top.tagName));
      }
    }
    if (stage.getBoundingClientRect().top < -1) faults.push('3D view out of sight');
    if (lid > 0.75 * innerHeight) faults.push('3D view takes the screen');
  }
  const parts = [];
  document.querySelectorAll('h1, h2, #subtitle, button, select, input, output,' +
      'label, #stage, aside .card, figure, .chart, .head b, .key, .plot,' +
      '#view-legend, figcaption b, figcaption span, footer').forEach((node) => {
    const box = node.getBoundingClientRect();
    let [top, bottom] = [box.top, box.bottom];
    if (node.closest('#moments')) {
      top = Math.max(top, list.top);
      bottom = Math.min(bottom, list.bottom);
    }
    if (!stage.contains(node) && !bar.contains(node)) top = Math.max(top, lid);
    if (box.width > 0 && bottom > top) {
      parts.push({node: node, left: box.left, right: box.right, top: top, bottom: bottom});
    }
  });
  const name = (node) => node.id || node.tagName + ' ' + node.textContent.slice(0, 20);
  parts.forEach((a, i) => parts.slice(i + 1).forEach((b) => {
    if (a.node.contains(b.node) || b.node.contains(a.node)) return;
    const apart = a.right <= b.left + 1 || b.right <= a.left + 1 || a.bottom <= b.top + 1 || b.bottom <= a.top + 1;
    if (!apart) faults.push(name(a.node) + ' over ' + name(b.node));
  }));
  parts.forEach((part) => {
    if (part.left < -1 || part.right > document.documentElement.clientWidth + 1) faults.push(name(part.node) + ' outside');
  });
  document.querySelectorAll('button, output, h1, figcaption, .head').forEach((node) => {
    if (node.scrollWidth > node.clientWidth + 1) faults.push(name(node) + ' cut off');
  });
  if (document.documentElement.scrollWidth > innerWidth) faults.push('scrolls sideways');
  scrollTo(0, 0);
  if (bar.getBoundingClientRect().bottom > innerHeight + 1) faults.push('playback out of sight');
  return faults;
})())";

// Text whose contrast with its background is below 4.5 (WCAG 2.1, 1.4.3).
constexpr const char* kPaleTexts = R"((() => {
  const numbers = (colour) => colour.match(/[\d.]+/g).map(Number);
  const luminance = (c) => {
    const [r, g, b] = c.slice(0, 3).map((v) => v / 255 <= 0.03928 ? v / 255 / 12.92 : Math.pow((v / 255 + 0.055) / 1.055, 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const pale = [];
  document.querySelectorAll('h1, h2, #subtitle, button, label, output, select, .legend, .key, .head b, figcaption, footer, .when, #labels span').forEach((node) => {
    let behind = node;
    while (behind !== document.documentElement && numbers(getComputedStyle(behind).backgroundColor)[3] === 0) behind = behind.parentElement;
    const a = luminance(numbers(getComputedStyle(node).color)), b = luminance(numbers(getComputedStyle(behind).backgroundColor));
    const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (contrast < 4.5) pale.push((node.id || node.className || node.tagName) + ' ' + contrast.toFixed(2));
  });
  return pale;
})())";

// Elements too small to tap: WCAG 2.2 (2.5.8) requires 24 CSS pixels.
constexpr const char* kSmallTargets = R"(
  Array.from(document.querySelectorAll('button, select, label, #scrub'))
    .filter((node) => { const height = node.getBoundingClientRect().height; return !node.hidden && height > 0 && height < 24; })
    .map((node) => node.id || node.textContent))";

struct LayoutCase {
  const char* name;
  Screen screen;
};

class PageLayout : public PageInBrowser,
                   public ::testing::WithParamInterface<LayoutCase> {};

TEST_P(PageLayout, NothingOverlapsInBothThemes) {
  for (const bool dark : {false, true}) {
    Browser& browser = Open(GetParam().screen, dark);
    EXPECT_EQ(browser.Evaluate("innerWidth"), GetParam().screen.width);
    EXPECT_EQ(browser.Evaluate("document.documentElement.classList.contains("
                               "'dark')"),
              dark);
    for (const char* state : {"as it opens", "in the other theme"}) {
      SCOPED_TRACE(state);
      EXPECT_EQ(browser.Evaluate(kFaults), Json::array());
      EXPECT_EQ(browser.Evaluate(kPaleTexts), Json::array());
      browser.Click("#theme");
    }
    if (GetParam().screen.width < 760) {  // a phone, upright
      EXPECT_EQ(browser.Evaluate(kSmallTargets), Json::array());
    }
    browser.Click("#help-button");
    EXPECT_EQ(browser.Evaluate(kFaults), Json::array()) << "with help";
    TearDown();
  }
}

INSTANTIATE_TEST_SUITE_P(
    Screens, PageLayout,
    ::testing::Values(LayoutCase{"desk", kDesk}, LayoutCase{"phone", kPhone},
                      LayoutCase{"phone_on_its_side", kPhoneOnItsSide},
                      LayoutCase{"small_phone", kSmallPhone},
                      LayoutCase{"tablet", kTablet}),
    [](const auto& layout) { return std::string(layout.param.name); });

// Tests of the checks themselves: a defective page must not pass.
TEST_F(PageInBrowser, LayoutChecksDetectFaults) {
  Browser& browser = Open(kDesk);
  const auto spoil = [&](const std::string& style) {
    browser.Evaluate(
        "(() => { const style = document.createElement('style');"
        "style.textContent = '" +
        style +
        "'; document.body.append(style);"
        "})()");
  };
  spoil("#timelines { margin-top: -60px; } footer { color: #d0d0d0; }");
  EXPECT_NE(browser.Evaluate(kFaults), Json::array());
  EXPECT_NE(browser.Evaluate(kPaleTexts), Json::array());
  browser.Evaluate("console.error('on purpose')");
  EXPECT_EQ(browser.problems().size(), 1u);
  browser.Evaluate("setTimeout(() => { throw new Error('thrown'); })");
  browser.Evaluate("fetch('http://127.0.0.1:9/').catch(() => 'refused')");
  EXPECT_GE(browser.problems().size(), 3u) << "the policy refuses any request";
  browser_.reset();  // with the problems that TearDown() would report
}

}  // namespace
}  // namespace kinegraph
