// kinegraph-report: one self-contained page to look at a result.
#include <gflags/gflags.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/app.h"
#include "apps/common/summary.h"
#include "apps/report/ground.h"
#include "apps/report/page.h"
#include "apps/report/page_data.h"
#include "core/base/error.h"
#include "core/io/calibration.h"
#include "core/io/detection_source.h"
#include "core/io/tracks.h"
#include "core/io/view_pairing.h"
#include "solvers/session/run.h"

DEFINE_string(tracks, "", "one result, or two on the same clock: a,b");
DEFINE_string(ground_truth, "", "ground truth to show beside the tracks");
DEFINE_string(cameras, "", "calibration file or folder");
DEFINE_string(detections, "", "2D detections: a file or a folder");
DEFINE_string(config, "",
              "configuration that says how cameras and detections "
              "are read (TOML, as for track)");
DEFINE_string(set, "", "keys to change: key=value;key=value");
DEFINE_string(title, "", "heading of the page; default: the tracks' name");
DEFINE_string(up, "auto", "upward axis: auto, x, y, z, -x, -y or -z");
DEFINE_bool(with_covariance, false, "keep covariances, for the ellipsoids");
DEFINE_string(out, "", "page to write (HTML)");

namespace kinegraph {
namespace {

std::string BaseName(const std::string& path) {
  const size_t end = path.find_last_not_of('/') + 1;
  const size_t slash = path.rfind('/', end == 0 ? 0 : end - 1);
  return path.substr(slash == std::string::npos ? 0 : slash + 1,
                     end - (slash == std::string::npos ? 0 : slash + 1));
}

std::vector<PageResult> ReadResults() {
  std::vector<PageResult> results;
  const std::vector<std::string> paths = ParseList(FLAGS_tracks, "tracks");
  if (paths.size() > 2) {
    throw InputError("--tracks: found " + std::to_string(paths.size()) +
                     " files, expected one or two");
  }
  for (const std::string& path : paths) {
    results.push_back({BaseName(path), ResultRole::kTracks, ReadTracks(path)});
  }
  if (!FLAGS_ground_truth.empty()) {
    results.push_back({BaseName(FLAGS_ground_truth), ResultRole::kGroundTruth,
                       ReadTracks(FLAGS_ground_truth)});
  }
  return results;
}

void ReadViews(const RunOptions& options, PageInput* input) {
  if (FLAGS_cameras.empty()) {
    if (FLAGS_detections.empty()) return;
    throw InputError("--detections: needs --cameras");
  }
  CameraRig rig = ReadCameras(FLAGS_cameras, options.cameras);
  if (FLAGS_detections.empty()) {
    input->cameras = std::move(rig);
    return;
  }
  input->detections =
      ReadDetections(FLAGS_detections, DetectionOptionsOf(options));
  input->cameras = CamerasOfViews(input->detections->header.view_names, rig,
                                  options.cameras.map);
}

// "1.2 MB"
std::string Megabytes(size_t bytes) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.1f MB",
                static_cast<double>(bytes) / 1e6);
  return text;
}

// What the page holds beyond the poses.
std::string Extras(const PageData& data) {
  std::string text;
  if (data.detection_bytes > 0) {
    text += ", detections " + Megabytes(data.detection_bytes);
  }
  if (data.covariance_bytes > 0) {
    text += ", covariances " + Megabytes(data.covariance_bytes);
  }
  return text;
}

void PrintSummary(const PageData& data, size_t page_bytes) {
  std::FILE* const summary = SummaryStream(FLAGS_out);
  std::fprintf(
      summary, "%zu frames, %zu poses, %zu moments, %s (data %s%s) -> %s\n",
      data.frames, data.poses, data.moments, Megabytes(page_bytes).c_str(),
      Megabytes(data.json.size()).c_str(), Extras(data).c_str(),
      FLAGS_out.c_str());
  if (data.frame_stride > 1) {
    std::fprintf(summary, "decimated: one frame in %d is kept\n",
                 data.frame_stride);
  }
  if (data.extras_stride > 1) {
    std::fprintf(summary,
                 "decimated: detections and covariances of one frame in %d\n",
                 data.extras_stride);
  }
}

void RunReport() {
  RequireFlag("tracks", FLAGS_tracks);
  RequireFlag("out", FLAGS_out);
  PageOptions page_options;
  page_options.up = ParseUp(FLAGS_up);
  page_options.with_covariance = FLAGS_with_covariance;
  RunOptions run_options;
  if (!FLAGS_config.empty()) {
    run_options = ReadRunOptions(FLAGS_config, FLAGS_set, "");
  } else if (!FLAGS_set.empty()) {
    throw InputError("--set: needs --config");
  }
  PageInput input;
  input.results = ReadResults();
  input.title = FLAGS_title.empty() ? input.results.front().label : FLAGS_title;
  ReadViews(run_options, &input);

  const PageData data = MakePageData(input, page_options);
  PrintSummary(data, WritePage(input.title, data.json, FLAGS_out));
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::RunApp(
      argc, argv,
      {"report", "one self-contained page to look at tracks",
       "--tracks=F[,F2] [--ground_truth=F] [--cameras=F --detections=PATH] "
       "--out=F.html"},
      kinegraph::RunReport);
}
