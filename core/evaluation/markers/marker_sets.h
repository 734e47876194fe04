// Joints from the markers of a laboratory, or from the body segments of another
// program (Theia3D).
#ifndef KINEGRAPH_CORE_EVALUATION_MARKERS_MARKER_SETS_H_
#define KINEGRAPH_CORE_EVALUATION_MARKERS_MARKER_SETS_H_

#include <string>
#include <vector>

#include "core/data/joint_rules.h"
#include "core/data/pose.h"

namespace kinegraph {

// Plug-in Gait, Qualisys Sports, CAST, OpenCap, Theia3D's segments.
const std::vector<MarkerSet>& MarkerSets();

// The set that contains the most of the labels, in any spelling ("LKNE",
// "Anna:l_kne"); nullptr if none contains four, not counting names of joints.
const MarkerSet* RecogniseMarkerSet(const std::vector<std::string>& labels);

struct MarkerJoints {
  TrackSequence tracks;         // of the joints that the rules define
  std::vector<bool> is_centre;  // one per joint
  // Joints left out, each with one of its missing markers.
  std::vector<std::string> lacking;
};

// A joint is missing in frames in which one of its markers is. Throws
// InputError, which does not name the file, when there are markers of several
// people, when no rule has its markers, or when the thigh rotates too little
// for a functional hip.
MarkerJoints JointsOfMarkers(const TrackSequence& markers,
                             const MarkerSet& set);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_MARKERS_MARKER_SETS_H_
