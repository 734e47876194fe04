#include "apps/report/page_data.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/report/moments.h"
#include "apps/report/page.h"
#include "core/base/error.h"
#include "core/io/text/json.h"
#include "core/kinematics/ground.h"
#include "core/kinematics/kinematics.h"
#include "tests/support/base64.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kHostileName = "</script><img src=x onerror=alert(1)>";

// People who walk along x at 1 m/s, side by side.
TrackSequence Walk(int frames, int people, double rate_hz) {
  TrackSequence tracks;
  tracks.header.skeleton = Coco17();
  tracks.header.frame_rate_hz = rate_hz;
  for (int f = 0; f < frames; ++f) {
    TrackFrame frame;
    frame.frame = f;
    frame.time = FrameClock(rate_hz).TimeOf(f);
    for (int p = 0; p < people; ++p) {
      PersonPose person;
      person.id = TrackId(p);
      person.joints = testing::StandingPerson(f / rate_hz, p);
      person.inlier_views.assign(person.joints.size(), 4);
      frame.people.push_back(person);
    }
    tracks.frames.push_back(frame);
  }
  return tracks;
}

PageInput InputOf(TrackSequence tracks) {
  PageInput input;
  input.title = "a walk";
  input.results.push_back({"walk", ResultRole::kTracks, std::move(tracks)});
  return input;
}

Json PageOf(const PageInput& input) {
  return ParseJson(MakePageData(input).json, "page");
}

template <typename Number>
std::vector<Number> Decode(const std::string& text) {
  const std::string bytes = testing::FromBase64(text);
  std::vector<Number> numbers(bytes.size() / sizeof(Number));
  std::memcpy(numbers.data(), bytes.data(), numbers.size() * sizeof(Number));
  return numbers;
}

TEST(Encoding, Base64OfKnownTexts) {
  // RFC 4648, section 10.
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Base64("f"), "Zg==");
  EXPECT_EQ(Base64("fo"), "Zm8=");
  EXPECT_EQ(Base64("foobar"), "Zm9vYmFy");
}

TEST(PageData, LargeFrameNumbersAreExact) {
  TrackSequence tracks = Walk(3, 1, 25.0);
  for (TrackFrame& frame : tracks.frames) frame.frame += int64_t{1} << 50;
  const Json page = PageOf(InputOf(tracks));
  EXPECT_THAT(Decode<double>(page["frames"]),
              ::testing::ElementsAre(0x1p50, 0x1p50 + 1, 0x1p50 + 2));
}

// An invalid summary does not prevent the page.
TEST(PageData, AnInvalidSummaryIsLeftOut) {
  PageInput input = InputOf(Walk(3, 1, 25.0));
  const std::string whole =
      R"({"cameras": [{"view": "a", "matched_share": 1, "median_px": 2, )"
      R"("p90_px": 3}], "people": [{"frames": 3, "height_m": null}], )"
      R"("most_people_in_a_view": 1, "warnings": [{"text": "a", "try": "b"}]})";
  input.results[0].summary_json = whole;
  const PageData shown = MakePageData(input);
  EXPECT_TRUE(ParseJson(shown.json, "page")["results"][0].contains("summary"));
  EXPECT_TRUE(shown.notes.empty());
  const std::string deep =
      R"({"a": )" + std::string(200000, '[') + std::string(200000, ']') + "}";
  for (const std::string& text :
       {std::string("{}"), std::string("[]"), std::string("{"), deep,
        whole.substr(0, 100), std::string(R"({"cameras": [null]})")}) {
    input.results[0].summary_json = text;
    const PageData data = MakePageData(input);
    EXPECT_FALSE(
        ParseJson(data.json, "page")["results"][0].contains("summary"));
    ASSERT_EQ(data.notes.size(), 1u);
    EXPECT_THAT(data.notes[0], ::testing::StartsWith("left out: "));
  }
}

TEST(PageData, AnInvalidDoctorFileIsRefused) {
  PageInput input = InputOf(Walk(3, 1, 25.0));
  for (const std::string& text :
       {std::string("[]"), std::string(R"({"verdict": "x", "findings": [{}]})"),
        R"({"verdict": "x", "findings": [)" + std::string(200000, '[') +
            std::string(200000, ']') + "]}"}) {
    input.doctor_json = text;
    EXPECT_THROW(MakePageData(input), InputError);
  }
}

