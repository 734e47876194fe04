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

namespace kinegraph {
namespace {

// Seconds of people below which a pair joins nothing.
constexpr double kLeastEvidenceS = 0.6;

// The pair seen from its other side.
PairFit Turned(const PairFit& pair) {
  PairFit turned = pair;
  std::swap(turned.a, turned.b);
  turned.lag = -pair.lag;
  turned.pose.R = pair.pose.R.transpose();
  turned.pose.t = -(turned.pose.R * pair.pose.t);
  for (TrackletMatch& match : turned.matches) std::swap(match.a, match.b);
  return turned;
}

// Depths in both views of what a match's tracklets have in common.
struct SeenDepth {
  int frame = 0;  // of view a
  Eigen::Index joint = 0;
  Eigen::Vector2d depths;
};

std::vector<SeenDepth> DepthsOfMatch(const std::vector<ViewTracklet>& tracklets,
                                     const PairFit& pair,
                                     const TrackletMatch& match) {
  const ViewTracklet& a = tracklets[static_cast<size_t>(match.a)];
  const ViewTracklet& b = tracklets[static_cast<size_t>(match.b)];
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

// Sum of the median lengths of the bones, in baselines of the pair; 0 where
// they are not seen.
double BodyOf(const std::vector<ViewTracklet>& tracklets, const PairFit& pair,
              const std::vector<Bone>& bones) {
  std::vector<std::vector<double>> lengths(bones.size());
  for (const TrackletMatch& match : pair.matches) {
    std::map<std::pair<int, Eigen::Index>, Eigen::Vector3d> points;
    const ViewTracklet& a = tracklets[static_cast<size_t>(match.a)];
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

// How much more than its own baseline a pair's edge is long in the rig.
class Joiner {
 public:
  Joiner(const CameraRig& intrinsics,
         const std::vector<ViewTracklet>& tracklets,
         const std::vector<PairFit>& pairs, const std::vector<Bone>& bones)
      : intrinsics_(intrinsics),
        tracklets_(tracklets),
        pairs_(pairs),
        bones_(bones) {}

  // Grows the tree that begins with `first`; `evidence` of what it joined.
  RigStart Grow(const PairFit& first, double* evidence) {
    const size_t views = intrinsics_.size();
    poses_.assign(views, {});
    start_.joined.assign(views, 0);
    start_.lag_frames.assign(views, 0);
    start_.joined[static_cast<size_t>(first.a)] = 1;
    body_ = 0.0;
    *evidence = 0.0;
    for (std::optional<PairFit> edge = first; edge.has_value();
         edge = NextEdge()) {
      Join(*edge);
      *evidence += edge->evidence;
    }
    for (size_t v = 0; v < views; ++v) {
      CameraParameters parameters = intrinsics_[v].parameters();
      parameters.R = poses_[v].R;
      parameters.t = poses_[v].t;
      start_.cameras.emplace_back(parameters);
    }
    return std::move(start_);
  }

 private:
  struct Pose {
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    Eigen::Vector3d t = Eigen::Vector3d::Zero();
  };

  bool Joined(int view) const {
    return start_.joined[static_cast<size_t>(view)] != 0;
  }

  // The pair of most evidence with one view joined, seen from that one.
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

  // The pose of view b in view a as the rig has it, with the pair's matches.
  PairFit InRig(const PairFit& pair, double* length) const {
    PairFit in_rig = pair;
    const Pose& a = poses_[static_cast<size_t>(pair.a)];
    const Pose& b = poses_[static_cast<size_t>(pair.b)];
    in_rig.pose.R = b.R * a.R.transpose();
    const Eigen::Vector3d t = b.t - in_rig.pose.R * a.t;
    *length = t.norm();
    in_rig.pose.t = t.normalized();
    in_rig.lag = start_.lag_frames[static_cast<size_t>(pair.b)] -
                 start_.lag_frames[static_cast<size_t>(pair.a)];
    return in_rig;
  }

  // Logarithms of the length of the edge: depths in view a by the rig over
  // those by the edge.
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
    if (body_ == 0.0) {
      body_ = BodyOf(tracklets_, edge, bones_);
      return 1.0;
    }
    const std::vector<double> lengths = LengthsByDepth(edge);
    constexpr size_t kLeast = 40;
    if (lengths.size() >= kLeast) return std::exp(Median(lengths));
    // Nobody is seen by three: people are about equally large.
    const double body = BodyOf(tracklets_, edge, bones_);
    return body > 0.0 ? body_ / body : 1.0;
  }

  void Join(const PairFit& edge) {
    const double length = LengthOf(edge);
    const auto a = static_cast<size_t>(edge.a);
    const auto b = static_cast<size_t>(edge.b);
    poses_[b].R = edge.pose.R * poses_[a].R;
    poses_[b].t = edge.pose.R * poses_[a].t + length * edge.pose.t;
    start_.lag_frames[b] = start_.lag_frames[a] + edge.lag;
    start_.joined[b] = 1;
  }

  const CameraRig& intrinsics_;
  const std::vector<ViewTracklet>& tracklets_;
  const std::vector<PairFit>& pairs_;
  const std::vector<Bone>& bones_;
  RigStart start_;
  std::vector<Pose> poses_;
  double body_ = 0.0;  // BodyOf, in the rig's lengths
};

// Sets of tracklets, none of which has two of one view at once.
class PeopleSets {
 public:
  explicit PeopleSets(const std::vector<ViewTracklet>& tracklets)
      : tracklets_(tracklets), set_of_(tracklets.size()) {
    std::iota(set_of_.begin(), set_of_.end(), 0);
  }

  void Join(int a, int b) {
    const int one = set_of_[static_cast<size_t>(a)];
    const int other = set_of_[static_cast<size_t>(b)];
    if (one == other || Clash(one, other)) return;
    std::replace(set_of_.begin(), set_of_.end(), other, one);
  }

  const std::vector<int>& set_of() const { return set_of_; }

 private:
  bool Clash(int one, int other) const {
    for (size_t x = 0; x < set_of_.size(); ++x) {
      if (set_of_[x] != one) continue;
      for (size_t y = 0; y < set_of_.size(); ++y) {
        if (set_of_[y] != other) continue;
        const ViewTracklet& a = tracklets_[x];
        const ViewTracklet& b = tracklets_[y];
        if (a.view == b.view && a.first < b.end() && b.first < a.end()) {
          return true;
        }
      }
    }
    return false;
  }

  const std::vector<ViewTracklet>& tracklets_;
  std::vector<int> set_of_;
};

// Tracklets that pairs of views take for one person, the worthiest pair first.
PeopleSets SetsOf(const std::vector<ViewTracklet>& tracklets,
                  const std::vector<PairFit>& pairs, const RigStart& start) {
  struct Edge {
    double worth;
    TrackletMatch match;
  };
  std::vector<Edge> edges;
  for (const PairFit& pair : pairs) {
    const auto a = static_cast<size_t>(pair.a);
    const auto b = static_cast<size_t>(pair.b);
    if (!start.joined[a] || !start.joined[b]) continue;
    // A pair of another clock says nothing of who is who.
    if (std::abs(start.lag_frames[b] - start.lag_frames[a] - pair.lag) > 2) {
      continue;
    }
    for (const TrackletMatch& match : pair.matches) {
      const auto& one = tracklets[static_cast<size_t>(match.a)];
      edges.push_back(
          {match.gain * static_cast<double>(one.detections.size()), match});
    }
  }
  std::stable_sort(
      edges.begin(), edges.end(),
      [](const Edge& x, const Edge& y) { return x.worth > y.worth; });
  PeopleSets sets(tracklets);
  for (const Edge& edge : edges) sets.Join(edge.match.a, edge.match.b);
  return sets;
}

}  // namespace

int RigStart::joined_count() const {
  return static_cast<int>(std::count(joined.begin(), joined.end(), 1));
}

RigStart JoinPairs(const CameraRig& intrinsics,
                   const std::vector<ViewTracklet>& tracklets,
                   const std::vector<PairFit>& pairs,
                   const std::vector<Bone>& bones) {
  RigStart best;
  double most = 0.0;
  int most_joined = 0;
  // Trees that begin elsewhere join the same views: one of each component.
  for (const PairFit& pair : pairs) {
    if (pair.evidence < kLeastEvidenceS) continue;
    const bool is_best_of_its_views =
        std::none_of(pairs.begin(), pairs.end(), [&](const PairFit& other) {
          const bool meets = other.a == pair.a || other.a == pair.b ||
                             other.b == pair.a || other.b == pair.b;
          return meets && other.lead() > pair.lead();
        });
    if (!is_best_of_its_views) continue;
    double evidence = 0.0;
    RigStart one =
        Joiner(intrinsics, tracklets, pairs, bones).Grow(pair, &evidence);
    const int joined = one.joined_count();
    if (joined < most_joined || (joined == most_joined && evidence <= most)) {
      continue;
    }
    most = evidence;
    most_joined = joined;
    best = std::move(one);
  }
  return best;
}

FrozenMatches PeopleOf(const DetectionSequence& detections,
                       const std::vector<ViewTracklet>& tracklets,
                       const std::vector<PairFit>& pairs,
                       const RigStart& start) {
  PeopleSets sets = SetsOf(tracklets, pairs, start);
  FrozenMatches matches;
  std::map<int, std::map<int, FrozenFrame>> people;  // set, moment
  const auto count = static_cast<int>(detections.frames.size());
  for (size_t i = 0; i < tracklets.size(); ++i) {
    const ViewTracklet& tracklet = tracklets[i];
    const auto v = static_cast<size_t>(tracklet.view);
    if (!start.joined[v]) continue;
    for (int frame = tracklet.first; frame < tracklet.end(); ++frame) {
      const int moment = frame - start.lag_frames[v];
      if (!tracklet.SeenAt(frame) || moment < 0 || moment >= count) continue;
      const DetectionFrame& at = detections.frames[static_cast<size_t>(moment)];
      FrozenFrame& frozen = people[sets.set_of()[i]][moment];
      frozen.frame = at.frame;
      frozen.time = at.time;
      frozen.written = true;
      const int d =
          tracklet.detections[static_cast<size_t>(frame - tracklet.first)];
      frozen.detections.push_back(
          {tracklet.view, detections.frames[static_cast<size_t>(frame)]
                              .views[v]
                              .detections[static_cast<size_t>(d)]
                              .index_in_file});
    }
  }
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
