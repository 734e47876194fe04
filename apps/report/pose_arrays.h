// Encodes the poses of one result for the page as arrays of small integers.
#ifndef KINEGRAPH_APPS_REPORT_POSE_ARRAYS_H_
#define KINEGRAPH_APPS_REPORT_POSE_ARRAYS_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "apps/report/page_data.h"
#include "apps/report/pairing.h"
#include "core/io/text/json.h"

namespace kinegraph {

class PoseArrays {
 public:
  // Offsets of joints are quantised in the finest step, at least 0.1 mm, for
  // which the largest person of `tracks` fits into int16.
  PoseArrays(const TrackSequence& tracks, size_t view_count);

  size_t count() const { return frame_.size(); }

  // Adds a pose. `frame` is an index on the page's clock, `person_idx` an index
  // into the ids.
  void Add(const PersonPose& person, uint32_t frame, uint16_t person_idx);
  // Add data to the last pose. A negative difference means none.
  void AddResiduals(const std::vector<ViewPair>& pairs);
  void AddDifference(double difference_m);
  // Add extras to the last pose. To be called only for frames whose index is a
  // multiple of extras_stride.
  void AddMatches(const PersonPose& person, const std::vector<ViewPair>& pairs,
                  const DetectionPairing& pairing);
  void AddCovariances(const PersonPose& person);

  // PosesTo writes the poses, DetailsTo all other arrays; DetailsTo also adds
  // the sizes of detections and covariances to `data`.
  void PosesTo(Json* json) const;
  void DetailsTo(Json* json, PageData* data) const;

 private:
  const double quantum_m_;  // of joints_
  const size_t view_count_;
  std::vector<uint32_t> frame_;
  std::vector<uint16_t> person_;
  std::vector<int32_t> root_;         // 3 per pose, 0.1 mm
  std::vector<int16_t> joints_;       // 3 per joint, quanta from the root
  std::vector<uint8_t> status_;       // per joint: status + 4 * inlier views
  std::vector<uint16_t> residual_;    // per view, 0.1 px
  std::vector<uint16_t> difference_;  // per pose, mm
  std::vector<int16_t> match_;        // per view (extras)
  std::vector<uint8_t> weight_;       // per view and joint (extras)
  // Cholesky factor, 6 numbers per joint, 0.1 mm (extras).
  std::vector<int16_t> covariance_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_REPORT_POSE_ARRAYS_H_
