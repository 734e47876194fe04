// The policy of graph mode. With Eq. 1 of Chu et al. (2021) alone
// (docs/paper_mode.md) a lost track is matched with any person near its last
// position: its gate grows with its age, and a single view cannot distinguish
// people who stand behind each other. These rules prevent such exchanges of
// identity, and duplicate tracks:
//
// - A 2D tracklet (core/association/tracklets.h) of a track that has since been
//   lost still belongs to it. Another track is matched with the tracklet's
//   detections only if that track is already matched in two other views.
// - A recovery that explains only some of the views of a person, while the
//   other views would start a new track at the same place, is false. The track
//   stays lost and ends, and all views start the new one; linking
//   (core/identity) decides later whether the two are the same person.
// - Where there are so many unmatched detections that the views of an update
//   may agree by chance, the update keeps the track alive only if two thirds of
//   the measured joints are each supported by two or more views.
// - A person with few visible joints, behind a table for example, starts a
//   track when two views have agreed on those joints for long enough: six
//   joints for a second.
// - A new person at the position of a track updated in this frame is a
//   duplicate of it. A new person made of tracklets of two lost tracks is
//   rejected. So is one that is not detected by all cameras facing it, where
//   there are so many unmatched detections that its views may agree by chance.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/association/tracklets.h"
#include "core/tracking/association_policy.h"

namespace kinegraph {
namespace {

// Views of the frame in which the joints filter kept most of the joints.
std::vector<size_t> AgreeingViews(const EstimatorFrame& frame) {
  std::vector<size_t> views;
  if (!frame.has_initial) return views;
  for (const FreshView& view : frame.views) {
    const auto count = [&](FilterVerdict verdict) {
      return std::count(view.verdicts.begin(), view.verdicts.end(), verdict);
    };
    if (count(FilterVerdict::kKept) > count(FilterVerdict::kRemoved)) {
      views.push_back(static_cast<size_t>(view.view_idx));
    }
  }
  return views;
}

class GraphAssociation final : public AssociationPolicy {
 public:
  explicit GraphAssociation(const AssociationState& state) : state_(state) {
    StartAnew();
  }

  void StartAnew() override {
    slight_.clear();
    tracklets_.assign(
        state_.scene.cameras.size(),
        ViewTracklets(state_.scene.skeleton.association_joints()));
  }

  void Forbid(size_t view_idx, std::vector<char>* forbidden) override {
    tracklets_[view_idx].Follow(state_.observations.OfView(view_idx),
                                state_.time, LongestPause(0.0));
    const auto owners = LostOwners(view_idx);
    forbidden->clear();
    for (const auto& track : state_.tracks) {
      for (const std::optional<TrackId>& owner : owners) {
        forbidden->push_back(owner.has_value() && *owner != track->id);
      }
    }
  }

  // Permits detections that Forbid barred, if still unmatched, to be matched
  // with tracks that are already matched in two other views.
  bool MatchesAgain(size_t view_idx, std::vector<char>* forbidden) override {
    constexpr int kSureViews = 2;
    const size_t count = state_.observations.OfView(view_idx).size();
    std::vector<char> taken(count, 0);
    for (const int match : state_.matches[view_idx]) {
      if (match >= 0) taken[match] = 1;
    }
    forbidden->assign(state_.tracks.size() * count, 1);
    const auto owners = LostOwners(view_idx);
    bool any = false;
    for (size_t t = 0; t < state_.tracks.size(); ++t) {
      if (state_.matches[view_idx][t] >= 0) continue;
      int views = 0;
      for (const std::vector<int>& matches : state_.matches) {
        views += matches[t] >= 0;
      }
      if (views < kSureViews) continue;
      for (size_t k = 0; k < count; ++k) {
        if (taken[k] || !owners[k].has_value() ||
            *owners[k] == state_.tracks[t]->id) {
          continue;
        }
        (*forbidden)[t * count + k] = 0;
        any = true;
      }
    }
    return any;
  }

  std::optional<size_t> FalseRecovery(const NewPerson& person) const override {
    const std::optional<size_t> track = TrackSeenAt(person);
    return track.has_value() && IsLost(*state_.tracks[*track]) ? track
                                                               : std::nullopt;
  }

