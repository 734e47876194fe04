#include "solvers/rig/rig_start.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "core/base/median.h"
#include "core/skeleton/skeleton.h"
#include "solvers/cameras/camera_change.h"
#include "solvers/scene/clock_search.h"
#include "solvers/scene/view_agreement.h"

namespace kinegraph {
namespace {

// Minimum evidence [s] of a pair that joins a view.
constexpr double kLeastEvidenceS = 0.6;

// The pair with its views exchanged.
PairFit Turned(const PairFit& pair) {
  PairFit turned = pair;
  std::swap(turned.a, turned.b);
  turned.lag = -pair.lag;
  turned.pose.R = pair.pose.R.transpose();
  turned.pose.t = -(turned.pose.R * pair.pose.t);
  for (TrackletMatch& match : turned.matches) std::swap(match.a, match.b);
  return turned;
}

// Depths of a common joint of a match in both views.
struct SeenDepth {
  int frame = 0;  // in view a
  Eigen::Index joint = 0;
  Eigen::Vector2d depths;
};

std::vector<SeenDepth> DepthsOfMatch(const std::vector<ViewTracklet>& tracklets,
                                     const PairFit& pair,
                                     const TrackletMatch& match) {
  const ViewTracklet& a = tracklets[match.a];
  const ViewTracklet& b = tracklets[match.b];
  const int begin = std::max(a.first, b.first - pair.lag);
  const int end = std::min(a.end(), b.end() - pair.lag);
  constexpr int kMostFrames = 100;
  const int step = std::max(1, (end - begin) / kMostFrames);
  std::vector<SeenDepth> seen;
  for (int k = begin; k < end; k += step) {
    if (!a.SeenAt(k) || !b.SeenAt(k + pair.lag)) continue;
    const NormalisedJoints& points_a = a.At(k);
    const NormalisedJoints& points_b = b.At(k + pair.lag);
    for (Eigen::Index j = 0; j < points_a.cols(); ++j) {
      if (!points_a.col(j).allFinite() || !points_b.col(j).allFinite()) {
        continue;
      }
      const auto depths =
          DepthsOf(pair.pose, {points_a.col(j), points_b.col(j), 1.0});
      if (depths.has_value() && depths->minCoeff() > 0.0) {
        seen.push_back({k, j, *depths});
      }
    }
  }
  return seen;
}

// Sum of the median bone lengths, in units of the pair's baseline; 0 if no bone
// was seen.
double BodyOf(const std::vector<ViewTracklet>& tracklets, const PairFit& pair,
              const std::vector<Bone>& bones) {
  std::vector<std::vector<double>> lengths(bones.size());
  for (const TrackletMatch& match : pair.matches) {
    std::map<std::pair<int, Eigen::Index>, Eigen::Vector3d> points;
    const ViewTracklet& a = tracklets[match.a];
    for (const SeenDepth& one : DepthsOfMatch(tracklets, pair, match)) {
      points[{one.frame, one.joint}] =
          one.depths[0] *
          (a.At(one.frame).col(one.joint) / pair.pose.magnification)
              .homogeneous();
    }
    for (const auto& [key, point] : points) {
      for (size_t i = 0; i < bones.size(); ++i) {
        if (bones[i].a != key.second) continue;
        const auto other = points.find({key.first, bones[i].b});
        if (other == points.end()) continue;
        lengths[i].push_back((point - other->second).norm());
      }
    }
  }
  double sum = 0.0;
  for (const auto& of_bone : lengths) sum += Median(of_bone);
  return sum;
}

// A tree of pairs, each of which joins one view to the rig.
class Joiner {
 public:
  Joiner(const CameraRig& intrinsics,
         const std::vector<ViewTracklet>& tracklets,
         const std::vector<PairFit>& pairs, const std::vector<Bone>& bones)
      : intrinsics_(intrinsics),
        tracklets_(tracklets),
        pairs_(pairs),
        bones_(bones),
        joined_(intrinsics.size(), 0),
        lags_(intrinsics.size(), 0),
        poses_(intrinsics.size()) {}

