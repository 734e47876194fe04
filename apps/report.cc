// kinegraph-report: writes one self-contained page that displays a result.
#include <fmt/format.h>
#include <gflags/gflags.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/adapter_flag.h"
#include "apps/common/app.h"
#include "apps/common/config_folder.h"
#include "apps/common/progress.h"
#include "apps/common/track_files.h"
#include "apps/report/page.h"
#include "apps/report/page_data.h"
#include "apps/report/view_images.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/evaluation/correspondence.h"
#include "core/evaluation/frame_pairing.h"
#include "core/io/calibration/calibration.h"
#include "core/io/configuration/refinement_record.h"
#include "core/io/detections/source.h"
#include "core/io/detections/view_pairing.h"
#include "core/io/files/side_files.h"
#include "core/io/files/text_file.h"
#include "core/io/text/joint_names.h"
#include "core/io/text/json.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/identity_edits.h"
#include "core/io/tracks/reading_notes.h"
#include "core/kinematics/ground.h"
#include "solvers/session/ready_recording.h"
#include "solvers/session/run.h"

DEFINE_string(tracks, "",
              "one result, or up to six with the same clock: a,b,...");
DEFINE_string(ground_truth, "", "ground truth to show beside the tracks");
DEFINE_string(cameras, "", "calibration file or folder");
DEFINE_string(detections, "", "2D detections: a file or a folder");
DEFINE_string(config, "",
              "configuration for reading cameras and detections (TOML, as for "
              "track)");
DEFINE_string(set, "", "keys to change: key=value;key=value");
DEFINE_string(without_cameras, "", "names of cameras to leave out: a,b");
DEFINE_string(images, "",
              "pictures or videos behind the panels: VIEW=PATTERN;VIEW=VIDEO, "
              "where %06d or the like in a pattern stands for the frame number "
              "(JPEG or PNG), and a video (.mp4, .m4v, .mov, .webm, .mkv) "
              "begins with frame 0, or N with VIDEO@N; the page links to the "
              "files");
DEFINE_double(embed_megabytes, 0.0,
              "embed the files of --images in the page unchanged, with "
              "pictures of as many frames as fit into this size [MB]; 0: link "
              "to the files");
DEFINE_string(doctor, "",
              "folder that `doctor` wrote for this recording; its findings "
              "appear at the top of the page");
DEFINE_string(title, "", "heading of the page; default: the tracks' name");
DEFINE_string(up, "auto", "upward axis: auto, x, y, z, -x, -y or -z");
DEFINE_string(unit, "",
              "unit of tracks whose format does not specify it (such as BVH): "
              "m, cm or mm");
DEFINE_bool(with_covariance, false,
            "keep covariances, for ellipsoids and intervals");
DEFINE_string(out, "", "page to write (HTML)");

