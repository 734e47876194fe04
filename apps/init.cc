// kinegraph-init: examines a recording and writes a configuration for it.
#include <fmt/format.h>
#include <gflags/gflags.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/adapter_flag.h"
#include "apps/common/app.h"
#include "apps/common/config_folder.h"
#include "apps/common/recording_output.h"
#include "apps/common/table.h"
#include "core/association/all_view_matching.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/evaluation/statistics.h"
#include "core/io/configuration/config.h"
#include "core/io/detections/source.h"
#include "core/io/detections/view_pairing.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/reading_notes.h"
#include "core/skeleton/body_joints.h"
#include "core/tracking/options.h"
#include "solvers/session/survey.h"

DEFINE_string(cameras, "", "calibration file or folder");
DEFINE_string(detections, "", "2D detections: a file or a folder");
DEFINE_double(frame_rate, 0.0,
              "frame rate [Hz] if the files do not specify it; never guessed");
DEFINE_string(skeleton, "",
              "skeleton of the detections if the file does not specify it");
DEFINE_string(set, "",
              "keys that the files do not specify, also written to the "
              "configuration: key=value;key=value, such as "
              "cameras.image_size=[360,288]");
DEFINE_string(without_cameras, "", "names of cameras to leave out: a,b");
DEFINE_string(out, "", "configuration to write (.toml)");