  // Grows the tree from a first pair.
  void Grow(const PairFit& first) {
    joined_[first.a] = 1;
    for (std::optional<PairFit> edge = first; edge.has_value();
         edge = NextEdge()) {
      Join(*edge);
      evidence_ += edge->evidence;
    }
  }

  // Sum of the evidence of the tree's pairs [s].
  double evidence() const { return evidence_; }

  RigStart Start() const {
    RigStart start;
    for (size_t v = 0; v < joined_.size(); ++v) {
      if (joined_[v] == 0) continue;
      start.views.push_back(static_cast<int>(v));
      start.cameras.push_back(
          Edited(intrinsics_[v], [&](CameraParameters* camera) {
            camera->R = poses_[v].R;
            camera->t = poses_[v].t;
          }));
      start.lag_frames.push_back(lags_[v]);
    }
    return start;
  }

 private:
  struct Pose {
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    Eigen::Vector3d t = Eigen::Vector3d::Zero();
  };

  bool Joined(int view) const { return joined_[view] != 0; }

  // The best pair (PairFit::lead) among those with enough evidence and exactly
  // one joined view, with this view first.
  std::optional<PairFit> NextEdge() const {
    const PairFit* best = nullptr;
    for (const PairFit& pair : pairs_) {
      if (Joined(pair.a) == Joined(pair.b)) continue;
      if (pair.evidence < kLeastEvidenceS) continue;
      if (best == nullptr || pair.lead() > best->lead()) best = &pair;
    }
    if (best == nullptr) return std::nullopt;
    return Joined(best->a) ? *best : Turned(*best);
  }

  // Relative pose and lag of the pair's views in the rig, with the pair's
  // matches. `length`: of the baseline, in the rig's unit.
  PairFit InRig(const PairFit& pair, double* length) const {
    PairFit in_rig = pair;
    const Pose& a = poses_[pair.a];
    const Pose& b = poses_[pair.b];
    in_rig.pose.R = b.R * a.R.transpose();
    const Eigen::Vector3d t = b.t - in_rig.pose.R * a.t;
    *length = t.norm();
    in_rig.pose.t = t.normalized();
    in_rig.lag = lags_[pair.b] - lags_[pair.a];
    return in_rig;
  }

  // Logarithms of the length of the edge's baseline in the rig, one per joint,
  // frame and known pair: the depth in view a according to the rig divided by
  // the depth according to the edge.
  std::vector<double> LengthsByDepth(const PairFit& edge) const {
    std::vector<double> lengths;
    for (const TrackletMatch& match : edge.matches) {
      std::map<std::pair<int, Eigen::Index>, double> depth;
      for (const SeenDepth& one : DepthsOfMatch(tracklets_, edge, match)) {
        depth[{one.frame, one.joint}] = one.depths[0];
      }
      for (const PairFit& known : pairs_) {
        if (!Joined(known.a) || !Joined(known.b)) continue;
        if (known.a != edge.a && known.b != edge.a) continue;
        double length = 0.0;
        const PairFit from_a =
            InRig(known.a == edge.a ? known : Turned(known), &length);
        for (const TrackletMatch& other : from_a.matches) {
          if (other.a != match.a) continue;
          for (const SeenDepth& one :
               DepthsOfMatch(tracklets_, from_a, other)) {
            const auto at = depth.find({one.frame, one.joint});
            if (at == depth.end()) continue;
            lengths.push_back(std::log(length * one.depths[0] / at->second));
          }
        }
      }
    }
    return lengths;
  }

