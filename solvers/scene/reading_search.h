// A search for the reading of a calibration under which the views of a
// recording agree.
#ifndef KINEGRAPH_SOLVERS_SCENE_READING_SEARCH_H_
#define KINEGRAPH_SOLVERS_SCENE_READING_SEARCH_H_

#include <vector>

#include "core/geometry/camera.h"
#include "solvers/scene/readings.h"
#include "solvers/scene/view_agreement.h"

namespace kinegraph {

struct ReadingScore {
  Reading reading;
  double score = 0.0;  // PairAgreement::score over all views
  double distance_px = 0.0;
};

struct ReadingSearch {
  ReadingScore as_read;
  // Readings that agree better by far and fit equally well; empty when the
  // calibration is read rightly as far as can be told. Best first.
  std::vector<ReadingScore> better;
};

// Changes one thing at a time, twice at most.
ReadingSearch SearchReadings(const CameraRig& cameras,
                             const std::vector<ViewPeople>& raw,
                             const std::vector<int>& frames);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_READING_SEARCH_H_