  // Claims a tracklet for a track only in frames in which two or more of the
  // track's views agree, the tracklet's among them.
  void LearnUpdates() override {
    for (size_t t = 0; t < state_.tracks.size(); ++t) {
      const std::vector<size_t> views = AgreeingViews(state_.tracks[t]->frame);
      if (views.size() < 2) continue;
      for (const size_t v : views) {
        const int match = state_.matches[v][t];
        if (match < 0) continue;
        tracklets_[v].Claim(static_cast<size_t>(match), state_.tracks[t]->id);
      }
    }
  }

  // Where the views may agree by chance, a joint seen by a single view counts
  // as missing, and an update that lacks more than a third of the joints does
  // not count.
  bool Counts(const Track& track) const override {
    const EstimatorFrame& frame = track.frame;
    std::vector<size_t> views;
    std::vector<char> seen(frame.inlier_views.size(), 0);
    for (const FreshView& view : frame.views) {
      views.push_back(static_cast<size_t>(view.view_idx));
      for (size_t j = 0; j < seen.size(); ++j) {
        seen[j] |= view.verdicts[j] != FilterVerdict::kUnmeasured;
      }
    }
    const auto by_two =
        std::count_if(frame.inlier_views.begin(), frame.inlier_views.end(),
                      [](int count) { return count >= 2; });
    return 3 * by_two >= 2 * std::count(seen.begin(), seen.end(), 1) ||
           !AgreeByChance(views, static_cast<int>(by_two), frame.initial);
  }

  // False if fewer than two views have unmatched detections, or if even the two
  // of these views with the fewest may agree by chance: with so few joints a
  // third view adds no certainty. With two cameras chance agreement is
  // accepted, as AgreeByChance accepts that of all cameras facing a person.
  bool AwaitsSlight() const override {
    std::vector<int> unmatched;
    for (size_t v = 0; v < state_.scene.cameras.size(); ++v) {
      const int count = CountUnmatched(v, 0);
      if (count > 0) unmatched.push_back(count);
    }
    if (unmatched.size() < 2) return false;
    std::partial_sort(unmatched.begin(), unmatched.begin() + 2,
                      unmatched.end());
    return state_.scene.cameras.size() == 2 ||
           kPairAgrees * unmatched[0] * unmatched[1] <= kMostGroups;
  }

  // Candidates are linked from frame to frame by position. Chance agreements do
  // not persist at one position for long.
  void SeeSlight(std::vector<NewPerson>* people) override {
    // For example six joints seen by two views for a second.
    constexpr double kEnoughJointSeconds = 6.0;
    constexpr double kForgottenS = 0.4;
    constexpr double kOnePlaceM = 0.2;
    slight_.erase(std::remove_if(slight_.begin(), slight_.end(),
                                 [&](const Slight& one) {
                                   return ToSeconds(state_.time - one.time) >
                                          LongestPause(kForgottenS);
                                 }),
                  slight_.end());
    std::vector<NewPerson> enough;
    for (NewPerson& person : *people) {
      if (!AgreesWell(person)) continue;
      const Pose3d& pose = person.reconstruction.pose;
      auto at =
          std::find_if(slight_.begin(), slight_.end(), [&](const Slight& one) {
            return one.time < state_.time &&
                   SeenAtOnePlace(one.pose, pose, kOnePlaceM);
          });
      const double weight = JointsTwice(person);
      if (at == slight_.end()) {
        slight_.push_back({state_.time, pose, weight, 0.0});
        continue;
      }
      // Trapezoidal rule over the interval since the candidate was last seen.
      at->joint_seconds +=
          0.5 * (at->joints + weight) * ToSeconds(state_.time - at->time);
      at->time = state_.time;
      at->pose = pose;
      at->joints = weight;
      if (at->joint_seconds < kEnoughJointSeconds) continue;
      enough.push_back(std::move(person));
      slight_.erase(at);
    }
    *people = std::move(enough);
  }

  bool MayBegin(const NewPerson& person) const override {
    return !TrackSeenAt(person).has_value() && !IsOfTwoOwners(person) &&
           !IsByChance(person);
  }

  void LearnBeginning(const NewPerson& person, TrackId track) override {
    for (const Observation* member : person.members) {
      tracklets_[member->view_idx].Claim(IndexOf(*member), track);
    }
  }