// Faults corrected by the configuration of the tracks are not reported.
TEST(PageData, FindingsCorrectedByTheConfigurationAreLeftOut) {
  const auto finding = [](const char* kind, const char* fix) {
    return Json{{"kind", kind}, {"fix", fix}, {"confidence", 0.9}};
  };
  const Json doctor = {
      {"verdict", "suspect"},
      {"findings",
       {finding("clock_offset", "--set=cameras.refine_clock=true"),
        finding("view_rate", "--set=input.view_frame_rate.a=50"),
        finding("sides", "'--set=detections.exchange_sides=[\"a\",\"b\"]'"),
        finding("rotation", "--cameras=doctor/cameras.json"),
        finding("shift", "--cameras=doctor/cameras.json"),
        finding("unit", "--set=cameras.unit=mm")}}};
  const auto left = [&](const char* config) {
    PageInput input = InputOf(Walk(3, 1, 25.0));
    input.results[0].tracks.header.config_json = config;
    input.doctor_json = doctor.dump();
    std::string kinds;
    const Json page = PageOf(input);
    for (const Json& one : page["doctor"]["findings"]) {
      kinds += one["kind"].get<std::string>() + " ";
    }
    return kinds;
  };
  EXPECT_EQ(left("{}"), "clock_offset view_rate sides rotation shift unit ");
  EXPECT_EQ(left(R"({"cameras": {"refine_clock": true, "unit": "mm"}})"),
            "view_rate sides rotation shift ");
  EXPECT_EQ(left(R"({"cameras": {"refine": "pose"}, "input":
                     {"view_frame_rate": {"a": "50"}}, "detections":
                     {"exchange_sides": ["a", "b"]}})"),
            "clock_offset shift unit ");
  EXPECT_EQ(left(R"({"cameras": {"refine": "shift"}})"),
            "clock_offset view_rate sides rotation unit ");
}

TEST(PageData, FindingsWhoseKeyIsBelowAnArrayAreKept) {
  PageInput input = InputOf(Walk(3, 1, 25.0));
  input.results[0].tracks.header.config_json = R"({"a": [1]})";
  for (const std::string key : {"a.", "a.0", "a.99999999999999999999"}) {
    const Json finding = {
        {"kind", "unit"}, {"fix", "--set=" + key + "=1"}, {"confidence", 0.9}};
    const Json doctor = {{"verdict", "suspect"},
                         {"findings", Json::array({finding})}};
    input.doctor_json = doctor.dump();
    EXPECT_EQ(PageOf(input)["doctor"]["findings"].size(), 1u) << key;
  }
}

TEST(PageData, JointsDecodeWithinHalfAQuantum) {
  const TrackSequence tracks = Walk(10, 2, 25.0);
  const PageData data = MakePageData(InputOf(tracks));
  EXPECT_EQ(data.frames, 10u);
  EXPECT_EQ(data.poses, 20u);
  const Json result = ParseJson(data.json, "page")["results"][0];
  const auto root = Decode<int32_t>(result["root"]);
  const auto joints = Decode<int16_t>(result["joints"]);
  ASSERT_EQ(root.size(), 20u * 3u);
  ASSERT_EQ(joints.size(), 20u * 17u * 3u);
  for (size_t pose = 0; pose < 20; ++pose) {
    const Pose3d& truth = tracks.frames[pose / 2].people[pose % 2].joints;
    for (size_t i = 0; i < 17 * 3; ++i) {
      const double shown =
          root[pose * 3 + i % 3] * 1e-4 + joints[pose * 17 * 3 + i] * 1e-4;
      // Half of 0.1 mm, and rounding of doubles.
      EXPECT_NEAR(shown, truth[i / 3].position_m[static_cast<int>(i % 3)],
                  0.5e-4 + 1e-9);
    }
  }
}

