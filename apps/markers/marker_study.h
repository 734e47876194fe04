// Compares tracks with optical markers or the body segments of another program
// (Theia3D): reads, aligns and scores them (marker_study.cc), and writes the
// results (marker_output.cc).
#ifndef KINEGRAPH_APPS_MARKERS_MARKER_STUDY_H_
#define KINEGRAPH_APPS_MARKERS_MARKER_STUDY_H_

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "core/base/frame_range.h"
#include "core/data/force_plate.h"
#include "core/data/pose.h"
#include "core/evaluation/markers/agreement.h"
#include "core/evaluation/markers/alignment.h"
#include "core/evaluation/markers/gait_events.h"
#include "core/evaluation/markers/marker_sets.h"
#include "core/io/text/json.h"

namespace kinegraph {

struct MarkerRequest {
  std::string tracks;
  std::string ground_truth;
  // File with rules for the joints of the ground truth (TOML); empty: its
  // labels are those of a known marker set or names of joints.
  std::string joints;
  std::string unit;
  std::vector<FrameRange> frames;  // of the tracks; empty: all
  bool plates = false;
  AlignRequest align;
};

// Throws InputError naming --align.
Align ParseAlign(const std::string& text);
const char* ToString(Align align);

struct MarkerInput {
  std::string path;
  // Name of the marker set, or path of the rules file; empty: the file has
  // joints.
  std::string set;
  TrackSequence points;  // as in the file
  MarkerJoints joints;
};

struct MarkerStudy {
  Align align = Align::kBoth;
  MarkerInput truth;
  MarkerInput tracks;
  Alignment alignment;
  PairedMotion motion;
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  // of the truth's world
  MotionAgreement agreement;
  double block_s = 1.0;  // of the bootstrap
  bool blocks_are_strides = false;
  std::map<std::string, ValueAgreement> angles;  // degrees
  FootEvents true_events, found_events;
  // Events of the force plates, compared with the events of the markers and of
  // the tracks; empty without plates.
  std::vector<TimedEvent> true_on_plates, found_on_plates;
};

// Throws InputError naming the file.
MarkerStudy RunMarkerStudy(const MarkerRequest& request);

// The markers' joints as a ground truth for the given tracks: aligned with the
// tracks, in their frames, clock and world.
TrackSequence MarkersAsTruth(const std::string& path, const std::string& rules,
                             const TrackSequence& tracks);

// In the units that the keys specify; null if undefined.
Json MarkerJson(const MarkerStudy& study);
std::string MarkerMarkdown(const MarkerStudy& study);
// Writes markers.json, markers.md, plots and page.html to a new folder.
void WriteMarkerFolder(const MarkerStudy& study, const Json& json,
                       const std::string& folder);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_MARKERS_MARKER_STUDY_H_