 private:
  // Probability that detections of two different people in two views agree:
  // 0.05 on Shelf, 0.02 to 0.2 with thirty people and twelve cameras.
  static constexpr double kPairAgrees = 0.05;
  // Views may agree by chance if more than this number of groups of detections
  // of different people is expected to agree.
  static constexpr double kMostGroups = 1.0;

  // A candidate: a person with too few visible joints to start a track at once.
  struct Slight {
    TimeNs time = 0;      // last seen
    Pose3d pose;          // at that time
    double joints = 0.0;  // JointsTwice at that time
    double joint_seconds = 0.0;
  };

  // `seconds`, but at least one and a half intervals between frames on which
  // the detector ran, so that candidates and 2D tracklets in consecutive frames
  // of the detector are linked whatever its rate [s].
  double LongestPause(double seconds) const {
    return std::max(seconds, 1.5 * state_.rhythm.usual_frames() /
                                 state_.scene.frame_rate_hz);
  }

  // Number of joints: those seen by two views count once, by three twice, and
  // so on.
  double JointsTwice(const NewPerson& person) const {
    int count = 0;
    for (const int j : state_.scene.skeleton.association_joints()) {
      count += std::max(0, person.reconstruction.fresh_inlier_views[j] - 1);
    }
    return count;
  }

  // Whether the reprojection error of the joints is, on average, within the
  // inner half of the gate for conflicts between two views; each of the two
  // views has half of their distance.
  bool AgreesWell(const NewPerson& person) const {
    const double most_px = 0.25 * state_.alpha_new_px;
    double sum_px = 0.0;
    int count = 0;
    for (const Observation* member : person.members) {
      const Camera& camera = state_.scene.cameras[member->view_idx];
      for (const int joint : state_.scene.skeleton.association_joints()) {
        const auto j = static_cast<size_t>(joint);
        if (!person.reconstruction.triangulated[j] ||
            !member->joints[j].found) {
          continue;
        }
        const auto px =
            camera.Project(person.reconstruction.pose[j].position_m);
        if (!px.has_value()) return false;
        sum_px += (*px - member->joints[j].px).norm();
        ++count;
      }
    }
    return count > 0 && sum_px <= most_px * count;
  }

  // Whether the track's last update is more than 0.1 s ago, and at least one
  // frame on which the detector ran lies between it and the current frame.
  bool IsLost(const Track& track) const {
    constexpr double kLostS = 0.1;
    const TimeNs age = state_.time - track.life.last_update();
    return ToSeconds(age) > kLostS &&
           !state_.clock.Less(age, 1.0 + state_.rhythm.usual_frames());
  }

  // The owner of the observation's tracklet, if that track is lost or gone.
  // Tracks that are not lost are distinguished by their 3D poses, which carry
  // more information than one view.
  std::optional<TrackId> LostOwner(size_t view_idx,
                                   size_t observation_idx) const {
    const std::optional<TrackId> owner =
        tracklets_[view_idx].OwnerOf(observation_idx);
    if (!owner.has_value()) return std::nullopt;
    const bool is_followed = std::any_of(
        state_.tracks.begin(), state_.tracks.end(), [&](const auto& track) {
          return track->id == *owner && !IsLost(*track);
        });
    return is_followed ? std::nullopt : owner;
  }

  // LostOwner of each observation in the view.
  std::vector<std::optional<TrackId>> LostOwners(size_t view_idx) const {
    std::vector<std::optional<TrackId>> owners;
    for (size_t k = 0; k < state_.observations.OfView(view_idx).size(); ++k) {
      owners.push_back(LostOwner(view_idx, k));
    }
    return owners;
  }

  // The track that was triangulated in this frame at the person's position.
  std::optional<size_t> TrackSeenAt(const NewPerson& person) const {
    // Both poses are of this frame and differ by triangulation errors only.
    // With 0.3 m a track that had drifted onto another person kept that person
    // from starting a track.
    constexpr double kOnePersonM = 0.2;
    for (size_t t = 0; t < state_.tracks.size(); ++t) {
      const EstimatorFrame& seen = state_.tracks[t]->frame;
      if (seen.has_initial && SeenAtOnePlace(person.reconstruction.pose,
                                             seen.initial, kOnePersonM)) {
        return t;
      }
    }
    return std::nullopt;
  }