TEST(PageData, AnglesDecodeWithinHalfAQuantum) {
  TrackSequence tracks = Walk(10, 2, 25.0);
  tracks.frames[4].people[1].joints[13].status = JointStatus::kMissing;
  PageInput input = InputOf(tracks);
  PageOptions options;
  options.up = Eigen::Vector3d::UnitZ();
  const PageData data = MakePageData(input, options);
  const Json angles = ParseJson(data.json, "page")["results"][0]["angles"];
  KinematicsOptions measured;
  measured.up = options.up;
  const KinematicsTable table = MeasureKinematics(tracks, measured);
  ASSERT_EQ(angles["names"].size(), table.angles.size());
  EXPECT_FALSE(angles.contains("low")) << "without covariances";
  int missing = 0;
  for (size_t a = 0; a < table.angles.size(); ++a) {
    EXPECT_EQ(angles["names"][a], table.angles[a]);
    const auto values = Decode<int16_t>(angles["values"][a]);
    ASSERT_EQ(values.size(), 20u);
    const int column = table.IndexOf(table.angles[a] + "_deg");
    for (size_t pose = 0; pose < 20; ++pose) {
      const double truth = table.rows[pose].values[static_cast<size_t>(column)];
      if (std::isnan(truth)) {
        EXPECT_EQ(values[pose], -32768);
        ++missing;
        continue;
      }
      EXPECT_NEAR(values[pose] * 0.1, truth, 0.05 + 1e-9);
    }
  }
  EXPECT_GT(missing, 0) << "expected missing angles of the left knee";
}

TEST(PageData, HostileNamesStayData) {
  TrackSequence tracks = Walk(3, 1, 25.0);
  tracks.header.skeleton = Skeleton("x", {kHostileName, "<!--"}, {{0, 1}});
  for (TrackFrame& frame : tracks.frames) frame.people[0].joints.resize(2);
  PageInput input = InputOf(tracks);
  input.title = input.results[0].label = kHostileName;
  const PageData data = MakePageData(input);
  EXPECT_THAT(data.json, Not(HasSubstr("<")));
  EXPECT_EQ(ParseJson(data.json, "page")["title"], kHostileName)
      << "nothing lost";
  const std::string page = MakePage(input.title, data.json);
  EXPECT_THAT(page, Not(HasSubstr("<img")));
  EXPECT_THAT(page, HasSubstr("<title>&lt;/script&gt;&lt;img"));
}

// The page of 5 minutes with 6 people at 30 Hz must have less than 15 MB.
TEST(PageData, LongRecordingStaysSmall) {
  const PageData data = MakePageData(InputOf(Walk(5 * 60 * 30, 6, 30.0)));
  EXPECT_EQ(data.poses, 54000u);
  EXPECT_EQ(data.frame_stride, 1);
  EXPECT_LT(MakePage("walk", data.json).size(), 15000000u);
}

// Exact detections of all people in all views.
DetectionSequence SeenBy(const CameraRig& cameras,
                         const TrackSequence& tracks) {
  return testing::SeenBy(cameras, static_cast<int>(tracks.frames.size()),
                         [&](int f) {
                           std::vector<Pose3d> poses;
                           for (const auto& person :
                                tracks.frames[static_cast<size_t>(f)].people) {
                             poses.push_back(person.joints);
                           }
                           return poses;
                         });
}

// A recording with all optional data.
PageInput WholeInput(int frames, int people) {
  PageInput input = InputOf(Walk(frames, people, 25.0));
  for (TrackFrame& frame : input.results[0].tracks.frames) {
    for (PersonPose& person : frame.people) {
      person.covariances.assign(17, Eigen::Matrix3d::Identity() * 1e-4);
    }
  }
  input.cameras = testing::RingOfCameras(5);
  input.detections = SeenBy(input.cameras, input.results[0].tracks);
  return input;
}

TEST(PageData, DetectionsAndCovariancesOnlyWhenAskedFor) {
  PageInput input = WholeInput(10, 2);
  const PageData both = MakePageData(input, {true, std::nullopt, 50000000});
  const Json with = ParseJson(both.json, "page");
  EXPECT_GT(both.detection_bytes, 0u);
  EXPECT_GT(both.covariance_bytes, 0u);
  EXPECT_EQ(with["bytes"]["detections"], both.detection_bytes);
  EXPECT_EQ(with["bytes"]["covariances"], both.covariance_bytes);
  // Covariances: 6 numbers of 2 bytes per joint, in Base64. Angles: two ends of
  // an interval, each 40 bytes for 20 poses, 56 characters in Base64.
  const Json& angles = with["results"][0]["angles"];
  EXPECT_GT(angles["names"].size(), 10u);
  EXPECT_EQ(both.covariance_bytes,
            10u * 2u * 17u * 12u / 3u * 4u + angles["names"].size() * 2u * 56u);

  const PageData bare = MakePageData(input);
  EXPECT_EQ(bare.covariance_bytes, 0u);
  EXPECT_FALSE(
      ParseJson(bare.json, "page")["results"][0].contains("covariance"));
  input.detections.reset();
  const PageData poses = MakePageData(input);
  EXPECT_EQ(poses.detection_bytes, 0u);
  const Json without = ParseJson(poses.json, "page");
  EXPECT_FALSE(without.contains("detections"));
  EXPECT_FALSE(without["results"][0].contains("match"));
  EXPECT_FALSE(without["results"][0].contains("residual"));
  // The stated sizes are the actual ones, except for names of the arrays.
  constexpr size_t kNames = 1000;
  EXPECT_NEAR(static_cast<double>(both.json.size() - poses.json.size()),
              static_cast<double>(both.detection_bytes + both.covariance_bytes),
              kNames);
}