namespace kinegraph {
namespace {

std::string BaseName(const std::string& path) {
  const size_t end = path.find_last_not_of('/') + 1;
  const size_t slash = path.rfind('/', end == 0 ? 0 : end - 1);
  const size_t begin = slash == std::string::npos ? 0 : slash + 1;
  return path.substr(begin, end - begin);
}

// More could not be distinguished on the page.
constexpr size_t kMaxResults = 6;

// If several results have the same file name, labels each with its whole path.
void NameApart(const std::vector<std::string>& paths,
               std::vector<PageResult>* results) {
  for (size_t i = 0; i < paths.size(); ++i) {
    const auto same =
        std::count_if(paths.begin(), paths.end(), [&](const std::string& path) {
          return BaseName(path) == BaseName(paths[i]);
        });
    if (same > 1) (*results)[i].label = paths[i];
  }
}

// Reads the people's names, and the edits of NAME.identity.jsonl if `track`
// wrote one.
void ReadIdentity(const std::string& path, PageResult* result,
                  std::vector<std::string>* notes) {
  result->names = ReadPersonNames(path);
  const std::string edits = SideFileOf(path, kIdentityEnd, notes);
  if (edits.empty()) return;
  result->identity_edits = ReadIdentityEdits(edits);
  std::istringstream text(ReadTextFile(edits, kMaxSmallFileBytes));
  for (std::string line; std::getline(text, line);) {
    if (line.empty() || IsFingerprintLine(line)) continue;
    result->identity_lines.push_back(line);
  }
}

std::vector<PageResult> ReadResults() {
  std::vector<PageResult> results;
  const std::vector<std::string> paths = ParseList(FLAGS_tracks, "tracks");
  if (paths.size() > kMaxResults) {
    throw InputError(fmt::format("--tracks: found {} files, expected one to {}",
                                 paths.size(), kMaxResults));
  }
  std::vector<std::string> all = paths;
  if (!FLAGS_ground_truth.empty()) all.push_back(FLAGS_ground_truth);
  const TrackInput input("report", FLAGS_unit, all);
  std::vector<std::string> notes;
  for (const std::string& path : paths) {
    results.push_back({BaseName(path), ResultRole::kTracks, input.Read(path)});
    const std::string summary = SideFileOf(path, kSummaryEnd, &notes);
    if (!summary.empty()) {
      results.back().summary_json = ReadTextFile(summary, kMaxSmallFileBytes);
    }
    ReadIdentity(path, &results.back(), &notes);
  }
  SayNotes(notes);
  NameApart(paths, &results);
  if (!FLAGS_ground_truth.empty()) {
    results.push_back({BaseName(FLAGS_ground_truth), ResultRole::kGroundTruth,
                       input.Read(FLAGS_ground_truth)});
  }
  // Results are compared joint by joint, in the frames of the first one.
  const TrackSequence& lead = results.front().tracks;
  const Skeleton& first = lead.header.skeleton;
  for (PageResult& result : results) {
    Skeleton& skeleton = result.tracks.header.skeleton;
    skeleton = WithOurNames(skeleton);
    RequireCommonJoints(first, results.front().label, skeleton, result.label);
    if (&result == &results.front()) continue;
    SayNotes(NumberFramesLike(lead, {result.label, results.front().label},
                              &result.tracks),
             "kinegraph-report: ");
  }
  return results;
}

// Whether the run was configured to change cameras or clocks. Headers written
// by other programs may contain anything.
bool WereCamerasMoved(const TrackHeader& header) {
  const Json config = ParseJson(header.config_json, "the configuration");
  const auto says = [&config](const char* key, const Json& usual) {
    const Json::json_pointer place = Json::json_pointer("/cameras") / key;
    return config.contains(place) && config.at(place) != usual;
  };
  return says("refine", "off") || says("refine_clock", false) ||
         says("ground", "off");
}

// The cameras of --cameras; if `track` changed them, the cameras that it wrote
// beside the result, because the result fits the images only with these. Sets
// `path` to the file read.
CameraRig CamerasOfResult(const RunOptions& options, const PageInput& input,
                          std::string* path) {
  std::vector<std::string> notes;
  std::string moved;
  if (WereCamerasMoved(input.results.front().tracks.header)) {
    moved = SideFileOf(ParseList(FLAGS_tracks, "tracks").front(), kCamerasEnd,
                       &notes);
  }
  SayNotes(notes);
  *path = moved.empty() ? FLAGS_cameras : moved;
  if (moved.empty()) return ReadCameras(FLAGS_cameras, options.cameras);
  if (moved != FLAGS_cameras) {
    std::fprintf(SummaryStream(FLAGS_out),
                 "cameras as changed by `track`: %s\n", moved.c_str());
  }
  // Without options.cameras: `track` has already applied unit and selection.
  return ReadCameras(moved);
}

// Leaves out the cameras of --without_cameras.
void LeaveOutCameras(CameraRig* cameras) {
  for (const std::string& name :
       ParseList(FLAGS_without_cameras, "without_cameras")) {
    const auto at = std::find_if(
        cameras->begin(), cameras->end(),
        [&name](const Camera& camera) { return camera.name() == name; });
    if (at == cameras->end()) {
      throw InputError("--without_cameras: no camera is named '" +
                       Printable(name) + "'");
    }
    cameras->erase(at);
  }
}

// Names the cameras whose clocks are off by half a frame or more. Their
// pictures and videos are shown at the recorded times.
void SayImagesKeepTheirClocks(const RefinementRecord& record, double rate_hz,
                              const std::string& path) {
  std::string names;
  for (const RefinementRecord::Camera& camera : record.cameras) {
    if (std::abs(camera.offset_s) * rate_hz < 0.5) continue;
    names += (names.empty() ? "" : ", ") + Printable(camera.name);
  }
  if (names.empty()) return;
  SayNotes({"the clocks in " + path +
            " are not applied to the pictures and videos of " + names});
}

// The detections with the clocks of the cameras that were read from `path`, as
// `track` used them.
DetectionSequence ReadClocked(const RunOptions& options, const CameraRig& rig,
                              const std::string& path,
                              const TrackHeader& tracks) {
  DetectionReadOptions read = DetectionOptionsOf(options);
  read.any_clock = true;  // as in `track`
  DetectionSequence detections = ReadDetections(FLAGS_detections, read);
  const auto record = ReadRefinementRecord(path);
  if (!record.has_value() || !record->has_clocks()) return detections;
  if (!(detections.header.frame_rate_hz > 0.0) && tracks.frame_rate_hz > 0.0) {
    // Without a rate the frames may have no times, which clocks need.
    read.frame_rate_hz = tracks.frame_rate_hz;
    detections = ReadDetections(FLAGS_detections, read);
  }
  if (!FLAGS_images.empty()) {
    SayImagesKeepTheirClocks(*record, detections.header.frame_rate_hz, path);
  }
  RunRequest request;
  request.cameras = rig;
  request.without_cameras = ParseList(FLAGS_without_cameras, "without_cameras");
  return WithRecordedClocks(options, request, *record, detections);
}

void ReadViews(RunOptions options, PageInput* input) {
  if (FLAGS_cameras.empty()) {
    if (!FLAGS_detections.empty()) {
      throw InputError("--detections: needs --cameras");
    }
    if (!FLAGS_without_cameras.empty()) {
      throw InputError("--without_cameras: needs --cameras");
    }
    return;
  }
  std::string path;
  CameraRig rig = CamerasOfResult(options, *input, &path);
  if (FLAGS_detections.empty()) {
    LeaveOutCameras(&rig);
    input->cameras = std::move(rig);
    return;
  }
  if (WereCamerasMoved(input->results.front().tracks.header)) {
    // `track` writes only the cameras that it used.
    for (const Camera& camera : rig) {
      options.cameras.use.push_back(camera.name());
    }
  }
  input->detections =
      ReadClocked(options, rig, path, input->results.front().tracks.header);
  UsedViews used =
      ChooseViews(input->detections->header.view_names, rig, options.cameras,
                  ParseList(FLAGS_without_cameras, "without_cameras"));
  input->cameras = std::move(used.cameras);
  KeepViews(used.views, &*input->detections);
}

int64_t FrameCount(const PageInput& input) {
  return static_cast<int64_t>(input.results.front().tracks.frames.size());
}

// "cam1: 12 frames are not in its video", one line per view.
std::string WhatVideosLack(const ViewImages& images, const PageInput& input) {
  std::string text;
  for (size_t v = 0; v < images.videos.size(); ++v) {
    if (!images.videos[v].has_value()) continue;
    const size_t lacks = FramesWithout(*images.videos[v], input);
    if (lacks == 0) continue;
    text += fmt::format(
        "{}: {} not in its video\n", input.detections->header.view_names[v],
        Counted(static_cast<int64_t>(lacks), "frame is", "frames are"));
  }
  return text;
}

// Links images and videos or embeds them in the page. Returns lines on frames
// without a video image and on the number of embedded pictures.
std::string AddImages(const ViewImages& images, PageInput* input) {
  const auto max_bytes = static_cast<size_t>(1e6 * FLAGS_embed_megabytes);
  const size_t taken = AddVideos(images, FLAGS_out, max_bytes, input);
  std::string text = WhatVideosLack(images, *input);
  if (FLAGS_embed_megabytes == 0.0) {
    for (const std::string& pattern : images.patterns) {
      input->image_patterns.push_back(
          pattern.empty() ? "" : RelativeToFile(pattern, FLAGS_out));
    }
    return text;
  }
  if (!images.has_patterns()) return text;
  Progress progress("pictures", FrameCount(*input));
  const EmbeddedPictures embedded = EmbedPictures(
      images.patterns,
      std::max<size_t>(1, max_bytes - std::min(max_bytes, taken)),
      [&progress](int64_t frames) { progress.Set(frames); }, input);
  return text +
         fmt::format("{} inside the page{}\n",
                     Counted(static_cast<int64_t>(embedded.count), "picture",
                             "pictures"),
                     embedded.stride > 1
                         ? fmt::format(", one frame in {}", embedded.stride)
                         : "");
}

void CheckPictureFlags(const PageInput& input) {
  if (!(FLAGS_embed_megabytes >= 0.0 && FLAGS_embed_megabytes <= 1000.0)) {
    throw InputError("--embed_megabytes: expected 0 .. 1000");
  }
  if (FLAGS_embed_megabytes > 0.0 && FLAGS_images.empty()) {
    throw InputError("--embed_megabytes: needs --images");
  }
  if (!FLAGS_images.empty() && !input.detections.has_value()) {
    throw InputError("--images: needs --cameras and --detections");
  }
}

// "1.2 MB"
std::string Megabytes(size_t bytes) {
  return fmt::format("{:.1f} MB", static_cast<double>(bytes) / 1e6);
}

std::string SummaryText(const PageData& data, size_t page_bytes) {
  std::string extras;  // contents of the page besides the poses
  for (const auto& [name, bytes] :
       {std::pair{", detections ", data.detection_bytes},
        {", pictures ", data.picture_bytes},
        {", covariances ", data.covariance_bytes}}) {
    if (bytes > 0) extras += name + Megabytes(bytes);
  }
  std::string text = fmt::format(
      "{} frames, {} poses, {} worst moments, {} (data {}{}) -> {}\n",
      data.frames, data.poses, data.moments, Megabytes(page_bytes),
      Megabytes(data.json.size()), extras, FLAGS_out);
  if (data.frame_stride > 1) {
    text +=
        fmt::format("decimated: one frame in {} is kept\n", data.frame_stride);
  }
  if (data.extras_stride > 1) {
    text += fmt::format(
        "decimated: one frame in {} of the page has detections and "
        "covariances\n",
        data.extras_stride);
  }
  for (const std::string& note : data.notes) text += note + "\n";
  return text;
}

void RunReport() {
  UseAdapterFlag();
  RequireFlag("tracks", FLAGS_tracks);
  RequireFlag("out", FLAGS_out);
  PageOptions page_options;
  page_options.up = ParseUp(FLAGS_up);
  page_options.with_covariance = FLAGS_with_covariance;
  RunOptions run_options;
  if (!FLAGS_config.empty()) {
    run_options = ReadRunOptions(FindConfig(FLAGS_config), FLAGS_set, "");
  } else if (!FLAGS_set.empty()) {
    throw InputError("--set: needs --config");
  }
  PageInput input;
  input.results = ReadResults();
  page_options.stated_up = StatedUp(ParseList(FLAGS_tracks, "tracks").front());
  input.title = FLAGS_title.empty() ? input.results.front().label : FLAGS_title;
  ReadViews(run_options, &input);
  if (!FLAGS_doctor.empty()) {
    input.doctor_json =
        ReadTextFile(FLAGS_doctor + "/doctor.json", kMaxSmallFileBytes);
  }
  CheckPictureFlags(input);
  ViewImages images;
  if (input.detections.has_value()) {
    images = ReadViewImages(FLAGS_images, input);
  }
  WithFolders(FLAGS_out);
  const std::string image_notes = AddImages(images, &input);

  const PageData data = MakePageData(input, page_options);
  const size_t page_bytes = WritePage(input.title, data.json, FLAGS_out);
  std::fputs((SummaryText(data, page_bytes) + image_notes).c_str(),
             SummaryStream(FLAGS_out));
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::RunApp(
      argc, argv,
      {"report",
       "one HTML page that shows tracks, cameras and detections",
       "--tracks=F[,F2,...] [--ground_truth=F] [--cameras=F "
       "--detections=PATH [--images=VIEW=PATTERN|VIDEO;...]] "
       "--out=F.html",
       {"--tracks=take.jsonl --cameras=calibration.json --detections=openpose/ "
        "--out=take.html",
        "--tracks=take.jsonl,other.jsonl --ground_truth=truth.jsonl "
        "--out=compared.html"}},
      kinegraph::RunReport);
}
