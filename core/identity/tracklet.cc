#include "core/identity/tracklet.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "core/base/median.h"
#include "core/skeleton/body_joints.h"

namespace kinegraph {
namespace {

std::optional<Eigen::Vector3d> Centre(const Pose3d& pose,
                                      const std::vector<int>& trunk) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const int j : trunk) {
    if (!pose[j].present() || !pose[j].position_m.allFinite()) continue;
    sum += pose[j].position_m;
    ++count;
  }
  if (count == 0) return MeanPosition(pose);
  return Eigen::Vector3d(sum / count);
}

Eigen::Vector3d Across(const Pose3d& pose, const Skeleton& skeleton,
                       const std::vector<int>& trunk) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const int left : trunk) {
    const int right = skeleton.mirror(left);
    if (skeleton.joints()[left][0] != 'l' || right == left ||
        !pose[left].present() || !pose[right].present()) {
      continue;
    }
    sum += pose[left].position_m - pose[right].position_m;
    ++count;
  }
  return count == 0 || !sum.allFinite() ? Eigen::Vector3d::Zero().eval()
                                        : Eigen::Vector3d(sum / count);
}

// The index of the last frame not later than `time`; -1 before the first.
long IndexAt(const Tracklet& track, TimeNs time) {
  const auto later = std::upper_bound(
      track.frames.begin(), track.frames.end(), time,
      [](TimeNs t, const TrackletFrame& frame) { return t < frame.time; });
  return static_cast<long>(later - track.frames.begin()) - 1;
}

// Length of the part at an end of a tracklet from which its state is estimated.
constexpr double kStateSeconds = 0.3;

MotionState FitState(const Tracklet& tracklet, size_t begin, size_t end,
                     TimeNs at) {
  double mean_s = 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  const auto count = static_cast<double>(end - begin);
  for (size_t k = begin; k < end; ++k) {
    mean_s += ToSeconds(tracklet.frames[k].time - at) / count;
    mean += tracklet.frames[k].centre_m / count;
  }
  double spread = 0.0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  Eigen::Vector3d across = Eigen::Vector3d::Zero();
  for (size_t k = begin; k < end; ++k) {
    const double time_s = ToSeconds(tracklet.frames[k].time - at) - mean_s;
    spread += time_s * time_s;
    moment += time_s * (tracklet.frames[k].centre_m - mean);
    across += tracklet.frames[k].across_m / count;
  }
  // Shrinks the velocity towards zero where the frames span too little time: by
  // the factor 1 + (kStateSigmaM / (kUsualSpeed T))^2 for a span T, because
  // `spread` is about count T^2 / 12.
  constexpr double kUsualSpeed = 0.9;  // m/s
  const double rest =
      count * kStateSigmaM * kStateSigmaM / (12.0 * kUsualSpeed * kUsualSpeed);
  MotionState state;
  state.time = at;
  state.velocity_mps = moment / (spread + rest);
  state.position_m = mean - mean_s * state.velocity_mps;
  state.across_m = across;
  return state;
}

// The state at the last of the frames begin .. end - 1.
MotionState StateBefore(const Tracklet& tracklet, size_t begin, size_t end) {
  const TimeNs at = tracklet.frames[end - 1].time;
  size_t from = end - 1;
  while (from > begin &&
         ToSeconds(at - tracklet.frames[from - 1].time) <= kStateSeconds) {
    --from;
  }
  MotionState state = FitState(tracklet, from, end, at);
  state.posture = PostureOf(tracklet, end - 1);
  return state;
}

}  // namespace

LimbPosture PostureOf(const Tracklet& tracklet, size_t frame_idx) {
  const TrackletFrame& frame = tracklet.frames[frame_idx];
  LimbPosture posture;
  posture.across_m = frame.across_m;
  for (const int j : tracklet.body_joints) {
    const Joint3d& joint = frame.pose->joints[j];
    posture.limbs_m.push_back(
        joint.present() ? Eigen::Vector3d(joint.position_m - frame.centre_m)
                        : Eigen::Vector3d::Constant(
                              std::numeric_limits<double>::quiet_NaN()));
  }
  return posture;
}

