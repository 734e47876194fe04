// The poses of one result as the page has them: small integers in arrays.
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
  // Coordinates are told in steps that the largest person of `tracks` allows.
  PoseArrays(const TrackSequence& tracks, size_t view_count);

  size_t count() const { return frame_.size(); }

  // A pose: its frame on the page's clock, and its person's index in the ids.
  void Add(const PersonPose& person, uint32_t frame, uint16_t person_idx);
  // What belongs to the pose that was added last. A negative difference: none.
  void AddResiduals(const std::vector<ViewPair>& pairs);
  void AddDifference(double difference_m);
  // "Extras", of frames on the extras' stride alone.
  void AddMatches(const PersonPose& person, const std::vector<ViewPair>& pairs,
                  const DetectionPairing& pairing);
  void AddCovariances(const PersonPose& person);

  // Poses, and what is there beside them, whose bytes are counted in `data`.
  void PosesTo(Json* json) const;
  void DetailsTo(Json* json, PageData* data) const;

 private:
  const double quantum_m_;  // of the joints
  const size_t view_count_;
  std::vector<uint32_t> frame_;
  std::vector<uint16_t> person_;
  std::vector<int32_t> root_;         // 3 a pose, quanta
  std::vector<int16_t> joints_;       // 3 a joint, quanta from the root
  std::vector<uint8_t> status_;       // a joint: status + 4 * inlier views
  std::vector<uint16_t> residual_;    // a view
  std::vector<uint16_t> difference_;  // a pose
  std::vector<int16_t> match_;        // a view (extras)
  std::vector<uint8_t> weight_;       // a joint of a view (extras)
  std::vector<int16_t> covariance_;   // 6 a joint (extras)
};

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_REPORT_POSE_ARRAYS_H_
