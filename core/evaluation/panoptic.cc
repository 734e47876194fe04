#include "core/evaluation/panoptic.h"

#include <algorithm>
#include <optional>

#include "core/base/constants.h"
#include "core/evaluation/correspondence.h"
#include "core/evaluation/pcp.h"

namespace kinegraph {
namespace {

// A pose in the order of Panoptic15.
class Panoptic15Converter {
 public:
  explicit Panoptic15Converter(const Skeleton& from)
      : source_(MapByName(from, Panoptic15())) {}

  Pose3d operator()(const Pose3d& pose) const {
    Pose3d converted(source_.size());
    for (size_t j = 0; j < source_.size(); ++j) {
      if (source_[j] >= 0) converted[j] = pose[source_[j]];
    }
    FillMiddle("neck", "l_shoulder", "r_shoulder", &converted);
    FillMiddle("mid_hip", "l_hip", "r_hip", &converted);
    return converted;
  }

 private:
  // Fills the joint only if the skeleton lacks it; a joint that was not found
  // stays missing.
  void FillMiddle(const char* middle, const char* a, const char* b,
                  Pose3d* pose) const {
    const int joint = Panoptic15().IndexOf(middle);
    if (source_[joint] >= 0) return;
    (*pose)[joint] = Middle((*pose)[Panoptic15().IndexOf(a)],
                            (*pose)[Panoptic15().IndexOf(b)]);
  }

  std::vector<int> source_;
};

// A found pose and the true person assigned to it.
struct Candidate {
  double error_m = 0.0;
  double score = 0.0;
  int64_t true_person = 0;  // counted over all frames
};

std::vector<Pose3d> TruePeople(const TrackFrame& frame,
                               const Panoptic15Converter& convert) {
  static const int kRoot = Panoptic15().IndexOf("mid_hip");
  std::vector<Pose3d> people;
  for (const PersonPose& person : frame.people) {
    Pose3d pose = convert(person.joints);
    for (Joint3d& joint : pose) {
      if (joint.status != JointStatus::kObserved) joint = Joint3d{};
    }
    if (pose[kRoot].present()) people.push_back(std::move(pose));
  }
  return people;
}

// The nearest true person; the error is infinite, which makes a false positive,
// if no joints can be compared.
Candidate AssignNearest(const Pose3d& found,
                        const std::vector<Pose3d>& true_people,
                        int64_t first_person, const JointPairs& joints,
                        Share* compared) {
  Candidate nearest = {kNoGate, 0.0, first_person};
  const Pose3d* assigned = nullptr;
  for (size_t i = 0; i < true_people.size(); ++i) {
    const auto distance = MeanDistance(true_people[i], found, joints);
    if (!distance || *distance >= nearest.error_m) continue;
    nearest = {*distance, 0.0, first_person + static_cast<int64_t>(i)};
    assigned = &true_people[i];
  }
  for (size_t j = 0; assigned != nullptr && j < found.size(); ++j) {
    if ((*assigned)[j].present()) compared->Add(found[j].present());
  }
  return nearest;
}

// Marks each candidate, in order, that is the first within the threshold for
// its true person.
std::vector<bool> FirstWithin(const std::vector<Candidate>& candidates,
                              int64_t true_people, double threshold_m) {
  std::vector<bool> taken(static_cast<size_t>(true_people), false);
  std::vector<bool> first;
  for (const Candidate& candidate : candidates) {
    const bool is_first =
        candidate.error_m < threshold_m && !taken[candidate.true_person];
    if (is_first) taken[candidate.true_person] = true;
    first.push_back(is_first);
  }
  return first;
}

double AveragePrecision(const std::vector<bool>& right, int64_t true_people) {
  if (true_people == 0) return kNan;
  std::vector<double> precision;
  int64_t count = 0;
  for (size_t i = 0; i < right.size(); ++i) {
    count += right[i] ? 1 : 0;
    precision.push_back(static_cast<double>(count) /
                        static_cast<double>(i + 1));
  }
  for (size_t i = precision.size(); i > 1; --i) {
    precision[i - 2] = std::max(precision[i - 2], precision[i - 1]);
  }
  double sum = 0.0;
  for (size_t i = 0; i < right.size(); ++i) {
    if (right[i]) sum += precision[i];
  }
  return sum / static_cast<double>(true_people);
}

}  // namespace

PanopticResult EvaluatePanoptic(const TrackSequence& truth,
                                const TrackSequence& tracks,
                                const PanopticOptions& options) {
  const Panoptic15Converter convert_truth(truth.header.skeleton);
  const Panoptic15Converter convert_found(tracks.header.skeleton);
  const JointPairs joints = SameJoints(Panoptic15().joints().size());
  PanopticResult result;
  std::vector<Candidate> candidates;
  int64_t true_people = 0;
  for (const FramePair& both :
       PairFrames(truth, tracks, options.frames).pairs) {
    if (both.truth == nullptr) continue;
    const std::vector<Pose3d> people = TruePeople(*both.truth, convert_truth);
    if (people.empty()) continue;
    for (const PersonPose& person : PeopleOf(both.tracks)) {
      Candidate candidate =
          AssignNearest(convert_found(person.joints), people, true_people,
                        joints, &result.joints_compared);
      candidate.score = person.score;
      candidates.push_back(candidate);
    }
    true_people += static_cast<int64_t>(people.size());
  }
  result.found_person_frames = static_cast<int64_t>(candidates.size());
  std::stable_sort(
      candidates.begin(), candidates.end(),
      [](const Candidate& a, const Candidate& b) { return a.score > b.score; });

  for (const double threshold_m : options.thresholds_m) {
    const std::vector<bool> right =
        FirstWithin(candidates, true_people, threshold_m);
    result.average_precision.push_back(AveragePrecision(right, true_people));
    result.recall.push_back(
        {std::count(right.begin(), right.end(), true), true_people});
  }
  std::vector<double> errors;
  const std::vector<bool> within =
      FirstWithin(candidates, true_people, options.recall_threshold_m);
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (within[i]) errors.push_back(candidates[i].error_m);
  }
  result.mpjpe_m = Mean(errors);
  result.recall_at_limit = {static_cast<int64_t>(errors.size()), true_people};
  return result;
}

}  // namespace kinegraph