namespace kinegraph {
namespace {

SurveyRequest RequestOfFlags() {
  return {FLAGS_cameras, FLAGS_detections,
          DefaultOptions(FLAGS_frame_rate, FLAGS_skeleton, FLAGS_set),
          ParseList(FLAGS_without_cameras, "without_cameras")};
}

std::string SizesOf(const CameraRig& cameras) {
  const Camera& first = cameras.front();
  for (const Camera& camera : cameras) {
    if (camera.width_px() != first.width_px() ||
        camera.height_px() != first.height_px()) {
      return "images of different sizes";
    }
  }
  if (first.width_px() == 0) return "image size not given";
  return fmt::format("{} x {} px", first.width_px(), first.height_px());
}

// A note if people would not stand upright after conversion to a format with y
// up, such as BVH, whose axes are used here.
std::string UprightText(const RecordingSurvey& survey,
                        const RunOptions& options) {
  if (options.refine.ground != GroundKind::kOff) return "";
  const auto note = FindAxesNote(survey.stance, survey.cameras,
                                 *FindTrackFormat("bvh"), std::nullopt);
  if (!note) return "";
  return "upright     " + note->text + ":\n            " +
         (note->axes.empty() ? ""
                             : "--axes=" + note->axes +
                                   " of `track` and `convert` makes people "
                                   "upright, or\n            ") +
         "--set=cameras.ground=feet aligns the world with the floor if enough "
         "feet rest on it\n";
}

std::string UnitText(const RecordingSurvey& survey) {
  const RecordingReport& report = survey.report;
  if (report.height_m > 0.0) {
    return fmt::format(
        "unit        {}: people are then {:.2f} m tall\n",
        survey.unit == "auto" ? "the calibration's own" : survey.unit,
        report.height_m);
  }
  if (IsHuman(survey.detections.skeleton)) {
    return "unit        unknown: no person could be measured\n";
  }
  return "unit        as given: the joints are not human, so heights do not "
         "determine it\n" +
         (report.subject_m > 0.0
              ? fmt::format("            subjects measure about {:.2g} m; the "
                            "tracker's lengths are scaled accordingly\n",
                            report.subject_m)
              : "");
}

std::string CamerasText(const CameraRig& cameras) {
  const double distance_m = WorkingDistance(cameras);
  std::string text = fmt::format(
      "cameras     {}, {}, focal length about {:.0f} px\n"
      "            median distance to the point at which the cameras look: "
      "{:.1f} m\n",
      cameras.size(), SizesOf(cameras),
      PixelsPerMetre(cameras, distance_m) * distance_m, distance_m);
  // Missing distortion coefficients displace joints even if the views agree.
  const auto has_lens = [](const Camera& one) { return one.lens() != nullptr; };
  if (std::none_of(cameras.begin(), cameras.end(), has_lens)) {
    text +=
        "            no lens distortion given; `doctor` checks whether it is "
        "missing\n";
  }
  return text;
}

std::string FindingsText(const RecordingSurvey& survey,
                         const RunOptions& options) {
  const RecordingReport& report = survey.report;
  std::string text = CamerasText(survey.cameras) + UnitText(survey) +
                     UprightText(survey, options);
  std::string views;
  for (const CameraReport& camera : report.cameras) {
    views += (views.empty() ? "" : ", ") + camera.view + " = " + camera.camera;
  }
  text += fmt::format("views       {}\n", Printable(views, 1000));
  if (survey.paired_by != PairedBy::kName) {
    text += fmt::format("            paired {}\n", ToString(survey.paired_by));
  }
  const double rate_hz = survey.detections.frame_rate_hz;
  text += fmt::format(
      "skeleton    {}, {}\n"
      "frames      {}, {}..{}, {:.1f} s at {:g} Hz\n"
      "people      up to {} in one view (in 5 % of the frames or more)\n",
      Printable(survey.detections.skeleton.name()),
      Counted(survey.detections.skeleton.joint_count(), "joint", "joints"),
      survey.frames, survey.first_frame, survey.last_frame,
      static_cast<double>(survey.last_frame - survey.first_frame + 1) / rate_hz,
      rate_hz, report.most_people_in_a_view);
  if (report.poses > 0) {
    text += fmt::format(
        "error       {:.1f} px median, {:.1f} px 90th percentile ({} "
        "examined)\n",
        report.median_px, report.p90_px,
        Counted(survey.frames_tried, "frame", "frames"));
  }
  text += WarningsText(report);
  if (survey.cameras_are_off || survey.clocks_are_off) {
    text += fmt::format(
        "with this configuration `track` refines {} ([cameras]) if parameters "
        "fitted to one\nhalf of the recording also fit the other half better; "
        "`doctor` looks for the cause\n",
        !survey.clocks_are_off   ? "cameras"
        : survey.cameras_are_off ? "cameras and clocks"
                                 : "clocks");
  }
  if (!survey.left.empty()) {
    text += Wrapped("cameras are not refined: " + survey.left, 98, "  ");
  }
  return text;
}

// Files may define other bones between the joints of a built-in skeleton.
bool SameBones(const Skeleton& one, const Skeleton& other) {
  return std::equal(
      one.bones().begin(), one.bones().end(), other.bones().begin(),
      other.bones().end(),
      [](const Bone& a, const Bone& b) { return a.a == b.a && a.b == b.b; });
}

// Settings that estimate a whole recording at once.
constexpr const char* kWholeRecording =
    "\n[gates]\n"
    "units = \"metres\"   # scale with focal length, distance and rate\n"
    "\n[tracking]\n"
    "backfill = true      # write people from their first frame on\n"
    "max_gap_s = 0.4      # s; longer gaps are not bridged\n"
    "second_pass = true   # associate again with the smoothed tracks\n"
    "\n[identity]\n"
    "link = true          # decide who is who over the whole recording\n"
    "\n[output]\n"
    "estimator = \"batch\"\n"
    "\n[graph]\n"
    "bones = true\n";

// For people with few joints, the noise of a position is large compared with
// the movement between frames. Detections are therefore associated with the
// positions that the window estimator predicts.
std::string WholeRecording(const Skeleton& skeleton) {
  std::string text = kWholeRecording;
  if (!AllViewMatcher::AppliesTo(skeleton)) return text;
  const std::string table = "[tracking]\n";
  text.insert(text.find(table) + table.size(),
              "feedback = \"window\"  # predict people with few joints\n");
  return text;
}

// Throws if a configuration, which is UTF-8, cannot contain the name.
void RequireUtf8(const std::string& name) {
  if (Json::parse(JsonText(name)) == name) return;
  throw InputError("the name '" + Printable(name) +
                   "' of a view or camera is not UTF-8, which a configuration "
                   "requires; rename its files");
}

std::string ConfigText(const RecordingSurvey& survey) {
  for (const auto& [view, camera] : survey.map) {
    RequireUtf8(view);
    RequireUtf8(camera);
  }
  for (const std::string& camera : survey.use) RequireUtf8(camera);
  std::string text =
      "# Made by `kinegraph init` for one recording. Estimates the whole "
      "recording at\n"
      "# once, with bone lengths and a second pass. For results with a delay "
      "of 0.4 s:\n"
      "# output.estimator = \"window\"; graph.bones, tracking.second_pass and "
      "identity.link\n"
      "# = false; without cameras.refine and cameras.refine_clock.\n"
      "# All keys: `kinegraph track --keys`.\n"
      "mode = \"graph\"\n\n[input]\n";
  text += fmt::format(
      "frame_rate = {}  # Hz, {}\n", survey.detections.frame_rate_hz,
      FLAGS_frame_rate > 0.0 ? "as given" : "as in the detections");
  text += "\n[detections]\n";
  const Skeleton& skeleton = survey.detections.skeleton;
  const Skeleton* known = FindSkeleton(skeleton.name());
  text += known != nullptr && SameBones(skeleton, *known)
              ? "skeleton = " + JsonText(skeleton.name()) + "\n"
              : "# skeleton: as in the files\n";
  text += "\n[cameras]\n";
  text += survey.unit == "auto" ? "# unit: as in the calibration\n"
                                : "unit = " + JsonText(survey.unit) +
                                      "  # from people's height\n";
  if (survey.cameras_are_off || survey.clocks_are_off) {
    text +=
        "# Some cameras or clocks appear to be off: they are refined if "
        "parameters\n"
        "# fitted to one half of the recording also fit the other half "
        "better.\n";
  }
  if (survey.cameras_are_off) text += "refine = \"pose\"\n";
  if (survey.clocks_are_off) text += "refine_clock = true\n";
  if (!survey.use.empty()) {
    text += "use = " + Json(survey.use).dump() +
            "  # the other cameras are left out\n";
  }
  if (!survey.map.empty()) {
    text += survey.paired_by == PairedBy::kOrder
                ? "\n# View = camera, paired in the order of their names: "
                  "check this."
                : "\n# View = camera.";
    text += "\n[cameras.map]\n";
    for (const auto& [view, camera] : survey.map) {
      text += JsonText(view) + " = " + JsonText(camera) + "\n";
    }
  }
  if (survey.min_joints.has_value()) {
    text += fmt::format(
        "\n[initialisation]\n"
        "min_common_joints = {0}  # of 17; lowered: few joints are detected\n"
        "min_joints = {0}\n",
        *survey.min_joints);
  }
  return text + WholeRecording(skeleton);
}

// The parts of a dotted key. The name of a view may contain dots.
std::vector<std::string> PartsOf(const std::string& dotted) {
  for (const std::string table : {"view_frame_rate", "view_frame_offset"}) {
    const std::string prefix = "input." + table + ".";
    if (dotted.rfind(prefix, 0) == 0) {
      return {"input", table, dotted.substr(prefix.size())};
    }
  }
  return Split(dotted, '.');
}

// The value of a key as read, in TOML: JSON's strings, numbers and lists are
// valid TOML. Values of keys that are not in the effective options are strings.
std::string TomlValue(const Json& effective, const std::string& dotted,
                      const std::string& given) {
  const Json* value = &effective;
  for (const std::string& key : PartsOf(dotted)) {
    const auto inner = value->find(key);
    if (inner == value->end()) return JsonText(given);
    value = &*inner;
  }
  return value->dump();
}

// Sets `key = value` in its table, replacing an existing entry.
void PutKey(const std::string& dotted, const std::string& value,
            std::string* text) {
  const size_t dot = dotted.find('.');
  const std::vector<std::string> parts = PartsOf(dotted);
  std::string key = parts.size() == 1 ? dotted : parts[1];
  // The name of a view need not be a bare key.
  for (size_t i = 2; i < parts.size(); ++i) key += "." + JsonText(parts[i]);
  const std::string line = key + " = " + value + "  # as given\n";
  size_t begin = 0;
  if (dot == std::string::npos) {
    begin = text->find("mode = ");
  } else {
    const std::string header = "\n[" + dotted.substr(0, dot) + "]\n";
    begin = text->find(header);
    if (begin == std::string::npos) {
      *text += header;
      begin = text->size();
    } else {
      begin += header.size();
    }
  }
  const size_t end = std::min(text->find("\n[", begin), text->size());
  size_t old = begin;
  while (old < end && text->compare(old, key.size() + 1, key + " ") != 0) {
    old = std::min(text->find('\n', old), end) + 1;
  }
  if (old < end) text->erase(old, text->find('\n', old) + 1 - old);
  text->insert(begin, line);
}

// Adds the keys of --set to the configuration. Throws if the result cannot be
// read.
std::string WithGivenKeys(const RunOptions& options, std::string text) {
  const Json effective = Json::parse(EffectiveConfigJson(options));
  for (const std::string& part : Split(FLAGS_set, ';')) {
    const size_t equals = part.find('=');
    if (equals == std::string::npos) continue;  // rejected when read
    const std::string key = Trimmed(part.substr(0, equals));
    if (key.rfind("cameras.map.", 0) == 0) continue;  // already present
    // Already present, without the cameras of --without_cameras.
    if (key == "cameras.use" && !FLAGS_without_cameras.empty()) continue;
    const std::string value = Trimmed(part.substr(equals + 1));
    PutKey(key, TomlValue(effective, key, value), &text);
  }
  ParseRunOptions(text, "", "");
  return text;
}

// The first usual image size that contains nearly all joints; if there is none,
// their extent.
std::pair<int, int> LikelyImageSize(const DetectionSequence& recording) {
  std::vector<double> x;
  std::vector<double> y;
  for (const DetectionFrame& frame : recording.frames) {
    for (const ViewDetections& view : frame.views) {
      for (const Detection& detection : view.detections) {
        for (const Keypoint& joint : detection.joints) {
          if (!joint.found) continue;
          x.push_back(joint.px.x());
          y.push_back(joint.px.y());
        }
      }
    }
  }
  constexpr double kNearlyAll = 0.99;
  const double width = x.empty() ? 0.0 : Quantile(std::move(x), kNearlyAll);
  const double height = y.empty() ? 0.0 : Quantile(std::move(y), kNearlyAll);
  constexpr std::pair<int, int> kUsual[] = {
      {640, 480},   {480, 640},   {1280, 720},  {720, 1280},
      {1920, 1080}, {1080, 1920}, {3840, 2160}, {2160, 3840}};
  // Joints are also found slightly outside the image, and some cameras have a
  // few more rows than the standard size.
  constexpr double kBeyond = 1.03;
  for (const auto& size : kUsual) {
    if (width <= kBeyond * size.first && height <= kBeyond * size.second) {
      return size;
    }
  }
  return {static_cast<int>(width) + 1, static_cast<int>(height) + 1};
}

// Called without a calibration: suggests the command that makes one.
[[noreturn]] void OfferCalibrate() {
  const SurveyRequest request = RequestOfFlags();
  const auto [width, height] = LikelyImageSize(
      ReadDetections(FLAGS_detections, DetectionOptionsOf(request.options)));
  std::string more;
  if (FLAGS_frame_rate > 0.0) {
    more += fmt::format(" --frame_rate={:g}", FLAGS_frame_rate);
  }
  more += Flag("skeleton", FLAGS_skeleton) + Flag("set", FLAGS_set);
  throw InputError(fmt::format(
      "--cameras: not given; to estimate a calibration from the people "
      "(insert the size of your images): {} calibrate{} "
      "--image_size={},{}{} --out=cameras.json",
      DriverName(), Flag("detections", FLAGS_detections), width, height, more));
}

// Throws for an unusable --out before the recording is examined. Missing
// folders are made only when the configuration is written.
void CheckOutput() {
  if (IsStream(FLAGS_out)) return;
  const size_t slash = FLAGS_out.rfind('/');
  if (slash != std::string::npos) {
    const std::string folder = FLAGS_out.substr(0, slash);
    const bool exists = IsFolder(folder) || IsFile(folder);
    if (slash > 0 && !exists) return;
  }
  AtomicFile unused(FLAGS_out);
}

void RunInit() {
  UseAdapterFlag();
  RequireFlag("detections", FLAGS_detections);
  if (FLAGS_cameras.empty()) OfferCalibrate();
  RequireFlag("out", FLAGS_out);
  if (FLAGS_out == "-") FailFlag("out", FLAGS_out, "the name of a file");
  CheckOutput();
  const SurveyRequest request = RequestOfFlags();
  RecordingSurvey survey = SurveyRecording(request);
  NameInputs(
      Flag("cameras", FLAGS_cameras) + Flag("detections", FLAGS_detections),
      Flag("config", FLAGS_out), "", &survey.report.warnings);
  const std::string text = WithGivenKeys(request.options, ConfigText(survey));
  std::fputs(FindingsText(survey, request.options).c_str(), stdout);
  WriteTextFile(WithFolders(FLAGS_out), text);
  std::printf("configuration -> %s\n", FLAGS_out.c_str());
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::RunApp(
      argc, argv,
      {"init",
       "examines a recording and writes a configuration for it",
       "--cameras=F --detections=PATH [--frame_rate=HZ] [--set=KEY=VALUE;...] "
       "--out=F.toml",
       {"--cameras=calibration.json --detections=openpose/ --frame_rate=25 "
        "--out=my.toml",
        "--cameras=calibration.json --detections=openpose/ "
        "--set=skeleton=body25 --out=my.toml"}},
      kinegraph::RunInit);
}
