// Joints from the markers of a laboratory, or from another program's segments.
#ifndef KINEGRAPH_CORE_EVALUATION_MARKERS_MARKER_SETS_H_
#define KINEGRAPH_CORE_EVALUATION_MARKERS_MARKER_SETS_H_

#include <string>
#include <vector>

#include "core/data/joint_rules.h"
#include "core/data/pose.h"

namespace kinegraph {

// Plug-in Gait, Qualisys Sports, CAST, OpenCap, Theia3D's segments.
const std::vector<MarkerSet>& MarkerSets();

// The set that most of the labels belong to, whatever their spelling ("LKNE",
// "Anna:l_kne"); nullptr where fewer than four do, joints' own names aside.
const MarkerSet* RecogniseMarkerSet(const std::vector<std::string>& labels);

struct MarkerJoints {
  TrackSequence tracks;              // of the joints that the rules define
  std::vector<bool> is_centre;       // one a joint
  std::vector<std::string> lacking;  // joints left out, and the markers missing
};

// A joint is missing in the frames in which one of its markers is. Throws
// InputError without a file when no rule's markers are there, or when a hip
// that turns too little is asked for.
MarkerJoints JointsOfMarkers(const TrackSequence& markers,
                             const MarkerSet& set);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_MARKERS_MARKER_SETS_H_
