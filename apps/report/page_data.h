// The data of the page of `report` and its encoding: numbers quantised to small
// integers, so that long recordings stay small.
#ifndef KINEGRAPH_APPS_REPORT_PAGE_DATA_H_
#define KINEGRAPH_APPS_REPORT_PAGE_DATA_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/data/detection.h"
#include "core/data/identity_edit.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"

namespace kinegraph {

// Assumed frame rate if neither the video nor the tracks have one, or if the
// times of the tracks do not ascend.
inline constexpr double kFallbackRateHz = 25.0;

// A video behind a panel.
struct PageVideo {
  std::string source;       // a path relative to the page; empty: `bytes`
  std::string bytes;        // the file, embedded in the page
  std::string type;         // "video/mp4"
  int64_t first_frame = 0;  // frame number of its first image
  // Start of each image and end of the last one [s].
  std::vector<double> times_s;
};

enum class ResultRole { kTracks, kGroundTruth };

struct PageResult {
  std::string label;  // shown as plain text, never as markup
  ResultRole role = ResultRole::kTracks;
  TrackSequence tracks;
  // NAME.summary.json, written by `track` beside the tracks; empty: none.
  std::string summary_json = {};
  // The identity decisions in NAME.identity.jsonl, and its lines verbatim,
  // which the page exports together with corrections made on the page.
  std::vector<IdentityEdit> identity_edits = {};
  std::vector<std::string> identity_lines = {};
  PersonNames names = {};
};

struct PageInput {
  std::string title;
  std::string doctor_json = {};  // DIR/doctor.json of `doctor`; empty: none
  // One or more. The first one determines the page's up direction and floor,
  // and the colours of the others; a ground truth is the last one.
  std::vector<PageResult> results;
  CameraRig cameras;  // in the order of the detections' views
  std::optional<DetectionSequence> detections;  // requires cameras
  // Images behind the panels: one path per camera, relative to the page, with
  // a placeholder such as %06d for the frame number; empty: none.
  std::vector<std::string> image_patterns;
  // Instead, embedded images: one map per camera, JPEG or PNG by frame number.
  std::vector<std::map<int64_t, std::string>> pictures;
  // Or videos: one per camera, or nullopt.
  std::vector<std::optional<PageVideo>> videos;
};

struct PageOptions {
  bool with_covariance = false;
  // Unit vector; nullopt: estimated from people, cameras and the vertical axis
  // of the tracks' format.
  std::optional<Eigen::Vector3d> up;
  size_t max_bytes = 50000000;  // of the data; more is decimated
  // The vertical axis of the first result's format, if it has one (StatedUp).
  std::optional<Eigen::Vector3d> stated_up = {};
};

// The encoded data, and what was left out to keep it small.
struct PageData {
  std::string json;      // safe inside a <script> element
  size_t frames = 0;     // on the page's clock
  size_t poses = 0;      // of all results
  int frame_stride = 1;  // 2: every second frame is kept
  // 2: every second kept frame has detections, matches, weights and
  // covariances.
  int extras_stride = 1;
  size_t moments = 0;  // entries of the page's list "Worst moments"
  // Sizes of the parts of `json` other than the poses [bytes].
  size_t detection_bytes = 0;  // with matches, weights and residuals
  size_t covariance_bytes = 0;
  size_t picture_bytes = 0;
  // About parts that were left out and an unknown up direction.
  std::vector<std::string> notes;
};

// Throws InputError if there is no frame to show, or if the doctor's file is
// invalid.
PageData MakePageData(const PageInput& input, const PageOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_REPORT_PAGE_DATA_H_