  double LengthOf(const PairFit& edge) {
    if (std::count(joined_.begin(), joined_.end(), 1) == 1) {
      body_ = BodyOf(tracklets_, edge, bones_);
      return 1.0;  // the first edge is the rig's unit of length
    }
    const std::vector<double> lengths = LengthsByDepth(edge);
    constexpr size_t kLeast = 40;
    if (lengths.size() >= kLeast) return std::exp(Median(lengths));
    // Too few joints are seen by three views: the bodies are assumed to be as
    // large as those of the first pair.
    const double body = BodyOf(tracklets_, edge, bones_);
    return body > 0.0 && body_ > 0.0 ? body_ / body : 1.0;
  }

  void Join(const PairFit& edge) {
    const double length = LengthOf(edge);
    const auto a = static_cast<size_t>(edge.a);
    const auto b = static_cast<size_t>(edge.b);
    poses_[b].R = edge.pose.R * poses_[a].R;
    poses_[b].t = edge.pose.R * poses_[a].t + length * edge.pose.t;
    lags_[b] = lags_[a] + edge.lag;
    joined_[b] = 1;
  }

  const CameraRig& intrinsics_;
  const std::vector<ViewTracklet>& tracklets_;
  const std::vector<PairFit>& pairs_;
  const std::vector<Bone>& bones_;
  // Indexed by view.
  std::vector<char> joined_;
  std::vector<int> lags_;
  std::vector<Pose> poses_;
  double body_ = 0.0;  // BodyOf in the rig's unit of length; 0: unknown
  double evidence_ = 0.0;
};

// A set index for each tracklet; a set is one person. Tracklets that pairs of
// views match are merged, the best matches first, with at most one tracklet per
// view at any time. `place`: position of each view among the joined views, or
// -1.
std::vector<int> SetsOf(const RigStart& start, const std::vector<int>& place) {
  struct Edge {
    double worth;
    TrackletMatch match;
  };
  const std::vector<ViewTracklet>& tracklets = start.tracklets;
  std::vector<Edge> edges;
  for (const PairFit& pair : start.pairs) {
    const int a = place[pair.a];
    const int b = place[pair.b];
    // The matches of a pair whose lag differs from the rig's by more than two
    // frames are not valid.
    if (a < 0 || b < 0 ||
        std::abs(start.lag_frames[b] - start.lag_frames[a] - pair.lag) > 2) {
      continue;
    }
    for (const TrackletMatch& match : pair.matches) {
      const auto& one = tracklets[match.a];
      edges.push_back(
          {match.gain * static_cast<double>(one.detections.size()), match});
    }
  }
  std::stable_sort(
      edges.begin(), edges.end(),
      [](const Edge& x, const Edge& y) { return x.worth > y.worth; });
  std::vector<int> set_of(tracklets.size());
  std::iota(set_of.begin(), set_of.end(), 0);
  const auto clash = [&](int one, int other) {
    for (size_t x = 0; x < set_of.size(); ++x) {
      for (size_t y = 0; set_of[x] == one && y < set_of.size(); ++y) {
        if (set_of[y] == other && tracklets[x].view == tracklets[y].view &&
            Overlap(tracklets[x], tracklets[y])) {
          return true;
        }
      }
    }
    return false;
  };
  for (const Edge& edge : edges) {
    const int one = set_of[edge.match.a];
    const int other = set_of[edge.match.b];
    if (one == other || clash(one, other)) continue;
    std::replace(set_of.begin(), set_of.end(), other, one);
  }
  return set_of;
}

// The bones between the given joints, as positions in `joints`.
std::vector<Bone> BonesOf(const Skeleton& skeleton,
                          const std::vector<int>& joints) {
  const auto place = [&](int joint) {
    const auto at = std::find(joints.begin(), joints.end(), joint);
    return at == joints.end() ? -1 : static_cast<int>(at - joints.begin());
  };
  std::vector<Bone> bones;
  for (const Bone& bone : skeleton.bones()) {
    const Bone placed = {place(bone.a), place(bone.b)};
    if (placed.a >= 0 && placed.b >= 0) bones.push_back(placed);
  }
  return bones;
}

// The tree with the most views and, among those, the most evidence. All trees
// of one connected component join the same views, so a tree is grown only from
// each pair that is the best pair of both its views.
RigStart JoinPairs(const CameraRig& intrinsics,
                   const std::vector<ViewTracklet>& tracklets,
                   const std::vector<PairFit>& pairs,
                   const std::vector<Bone>& bones) {
  RigStart best;
  double most = 0.0;
  for (const PairFit& pair : pairs) {
    if (pair.evidence < kLeastEvidenceS) continue;
    const bool is_best_of_its_views =
        std::none_of(pairs.begin(), pairs.end(), [&](const PairFit& other) {
          const bool meets = other.a == pair.a || other.a == pair.b ||
                             other.b == pair.a || other.b == pair.b;
          return meets && other.evidence >= kLeastEvidenceS &&
                 other.lead() > pair.lead();
        });
    if (!is_best_of_its_views) continue;
    Joiner joiner(intrinsics, tracklets, pairs, bones);
    joiner.Grow(pair);
    RigStart one = joiner.Start();
    if (one.views.size() < best.views.size() ||
        (one.views.size() == best.views.size() && joiner.evidence() <= most)) {
      continue;
    }
    most = joiner.evidence();
    best = std::move(one);
  }
  return best;
}

std::vector<PairFit> SearchPairs(const DetectionSequence& recording,
                                 const CameraRig& intrinsics,
                                 const std::vector<int>& joints,
                                 const RigSearch& search,
                                 const std::vector<ViewTracklet>& tracklets) {
  const auto views = static_cast<int>(intrinsics.size());
  PairSearchOptions options;
  options.frame_rate_hz = recording.header.frame_rate_hz;
  options.focal_sigma = search.focal_sigma;
  options.attempt = search.attempt;
  options.longest_lag_s = std::min(
      search.longest_lag_s, 0.4 * static_cast<double>(recording.frames.size()) /
                                options.frame_rate_hz);
  const MotionSignals signals(tracklets, joints, recording.header.skeleton,
                              views, options.frame_rate_hz);
  std::vector<PairFit> pairs;
  for (int a = 0; a < views; ++a) {
    for (int b = a + 1; b < views; ++b) {
      pairs.push_back(SearchViewPair(tracklets, signals, a, b, options));
      if (search.progress) {
        search.progress(static_cast<int>(pairs.size()),
                        views * (views - 1) / 2);
      }
    }
  }
  return pairs;
}

}  // namespace

DetectionSequence OfViews(const DetectionSequence& detections,
                          const std::vector<int>& views) {
  DetectionSequence part;
  part.header = detections.header;
  part.header.view_names.clear();
  for (const int v : views) {
    part.header.view_names.push_back(detections.header.view_names[v]);
  }
  for (const DetectionFrame& frame : detections.frames) {
    DetectionFrame kept;
    kept.frame = frame.frame;
    kept.time = frame.time;
    for (const int v : views) {
      kept.views.push_back(frame.views[v]);
    }
    part.frames.push_back(std::move(kept));
  }
  return part;
}

std::vector<double> AgreementsOfViews(const CameraRig& cameras,
                                      const DetectionSequence& aligned) {
  constexpr int kFrames = 80;
  const std::vector<ViewPeople> people = IdealPeople(aligned, cameras);
  const std::vector<int> frames = FramesToLookAt(people, kFrames);
  std::vector<PairAgreement> of_view(cameras.size());
  for (size_t a = 0; a < cameras.size(); ++a) {
    for (size_t b = a + 1; b < cameras.size(); ++b) {
      const PairAgreement pair =
          AgreementOf(cameras[a], people[a], cameras[b], people[b], frames);
      of_view[a].Add(pair);
      of_view[b].Add(pair);
    }
  }
  std::vector<double> scores;
  scores.reserve(of_view.size());
  for (const PairAgreement& one : of_view) scores.push_back(one.score());
  return scores;
}

RigStart FindRigStart(const DetectionSequence& recording,
                      const CameraRig& intrinsics, const RigSearch& search) {
  const double focal_sigma = search.focal_sigma;
  const Skeleton& skeleton = recording.header.skeleton;
  const std::vector<int> joints = RigJoints(skeleton);
  const std::vector<Bone> bones = BonesOf(skeleton, joints);
  RigStart best;
  best.tracklets = FollowInViews(intrinsics, recording, joints);
  const std::vector<PairFit> pairs =
      SearchPairs(recording, intrinsics, joints, search, best.tracklets);
  best.pairs = pairs;
  double most = -1.0;
  const auto guess = [&](double magnification) {
    const CameraRig guessed = Edited(intrinsics, [&](CameraParameters* camera) {
      camera->K.topLeftCorner<2, 2>() *= magnification;
    });
    std::vector<ViewTracklet> tracklets =
        FollowInViews(guessed, recording, joints);
    std::vector<PairFit> refitted = pairs;
    for (PairFit& pair : refitted) {
      if (focal_sigma > 0.0) RefitPose(tracklets, &pair);
    }
    RigStart one = JoinPairs(guessed, tracklets, refitted, bones);
    if (one.views.size() < 2) return;
    const std::vector<double> agreements = AgreementsOfViews(
        one.cameras, Realigned(OfViews(recording, one.views), one.lag_frames));
    const double score =
        std::accumulate(agreements.begin(), agreements.end(), 0.0);
    if (score <= most) return;
    most = score;
    best = std::move(one);
    best.tracklets = std::move(tracklets);
    best.pairs = std::move(refitted);
  };
  guess(1.0);
  constexpr int kSteps = 3;  // on either side of the guess, up to two sigmas
  for (int step = -kSteps; focal_sigma > 0.0 && step <= kSteps; ++step) {
    if (step != 0) guess(std::exp(2.0 * step / kSteps * focal_sigma));
  }
  return best;
}

FrozenMatches PeopleOf(const DetectionSequence& recording,
                       const RigStart& start) {
  std::vector<int> place(recording.header.view_names.size(), -1);
  for (size_t i = 0; i < start.views.size(); ++i) {
    place[start.views[i]] = static_cast<int>(i);
  }
  const std::vector<int> set_of = SetsOf(start, place);
  std::map<int, std::map<int, FrozenFrame>> people;  // by set and frame
  const auto count = static_cast<int>(recording.frames.size());
  for (size_t i = 0; i < start.tracklets.size(); ++i) {
    const ViewTracklet& tracklet = start.tracklets[i];
    const auto v = static_cast<size_t>(tracklet.view);
    if (place[v] < 0) continue;
    const int lag = start.lag_frames[place[v]];
    for (int frame = tracklet.first; frame < tracklet.end(); ++frame) {
      const int moment = frame - lag;
      if (!tracklet.SeenAt(frame) || moment < 0 || moment >= count) continue;
      const DetectionFrame& at = recording.frames[moment];
      FrozenFrame& frozen = people[set_of[i]][moment];
      frozen.frame = at.frame;
      frozen.time = at.time;
      frozen.written = true;
      const int d = tracklet.detections[frame - tracklet.first];
      frozen.detections.push_back(
          {place[v],
           recording.frames[frame].views[v].detections[d].index_in_file});
    }
  }
  FrozenMatches matches;
  int64_t id = 0;
  for (auto& [set, frames] : people) {
    FrozenPerson person;
    person.id = TrackId{id++};
    std::set<int> views;
    for (auto& [moment, frame] : frames) {
      for (const FrozenDetection& one : frame.detections) {
        views.insert(one.view_idx);
      }
      person.frames.push_back(frame);
    }
    if (views.size() > 1) matches.people.push_back(std::move(person));
  }
  return matches;
}

}  // namespace kinegraph
