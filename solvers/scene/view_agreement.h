// Measures how well the views of a recording agree under some reading of its
// calibration (an interpretation, such as another pose convention), from 2D
// detections alone, frame by frame and without tracking: people seen in two
// views must lie on each other's epipolar lines and in front of both cameras.
#ifndef KINEGRAPH_SOLVERS_SCENE_VIEW_AGREEMENT_H_
#define KINEGRAPH_SOLVERS_SCENE_VIEW_AGREEMENT_H_

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/data/detection.h"
#include "core/geometry/camera.h"

namespace kinegraph {

// The detections of one view over the recording, restricted to the compared
// joints.
struct ViewPeople {
  struct Person {
    std::vector<Eigen::Vector2d> px;  // one per compared joint
    std::vector<char> found;
    double size_px = 0.0;  // diagonal of the box around the joints
  };
  std::vector<std::vector<Person>> frames;  // [frame][person]
};

// The people of each view in raw pixels, with joints of at least
// kMinJointConfidence; people with fewer than six such joints (all, for smaller
// skeletons) are ignored. Keeps at most a hundred people per image, those with
// the most joints.
std::vector<ViewPeople> PeopleOfViews(const DetectionSequence& detections);

// The people in ideal pixels: undistorted by the view's camera. Joints that
// cannot be undistorted become not found.
ViewPeople Undistorted(ViewPeople view, const Camera& camera);
std::vector<ViewPeople> Undistorted(std::vector<ViewPeople> views,
                                    const CameraRig& cameras);
std::vector<ViewPeople> IdealPeople(const DetectionSequence& detections,
                                    const CameraRig& cameras);

// 0 .. count - 1.
std::vector<int> IndicesUpTo(size_t count);

// Up to `count` of the frames, evenly spaced, beginning with the first.
std::vector<int> Evenly(const std::vector<int>& frames, size_t count);

// The frames with these indices.
DetectionSequence FramesOf(const DetectionSequence& detections,
                           const std::vector<int>& frames);

// Index of the frame with a number, or -1.
int64_t IndexOfFrame(const DetectionSequence& detections, int64_t number);

// The detections with frame `source(view, k)` of each view in place of its
// frame k; empty if there is no such frame. Frame times are unchanged.
template <typename Source>
DetectionSequence FramesMoved(const DetectionSequence& detections,
                              const Source& source) {
  DetectionSequence moved = detections;
  const auto count = static_cast<int64_t>(detections.frames.size());
  for (int64_t k = 0; k < count; ++k) {
    auto& views = moved.frames[k].views;
    for (size_t v = 0; v < views.size(); ++v) {
      const int64_t from = source(v, k);
      if (from == k) continue;
      views[v].detections.clear();
      if (from < 0 || from >= count) continue;
      views[v].detections = detections.frames[from].views[v].detections;
    }
  }
  return moved;
}

// Agreement of two views over some frames.
struct PairAgreement {
  double gain = 0.0;      // summed over matched people, each 0 .. 1
  double possible = 0.0;  // people that could have been matched
  // Distances from the epipolar lines [px], summed over `possible`: a person
  // contributes a tenth of the mean size of the people in the first view, times
  // 1 - gain if matched.
  double distance_px = 0.0;

  double score() const { return possible > 0.0 ? gain / possible : 0.0; }
  double mean_px() const {
    return possible > 0.0 ? distance_px / possible : 0.0;
  }
  void Add(const PairAgreement& other) {
    gain += other.gain;
    possible += other.possible;
    distance_px += other.distance_px;
  }
};

// Change in the agreement of some views under another reading of files, images
// or clocks. One rule decides whether it is accepted, and with what confidence.
struct AgreementGain {
  PairAgreement before;
  PairAgreement after;

  double gain() const { return after.score() - before.score(); }
  // In recordings without faults, wrong readings never exceeded the correct one
  // by this much; the best of many readings gains a few hundredths by chance.
  // Two views of one person agree to 0.6 to 0.9.
  static constexpr double kLeastGain = 0.08;
  static constexpr double kLeastScore = 0.3;
  static double Needed(double score_before) {
    return std::max(kLeastScore, score_before + kLeastGain);
  }
  bool is_enough() const { return after.score() >= Needed(before.score()); }
  // The confidence for such a gain; at most 0.95.
  static double Sureness(double gained, double score_after) {
    return 0.95 * std::min(1.0, gained / 0.15) *
           std::min(1.0, score_after / 0.5);
  }
  double sureness() const { return Sureness(gain(), after.score()); }
};

// Two views at several lags: frame k of `a` is compared with frame k + lag of
// `b`; both hold ideal pixels of the cameras. A pair of people gains the mean
// over common joints of max(0, 1 - d / 0.1), d the distance from the epipolar
// lines over the person's size; zero if the person would be behind a
// camera, or if fewer than six joints are common (all joints, if the skeleton
// has fewer than six).
// Pairs are matched greedily.
std::vector<PairAgreement> AgreementsOf(const Camera& camera_a,
                                        const ViewPeople& a,
                                        const Camera& camera_b,
                                        const ViewPeople& b,
                                        const std::vector<int>& frames,
                                        const std::vector<int>& lags);
// The same at a single lag.
PairAgreement AgreementOf(const Camera& camera_a, const ViewPeople& a,
                          const Camera& camera_b, const ViewPeople& b,
                          const std::vector<int>& frames, int lag = 0);

// The pairs of views that are compared, a < b: all for up to nine views; for
// more, each view with eight others, near and far in their order, so that the
// work grows linearly with the number of views.
std::vector<std::pair<size_t, size_t>> ComparedPairs(size_t view_count);

// Number of comparisons of two people over all compared pairs of views.
double ComparisonsOfAll(const std::vector<ViewPeople>& views,
                        const std::vector<int>& frames);

// Frames to examine: up to `count`, evenly spaced among those in which two or
// more views see people. Fewer, but at least two, if comparing ComparedPairs
// `repeats` times would need more than about four million comparisons of two
// people, which take a tenth of a second.
std::vector<int> FramesToLookAt(const std::vector<ViewPeople>& views, int count,
                                int repeats = 1);

// Sum over all compared pairs of views.
PairAgreement AgreementOfAll(const CameraRig& cameras,
                             const std::vector<ViewPeople>& ideal,
                             const std::vector<int>& frames);

// A person on whom two views agree, triangulated [m]; joints as in ViewPeople.
struct PlacedPerson {
  int frame = 0;
  size_t view_a = 0;
  size_t view_b = 0;
  std::vector<std::optional<Eigen::Vector3d>> joints;
};
// From all compared pairs of views, in as many of the frames as yield about
// 1,500 people.
std::vector<PlacedPerson> PlacePeople(const CameraRig& cameras,
                                      const std::vector<ViewPeople>& ideal,
                                      const std::vector<int>& frames);

// The joint of this name; nullopt if it has no position or is not compared.
std::optional<Eigen::Vector3d> PlacedJoint(const PlacedPerson& person,
                                           const Skeleton& skeleton,
                                           const std::string& name);

// Stature [m] of the people on whom two views agree, from trunk, thigh and
// shank: the median, and the number of measurements (one per side of a body;
// none if the skeleton is not human). Joints are found by name.
struct Stature {
  double median_m = 0.0;
  int count = 0;
};
Stature StatureOf(const CameraRig& cameras,
                  const std::vector<ViewPeople>& ideal,
                  const std::vector<int>& frames, const Skeleton& skeleton);
// The same, in up to `frames` frames of a recording.
Stature StatureOf(const CameraRig& cameras, const DetectionSequence& recording,
                  int frames);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_VIEW_AGREEMENT_H_
