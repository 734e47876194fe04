// Synthetic tracks: bodies of different size that walk along straight lines.
#ifndef KINEGRAPH_TESTS_CORE_IDENTITY_CROWD_H_
#define KINEGRAPH_TESTS_CORE_IDENTITY_CROWD_H_

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/base/random.h"
#include "core/data/pose.h"
#include "core/skeleton/skeleton.h"
#include "tests/support/rig.h"

namespace kinegraph::testing {

inline constexpr double kCrowdRate = 25.0;  // Hz

// A person in frames first .. last who walks from `from` at a constant
// velocity; `size` scales the body.
struct Walk {
  int64_t id = 0;
  int64_t first = 0;
  int64_t last = 0;
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d velocity_mps = Eigen::Vector2d::Zero();
  double size = 1.0;
  bool seen = true;  // by any view
};

class CrowdMaker {
 public:
  // `frames` frames without people.
  explicit CrowdMaker(int64_t frames, uint64_t seed = 1) : random_(seed) {
    const FrameClock clock(kCrowdRate);
    for (int64_t f = 0; f < frames; ++f) {
      frames_.push_back({f, clock.TimeOf(f), {}});
    }
  }

  // `sigma_m` is the noise of each coordinate.
  CrowdMaker& Add(const Walk& walk, double sigma_m = 0.01) {
    for (int64_t f = walk.first; f <= walk.last; ++f) {
      const double time_s = static_cast<double>(f - walk.first) / kCrowdRate;
      const Eigen::Vector2d at = walk.from + time_s * walk.velocity_mps;
      PersonPose person;
      person.id = TrackId(walk.id);
      person.joints = StandingPerson(0.0, 0.0);
      person.inlier_views.assign(person.joints.size(), walk.seen ? 3 : 0);
      for (Joint3d& joint : person.joints) {
        joint.position_m *= walk.size;
        if (!walk.seen) joint.status = JointStatus::kInferred;
        joint.position_m.head<2>() += at;
        joint.position_m +=
            sigma_m * Eigen::Vector3d(random_.Normal(), random_.Normal(),
                                      random_.Normal());
      }
      std::vector<PersonPose>& people = frames_[static_cast<size_t>(f)].people;
      people.push_back(std::move(person));
      std::stable_sort(
          people.begin(), people.end(),
          [](const PersonPose& a, const PersonPose& b) { return a.id < b.id; });
    }
    return *this;
  }

  const std::vector<TrackFrame>& frames() const { return frames_; }

 private:
  std::vector<TrackFrame> frames_;
  Random random_;
};

// Identities in a frame.
inline std::vector<int64_t> IdsIn(const TrackFrame& frame) {
  std::vector<int64_t> ids;
  for (const PersonPose& person : frame.people)
    ids.push_back(person.id.value());
  return ids;
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_CORE_IDENTITY_CROWD_H_