TEST(PageData, DataAboveTheLimitIsDecimatedAndReported) {
  EXPECT_EQ(PageOptions().max_bytes, 50000000u) << "the required limit";
  const PageInput input = WholeInput(400, 3);
  PageOptions options;
  options.with_covariance = true;
  const size_t whole = MakePageData(input, options).json.size();
  // First detections and covariances are thinned out, then frames.
  for (const size_t share : {2u, 3u, 6u, 20u}) {
    options.max_bytes = whole / share;
    const PageData data = MakePageData(input, options);
    // Cameras, names and moments are not counted.
    constexpr size_t kRest = 20000;
    EXPECT_LE(data.json.size(), options.max_bytes + kRest) << share;
    EXPECT_GT(data.extras_stride, 1) << share;
    if (share == 2) {
      EXPECT_EQ(data.frame_stride, 1);
    }
    if (share == 20) {
      EXPECT_GT(data.frame_stride, 1);
    }
    EXPECT_EQ(data.frames,
              static_cast<size_t>(std::ceil(400.0 / data.frame_stride)));
    const Json page = ParseJson(data.json, "page");
    EXPECT_EQ(page["frameStride"], data.frame_stride);
    EXPECT_EQ(page["extrasStride"], data.extras_stride);
    const auto counts = Decode<uint16_t>(page["detections"]["counts"]);
    for (size_t f = 0; f < data.frames; ++f) {
      const bool kept = f % static_cast<size_t>(data.extras_stride) == 0;
      EXPECT_EQ(counts[f * 5], kept ? 3 : 0) << f;
    }
  }
}

TEST(PageData, SameInputSameBytes) {
  const PageInput input = InputOf(Walk(20, 3, 25.0));
  EXPECT_EQ(MakePageData(input).json, MakePageData(input).json);
}

// Two results and the truth: both have distances from the truth.
TEST(PageData, TwoResultsAreMeasuredAgainstTheTruth) {
  PageInput input = InputOf(Walk(5, 2, 25.0));
  for (const double shift_m : {0.1, 0.0}) {
    TrackSequence other = Walk(5, 2, 25.0);
    for (TrackFrame& frame : other.frames) {
      for (PersonPose& person : frame.people) {
        for (Joint3d& joint : person.joints) joint.position_m.z() += shift_m;
      }
    }
    input.results.push_back({"other", ResultRole::kTracks, std::move(other)});
  }
  input.results[2].role = ResultRole::kGroundTruth;
  const Json page = PageOf(input);
  const auto differences = [&](int r) {
    return Decode<uint16_t>(page["results"][r]["difference"]);
  };
  EXPECT_EQ(differences(0), std::vector<uint16_t>(5 * 2, 0));
  EXPECT_EQ(differences(1), std::vector<uint16_t>(5 * 2, 100)) << "in mm";
  EXPECT_FALSE(page["results"][2].contains("difference"));
  // Without truth, the two results are compared with each other.
  input.results.pop_back();
  const Json pair = PageOf(input);
  EXPECT_EQ(Decode<uint16_t>(pair["results"][0]["difference"]),
            std::vector<uint16_t>(5 * 2, 100));
  EXPECT_EQ(Decode<uint16_t>(pair["results"][1]["difference"]),
            std::vector<uint16_t>(5 * 2, 100));
}

TEST(PageData, AssumedFrameRateIsReported) {
  PageInput input = InputOf(Walk(5, 1, 25.0));
  EXPECT_EQ(PageOf(input)["assumedRate"], 0.0);
  for (TrackFrame& frame : input.results[0].tracks.frames) frame.time = 0;
  const Json page = PageOf(input);
  EXPECT_EQ(page["assumedRate"], 25.0);
  EXPECT_EQ(Decode<double>(page["times"])[4], 0.16);
}