  bool IsOfTwoOwners(const NewPerson& person) const {
    std::optional<TrackId> owner;
    for (const Observation* member : person.members) {
      const std::optional<TrackId> one =
          LostOwner(static_cast<size_t>(member->view_idx), IndexOf(*member));
      if (!one.has_value()) continue;
      if (owner.has_value() && *owner != *one) return true;
      owner = one;
    }
    return false;
  }

  bool IsByChance(const NewPerson& person) const {
    std::vector<size_t> views;
    for (const Observation* member : person.members) {
      views.push_back(static_cast<size_t>(member->view_idx));
    }
    return AgreeByChance(
        views,
        CountTriangulated(person.reconstruction,
                          state_.scene.skeleton.association_joints()),
        person.reconstruction.pose);
  }

  // Whether these views may agree by chance on `joints` joints at `pose`, by
  // the expected number of such groups of detections. The second view must
  // agree in one coordinate, each further one in two. False if all cameras
  // facing `pose` agree.
  bool AgreeByChance(const std::vector<size_t>& views, int joints,
                     const Pose3d& pose) const {
    double groups = std::pow(kPairAgrees, -3);
    for (const size_t view_idx : views) {
      groups *= kPairAgrees * kPairAgrees * CountUnmatched(view_idx, joints);
    }
    return groups > kMostGroups && views.size() < CountFacing(pose);
  }

  // Number of unmatched detections with at least `joints` joints.
  int CountUnmatched(size_t view_idx, int joints) const {
    const Span<Observation> observations = state_.observations.OfView(view_idx);
    const auto counts = [&](const Observation& observation) {
      return observation.found_count >= joints;
    };
    auto count =
        std::count_if(observations.begin(), observations.end(), counts);
    for (const int match : state_.matches[view_idx]) {
      count -= match >= 0 && counts(observations[match]);
    }
    return static_cast<int>(count);
  }

  // Cameras whose image contains more than half of the joints. Where the image
  // size is unknown, the principal point is assumed to be its centre.
  size_t CountFacing(const Pose3d& pose) const {
    size_t facing = 0;
    for (const Camera& camera : state_.scene.cameras) {
      const Eigen::AlignedBox2d image(
          Eigen::Vector2d::Zero(),
          camera.width_px() > 0
              ? Eigen::Vector2d(camera.width_px(), camera.height_px())
              : Eigen::Vector2d(2.0 * camera.K().topRightCorner<2, 1>()));
      int inside = 0;
      for (const Joint3d& joint : pose) {
        if (!joint.present()) continue;
        const auto px = camera.Project(joint.position_m);
        inside += px.has_value() && image.contains(*px) ? 1 : 0;
      }
      facing += 2 * inside > CountPresent(pose) ? 1 : 0;
    }
    return facing;
  }

  // Index within its view and frame.
  size_t IndexOf(const Observation& observation) const {
    const auto view_idx = static_cast<size_t>(observation.view_idx);
    return static_cast<size_t>(&observation -
                               state_.observations.OfView(view_idx).data());
  }

  const AssociationState& state_;
  std::vector<ViewTracklets> tracklets_;  // [view]
  std::vector<Slight> slight_;
};

}  // namespace

bool SeenAtOnePlace(const Pose3d& a, const Pose3d& b, double within_m) {
  // Three joints determine position and orientation; a smaller skeleton needs
  // all of its joints.
  const int enough = std::min(3, static_cast<int>(a.size()));
  int seen = 0;
  int near = 0;
  for (size_t j = 0; j < a.size() && j < b.size(); ++j) {
    if (a[j].status != JointStatus::kObserved ||
        b[j].status != JointStatus::kObserved) {
      continue;
    }
    ++seen;
    near += (a[j].position_m - b[j].position_m).norm() < within_m;
  }
  return seen >= enough && 2 * near > seen;
}

std::unique_ptr<AssociationPolicy> MakeAssociationPolicy(
    AssociationRules rules, const AssociationState& state) {
  if (rules == AssociationRules::kGraph) {
    return std::make_unique<GraphAssociation>(state);
  }
  return std::make_unique<AssociationPolicy>();
}

}  // namespace kinegraph