MotionState StateAtBegin(const Tracklet& tracklet) {
  const size_t begin = tracklet.clean_begin();
  const TimeNs at = tracklet.frames[begin].time;
  size_t end = begin + 1;
  while (end < tracklet.clean_end() &&
         ToSeconds(tracklet.frames[end].time - at) <= kStateSeconds) {
    ++end;
  }
  MotionState state = FitState(tracklet, begin, end, at);
  state.posture = PostureOf(tracklet, begin);
  return state;
}

MotionState StateAtEnd(const Tracklet& tracklet) {
  return StateBefore(tracklet, tracklet.clean_begin(), tracklet.clean_end());
}

MotionState StateUpTo(const Tracklet& tracklet, TimeNs time) {
  return StateBefore(tracklet, 0, std::max(0L, IndexAt(tracklet, time)) + 1);
}

std::vector<Tracklet> CollectTracklets(const std::vector<TrackFrame>& frames,
                                       const Skeleton& skeleton) {
  std::vector<int> trunk;
  std::vector<int> body_joints;
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    const JointClass joint_class = skeleton.joint_class(j);
    if (IsBodyJoint(joint_class)) body_joints.push_back(j);
    if (joint_class == JointClass::kHip ||
        joint_class == JointClass::kShoulder) {
      trunk.push_back(j);
    }
  }
  std::map<TrackId, Tracklet> people;
  for (const TrackFrame& frame : frames) {
    for (const PersonPose& person : frame.people) {
      const std::optional<Eigen::Vector3d> centre =
          Centre(person.joints, trunk);
      if (!centre.has_value()) continue;
      people[person.id].frames.push_back(
          {frame.frame, frame.time, &person, *centre,
           Across(person.joints, skeleton, trunk)});
    }
  }
  std::vector<Tracklet> tracklets;
  for (auto& [id, tracklet] : people) {
    tracklet.id = id;
    tracklet.body_joints = body_joints;
    tracklets.push_back(std::move(tracklet));
  }
  return tracklets;
}

namespace {

// People pass each other with about half a metre between their centres. A track
// may continue with the wrong person where another track begins or ends within
// a metre of it.
constexpr double kNear = 1.0;          // m
constexpr double kTouching = 0.4;      // m; nearer: a contact
constexpr double kMayExchange = 1.5;   // m; nearer: a contact if SeemExchanged
constexpr double kExchangeTime = 0.4;  // s, within which an exchange shows
// The beginning or end of another track is a contact from kBefore before it,
// because a track is unreliable before it is lost, to kAfter after it.
constexpr double kBefore = 0.4;      // s
constexpr double kAfter = 0.2;       // s
constexpr double kLeast = 1.0;       // s of clean frames required in a piece
constexpr double kLeastAtHop = 0.4;  // s, the same beside a hop (kHop)
constexpr double kMerge = kLeast;    // closer contacts are merged
// A track that no view sees for this long may be recovered on another person.
constexpr double kBlind = 0.12;       // s
constexpr double kAroundBlind = 0.1;  // s, affected by the missing views
// A track recovered at least this far from its prediction, about three times
// the error of a position, was recovered on another person, or the person
// turned meanwhile.
constexpr double kHop = 0.25;  // m

struct Interval {
  TimeNs begin = 0;
  TimeNs end = 0;
  bool blind = false;  // only because no view sees the track
  std::vector<Pieces::Hop> hops;
};

// The people present in each frame, by the indices of track and frame.
struct Crowd {
  explicit Crowd(const std::vector<Tracklet>& tracks) {
    for (size_t t = 0; t < tracks.size(); ++t) {
      for (size_t k = 0; k < tracks[t].frames.size(); ++k) {
        present[tracks[t].frames[k].frame].push_back({t, k});
      }
      begin = std::min(begin, tracks[t].first().time);
      end = std::max(end, tracks[t].last().time);
    }
  }