TEST(PageData, TracksWithoutFramesAreRefused) {
  EXPECT_THROW(MakePageData(InputOf(Walk(0, 0, 25.0))), InputError);
}

TEST(PageData, ExactDetectionsHaveNoResidual) {
  PageInput input = InputOf(Walk(4, 2, 25.0));
  input.cameras = testing::RingOfCameras(3);
  input.detections = SeenBy(input.cameras, input.results[0].tracks);
  const PageData data = MakePageData(input);
  const Json page = ParseJson(data.json, "page");
  const auto residual = Decode<uint16_t>(page["results"][0]["residual"]);
  EXPECT_EQ(residual, std::vector<uint16_t>(4 * 2 * 3, 0));
  const auto match = Decode<int16_t>(page["results"][0]["match"]);
  EXPECT_EQ(match[0], 0)
      << "the nearest detection if the tracks have no matches";
  EXPECT_EQ(match[3], 1);
  EXPECT_EQ(Decode<uint16_t>(page["detections"]["counts"]),
            std::vector<uint16_t>(4 * 3, 2));
}

// A box or a point has fewer than the three joints by which people are
// compared.
TEST(PageData, SubjectsOfFewJointsArePaired) {
  const std::vector<std::string> names = {"front", "back"};
  for (const int joints : {1, 2}) {
    const Skeleton skeleton(
        "box", {names.begin(), names.begin() + joints},
        joints == 1 ? std::vector<Bone>{} : std::vector<Bone>{{0, 1}});
    TrackSequence tracks = Walk(4, 2, 25.0);
    tracks.header.skeleton = skeleton;
    for (TrackFrame& frame : tracks.frames) {
      for (PersonPose& person : frame.people) {
        person.joints.resize(skeleton.joint_count());
        person.inlier_views.resize(skeleton.joint_count());
      }
    }
    PageInput input = InputOf(tracks);
    input.cameras = testing::RingOfCameras(3);
    input.detections = SeenBy(input.cameras, tracks);
    input.detections->header.skeleton = skeleton;
    const Json result = PageOf(input)["results"][0];
    EXPECT_EQ(Decode<uint16_t>(result["residual"]),
              std::vector<uint16_t>(4 * 2 * 3, 0));
    const auto match = Decode<int16_t>(result["match"]);
    EXPECT_THAT(match, ::testing::Each(::testing::Ge(0)));
  }
}

TEST(Moments, FindAJumpAndALostIdentity) {
  TrackSequence tracks = Walk(50, 2, 25.0);
  tracks.frames[20].people[0].joints[9].position_m.x() += 0.2;
  for (size_t f = 40; f < 50; ++f) tracks.frames[f].people.pop_back();
  const std::vector<Moment> speed = Largest(SpeedJumps(tracks), 3);
  ASSERT_FALSE(speed.empty());
  // Out and back: the largest change of velocity is 2 * 0.2 m * 25 Hz.
  EXPECT_EQ(speed[0].frame, 21);
  EXPECT_NEAR(speed[0].value, 10.0, 1e-6);
  EXPECT_EQ(speed[0].detail, Coco17().joints()[9]);
  EXPECT_EQ(Largest(BoneDeviations(tracks), 1)[0].frame, 20);
  const std::vector<Moment> lives = StartsAndEnds(tracks);
  ASSERT_EQ(lives.size(), 1u);
  EXPECT_EQ(lives[0].kind, MomentKind::kEnd);
  EXPECT_EQ(lives[0].frame, 39);
  EXPECT_EQ(lives[0].id, TrackId(1));
}

TEST(Ground, UpDirectionIsThatOfStandingPeopleOrOfTheFlag) {
  EXPECT_EQ(UpDirection(Walk(2, 1, 25.0), {}), Eigen::Vector3d::UnitZ());
  EXPECT_EQ(*ParseUp("-y"), -Eigen::Vector3d::UnitY());
  EXPECT_FALSE(ParseUp("auto").has_value());
  for (const char* bad : {"", "-", "w", "xy", "--x"}) {
    EXPECT_THROW(ParseUp(bad), InputError) << bad;
  }
}

}  // namespace
}  // namespace kinegraph