  struct Place {
    size_t track;
    size_t index;
  };
  std::map<int64_t, std::vector<Place>> present;
  TimeNs begin = INT64_MAX;  // of the recording
  TimeNs end = INT64_MIN;
};

// Whether the two seem to have exchanged places within kExchangeTime after
// these frames: the sum of their squared distances from each other's prediction
// is less than that from their own.
bool SeemExchanged(const Tracklet& a, size_t ka, const Tracklet& b, size_t kb) {
  const TimeNs now = a.frames[ka].time;
  const TimeNs earlier = now - FromSeconds(0.5 * kExchangeTime);
  const TimeNs later = now + FromSeconds(kExchangeTime);
  const auto expected = [&](const Tracklet& track, size_t k,
                            Eigen::Vector3d* to, Eigen::Vector3d* is) {
    const long before = IndexAt(track, earlier);
    const long after = IndexAt(track, later);
    if (before < 0 || static_cast<size_t>(after) == k) return false;
    const TrackletFrame& from = track.frames[before];
    const TrackletFrame& there = track.frames[after];
    const TrackletFrame& here = track.frames[k];
    if (here.time - from.time > FromSeconds(kExchangeTime) ||
        later - there.time > FromSeconds(0.5 * kExchangeTime) ||
        here.time == from.time) {
      return false;
    }
    const Eigen::Vector3d velocity =
        (here.centre_m - from.centre_m) / ToSeconds(here.time - from.time);
    *to = here.centre_m + velocity * ToSeconds(there.time - here.time);
    *is = there.centre_m;
    return true;
  };
  Eigen::Vector3d a_to, a_is, b_to, b_is;
  if (!expected(a, ka, &a_to, &a_is) || !expected(b, kb, &b_to, &b_is)) {
    return false;
  }
  return (a_is - b_to).squaredNorm() + (b_is - a_to).squaredNorm() <
         (a_is - a_to).squaredNorm() + (b_is - b_to).squaredNorm();
}

using Intervals = std::vector<std::vector<Interval>>;  // [track]

// Adds contacts of others with a track that begins or ends at `at`.
void AddEnd(const Crowd& crowd, const std::vector<Tracklet>& tracks, size_t of,
            const TrackletFrame& at, Intervals* intervals) {
  for (const Crowd::Place& place : crowd.present.at(at.frame)) {
    const Tracklet& other = tracks[place.track];
    if (place.track == of) continue;
    if ((other.frames[place.index].centre_m - at.centre_m).norm() >= kNear) {
      continue;
    }
    (*intervals)[place.track].push_back({at.time - FromSeconds(kBefore),
                                         at.time + FromSeconds(kAfter),
                                         /*blind=*/false,
                                         {}});
  }
}

void AddEnds(const Crowd& crowd, const std::vector<Tracklet>& tracks,
             Intervals* intervals) {
  const TimeNs margin = FromSeconds(kAfter);
  for (size_t t = 0; t < tracks.size(); ++t) {
    if (tracks[t].first().time > crowd.begin + margin) {
      AddEnd(crowd, tracks, t, tracks[t].first(), intervals);
    }
    if (tracks[t].last().time < crowd.end - margin) {
      AddEnd(crowd, tracks, t, tracks[t].last(), intervals);
    }
  }
}

void AddMeetings(const Crowd& crowd, const std::vector<Tracklet>& tracks,
                 Intervals* intervals) {
  for (const auto& [frame, places] : crowd.present) {
    for (size_t i = 0; i < places.size(); ++i) {
      for (size_t k = i + 1; k < places.size(); ++k) {
        const Tracklet& a = tracks[places[i].track];
        const Tracklet& b = tracks[places[k].track];
        const TrackletFrame& at = a.frames[places[i].index];
        const double distance_m =
            (at.centre_m - b.frames[places[k].index].centre_m).norm();
        if (distance_m >= kMayExchange) continue;
        Interval interval{at.time, at.time, /*blind=*/false, {}};
        if (distance_m >= kTouching) {
          if (!SeemExchanged(a, places[i].index, b, places[k].index)) continue;
          interval.end += FromSeconds(kExchangeTime);
        }
        (*intervals)[places[i].track].push_back(interval);
        (*intervals)[places[k].track].push_back(interval);
      }
    }
  }
}

bool IsSeen(const PersonPose& person) {
  return std::any_of(person.inlier_views.begin(), person.inlier_views.end(),
                     [](int views) { return views > 0; });
}

// The states before and after a pause: `from` and `to` are successive frames in
// which a view sees the track.
Pieces::Hop HopOf(const Tracklet& track, size_t from, size_t to) {
  // A state uses less than a second.
  const long enough = IndexAt(track, track.frames[to].time + FromSeconds(1.0));
  Tracklet after;
  after.body_joints = track.body_joints;
  after.frames.assign(track.frames.begin() + static_cast<long>(to),
                      track.frames.begin() + enough + 1);
  return {StateUpTo(track, track.frames[from].time), StateAtBegin(after)};
}

// Calls see(from, to) with the indices of each two successive frames in which a
// view sees the track. The first frame, and every pose without counts of views,
// is treated as seen.
template <typename See>
void ForEachPause(const std::vector<TrackletFrame>& frames, const See& see) {
  size_t seen = 0;
  for (size_t k = 1; k < frames.size(); ++k) {
    const PersonPose& pose = *frames[k].pose;
    if (!pose.inlier_views.empty() && !IsSeen(pose)) continue;
    see(seen, k);
    seen = k;
  }
}

// The usual time between two frames in which a view sees a track [s].
double UsualPause(const std::vector<Tracklet>& tracks) {
  std::vector<double> pauses_s;
  for (const Tracklet& track : tracks) {
    ForEachPause(track.frames, [&](size_t from, size_t to) {
      pauses_s.push_back(
          ToSeconds(track.frames[to].time - track.frames[from].time));
    });
  }
  return Median(std::move(pauses_s));
}

// Adds the intervals in which no view sees a track.
void AddBlind(const std::vector<Tracklet>& tracks, Intervals* intervals) {
  // The pauses of a low rate, or of a detector that skips frames, are no gaps.
  const TimeNs least = FromSeconds(std::max(kBlind, 1.5 * UsualPause(tracks)));
  for (size_t t = 0; t < tracks.size(); ++t) {
    const std::vector<TrackletFrame>& frames = tracks[t].frames;
    ForEachPause(frames, [&](size_t from, size_t to) {
      if (frames[to].time - frames[from].time < least) return;
      (*intervals)[t].push_back({frames[from].time - FromSeconds(kAroundBlind),
                                 frames[to].time + FromSeconds(kAroundBlind),
                                 /*blind=*/true,
                                 {HopOf(tracks[t], from, to)}});
    });
  }
}

std::vector<Interval> Merged(std::vector<Interval> intervals) {
  std::sort(intervals.begin(), intervals.end(),
            [](const Interval& a, const Interval& b) {
              return std::make_pair(a.begin, a.end) <
                     std::make_pair(b.begin, b.end);
            });
  std::vector<Interval> merged;
  for (const Interval& interval : intervals) {
    if (merged.empty() ||
        interval.begin - merged.back().end > FromSeconds(kMerge)) {
      merged.push_back(interval);
    } else {
      merged.back().end = std::max(merged.back().end, interval.end);
      merged.back().blind = merged.back().blind && interval.blind;
      merged.back().hops.insert(merged.back().hops.end(), interval.hops.begin(),
                                interval.hops.end());
    }
  }
  return merged;
}

// Distance of a recovered track from its prediction [m].
double Astray(const Pieces::Hop& hop) {
  const auto& [before, after] = hop;
  return (after.position_m - before.position_m -
          ToSeconds(after.time - before.time) * before.velocity_mps)
      .norm();
}

// The farthest hop of at least kHop; null if there is none.
const Pieces::Hop* FarthestHop(const Interval& contact) {
  const auto farthest = std::max_element(
      contact.hops.begin(), contact.hops.end(),
      [](const auto& a, const auto& b) { return Astray(a) < Astray(b); });
  const bool is_one =
      farthest != contact.hops.end() && Astray(*farthest) >= kHop;
  return is_one ? &*farthest : nullptr;
}

// The first frame of the piece after a contact with frames begin .. end - 1:
// after the fastest movement, where an exchange shows; within the farthest hop
// if there is one.
size_t CutOf(const Tracklet& track, const Pieces::Hop* hop, size_t begin,
             size_t end) {
  if (hop != nullptr) {
    const long from = IndexAt(track, hop->first.time);
    const long to = IndexAt(track, hop->second.time);
    if (from >= 0 && to > from) {
      begin = static_cast<size_t>(from) + 1;
      end = static_cast<size_t>(to) + 1;
    }
  }
  size_t fastest = begin;
  double most = -1.0;
  for (size_t k = begin; k < std::max(end, begin + 1); ++k) {
    const double seconds =
        ToSeconds(track.frames[k].time - track.frames[k - 1].time);
    const double speed =
        (track.frames[k].centre_m - track.frames[k - 1].centre_m).norm() /
        seconds;
    if (speed > most) {
      most = speed;
      fastest = k;
    }
  }
  return fastest;
}

void CutTrack(const Tracklet& track, const std::vector<Interval>& contacts,
              Pieces* pieces) {
  Tracklet rest = track;
  const auto add = [&](Tracklet piece, bool goes_on, const Interval& contact) {
    pieces->tracklets.push_back(std::move(piece));
    pieces->blind.push_back(contact.blind);
    // For a blind contact the pieces' own states suffice.
    pieces->hops.push_back(contact.blind ? std::vector<Pieces::Hop>()
                                         : contact.hops);
    pieces->next.push_back(goes_on ? static_cast<int>(pieces->tracklets.size())
                                   : -1);
  };
  for (const Interval& contact : contacts) {
    const size_t size = rest.frames.size();
    // Frames before `begin` and from `end` on are clean.
    const auto begin =
        static_cast<size_t>(std::max(0L, IndexAt(rest, contact.begin - 1) + 1));
    const auto end = static_cast<size_t>(IndexAt(rest, contact.end) + 1);
    const Pieces::Hop* hop = FarthestHop(contact);
    const TimeNs least = FromSeconds(hop == nullptr ? kLeast : kLeastAtHop);
    const bool starts_with = contact.begin < rest.first().time + least;
    const bool ends_with = contact.end > rest.last().time - least;
    if (starts_with && ends_with) continue;
    if (starts_with) {
      rest.dirty_begin = std::max(rest.dirty_begin, end);
      continue;
    }
    if (ends_with) {
      rest.dirty_end = std::max(rest.dirty_end, size - begin);
      continue;
    }
    const size_t cut = CutOf(rest, hop, begin, end);
    Tracklet before;
    before.id = rest.id;
    before.body_joints = rest.body_joints;
    before.dirty_begin = rest.dirty_begin;
    before.frames.assign(rest.frames.begin(),
                         rest.frames.begin() + static_cast<long>(cut));
    before.dirty_end = cut > begin ? cut - begin : 0;
    rest.frames.erase(rest.frames.begin(),
                      rest.frames.begin() + static_cast<long>(cut));
    rest.dirty_begin = end > cut ? end - cut : 0;
    add(std::move(before), /*goes_on=*/true, contact);
  }
  add(std::move(rest), /*goes_on=*/false, {});
}

}  // namespace

Pieces CutAtContacts(const std::vector<Tracklet>& tracks) {
  Pieces pieces;
  if (tracks.empty()) return pieces;
  const Crowd crowd(tracks);
  Intervals intervals(tracks.size());
  AddEnds(crowd, tracks, &intervals);
  AddMeetings(crowd, tracks, &intervals);
  AddBlind(tracks, &intervals);
  for (size_t t = 0; t < tracks.size(); ++t) {
    CutTrack(tracks[t], Merged(std::move(intervals[t])), &pieces);
  }
  return pieces;
}

Together Compare(const Tracklet& a, const Tracklet& b) {
  constexpr double kSamePlace = 0.35;  // m, closer than people stay for long
  Together together;
  size_t k = 0;
  for (const TrackletFrame& frame : a.frames) {
    while (k < b.frames.size() && b.frames[k].frame < frame.frame) ++k;
    if (k == b.frames.size()) break;
    if (b.frames[k].frame != frame.frame) continue;
    ++together.frames;
    const std::optional<double> distance_m =
        MeanDistance(frame.pose->joints, b.frames[k].pose->joints);
    if (!distance_m.has_value() || *distance_m > kSamePlace) continue;
    ++together.same_place;
    together.distance_m += *distance_m;
  }
  if (together.same_place > 0) {
    together.distance_m /= static_cast<double>(together.same_place);
  }
  return together;
}

}  // namespace kinegraph
