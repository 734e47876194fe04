#include "core/synthetic/recorded_people.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/base/random.h"

namespace kinegraph {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;

using RecordedPeople = std::vector<std::shared_ptr<const Actor>>;

// The frames of one person.
struct Knots {
  std::vector<double> times_s;
  std::vector<const PersonPose*> poses;
  std::vector<int64_t> frames;
};

std::string FrameName(int64_t frame) {
  return "frame " + std::to_string(frame);
}

std::map<TrackId, Knots> KnotsOf(const MotionClip& clip) {
  std::map<TrackId, Knots> people;
  if (clip.tracks.frames.empty()) {
    throw InputError(clip.name, "", "no frames: nobody moves in this file");
  }
  const TimeNs begin = clip.tracks.frames.front().time;
  TimeNs last = begin;
  for (const TrackFrame& frame : clip.tracks.frames) {
    if (&frame != &clip.tracks.frames.front() && frame.time <= last) {
      throw InputError(clip.name, FrameName(frame.frame),
                       "its time is not after that of the frame before; a "
                       "clip needs times or a frame rate");
    }
    last = frame.time;
    for (const PersonPose& person : frame.people) {
      Knots& knots = people[person.id];
      knots.times_s.push_back(ToSeconds(frame.time - begin));
      knots.poses.push_back(&person);
      knots.frames.push_back(frame.frame);
    }
  }
  if (people.empty()) {
    throw InputError(clip.name, "", "no people: nobody moves in this file");
  }
  return people;
}

// For each joint of `to` its index in the clip.
std::vector<int> MapJoints(const MotionClip& clip, const Skeleton& to) {
  const Skeleton& from = clip.tracks.header.skeleton;
  std::vector<int> map = MapByName(from, to);
  for (size_t j = 0; j < map.size(); ++j) {
    if (map[j] >= 0) continue;
    throw InputError(clip.name, "",
                     "skeleton '" + from.name() + "' has no joint '" +
                         to.joints()[j] + "', which skeleton '" + to.name() +
                         "' of the scene needs");
  }
  return map;
}

MatrixXd ValuesOf(const MotionClip& clip, const Knots& knots, size_t begin,
                  size_t end, const std::vector<int>& map) {
  MatrixXd values(3 * static_cast<Eigen::Index>(map.size()),
                  static_cast<Eigen::Index>(end - begin));
  for (size_t k = begin; k < end; ++k) {
    for (size_t j = 0; j < map.size(); ++j) {
      const Joint3d& joint =
          knots.poses[k]->joints[static_cast<size_t>(map[j])];
      const auto fail = [&](const char* what) {
        const auto& names = clip.tracks.header.skeleton.joints();
        throw InputError(
            clip.name, FrameName(knots.frames[k]),
            "joint '" + names[static_cast<size_t>(map[j])] + "' " + what);
      };
      if (!joint.present()) fail("has no position; a clip needs every joint");
      if (!joint.position_m.allFinite()) fail("is not finite");
      values.block<3, 1>(3 * static_cast<Eigen::Index>(j),
                         static_cast<Eigen::Index>(k - begin)) =
          joint.position_m;
    }
  }
  return values;
}

// Stretches of frames without a long gap between them.
std::vector<KnotSpline> PiecesOf(const MotionClip& clip, const Knots& knots,
                                 const std::vector<int>& map) {
  std::vector<KnotSpline> pieces;
  const size_t count = knots.times_s.size();
  for (size_t begin = 0, end = 1; begin < count; begin = end++) {
    while (end < count &&
           knots.times_s[end] - knots.times_s[end - 1] <= kLongestClipGap) {
      ++end;
    }
    const MatrixXd values = ValuesOf(clip, knots, begin, end, map);
    if (end - begin < 2) continue;  // a single frame is no motion
    pieces.emplace_back(
        std::vector<double>(
            knots.times_s.begin() + static_cast<std::ptrdiff_t>(begin),
            knots.times_s.begin() + static_cast<std::ptrdiff_t>(end)),
        values);
  }
  return pieces;
}

// The smallest upright box around all people of a clip, seen from above.
struct Extent {
  Vector2d low = Vector2d::Constant(std::numeric_limits<double>::infinity());
  Vector2d high = -low;

  Vector2d centre() const { return 0.5 * (low + high); }
};

Extent ExtentOf(const std::vector<RecordedMotion>& motions) {
  Extent extent;
  for (const RecordedMotion& motion : motions) {
    for (const KnotSpline& piece : motion.pieces) {
      for (Eigen::Index i = 0; i < piece.values().size(); i += 3) {
        const Vector2d point(piece.values().data()[i],
                             piece.values().data()[i + 1]);
        extent.low = extent.low.cwiseMin(point);
        extent.high = extent.high.cwiseMax(point);
      }
    }
  }
  return extent;
}

// Farthest that anything of a clip is from the middle of its way [m].
double ReachOf(const std::vector<RecordedMotion>& motions,
               const Vector2d& centre) {
  double reach = 0.0;
  for (const RecordedMotion& motion : motions) {
    for (const KnotSpline& piece : motion.pieces) {
      for (Eigen::Index i = 0; i < piece.values().size(); i += 3) {
        const Vector2d point(piece.values().data()[i],
                             piece.values().data()[i + 1]);
        reach = std::max(reach, (point - centre).norm());
      }
    }
  }
  return reach;
}

double At(const std::vector<double>& list, size_t i) {
  return i < list.size() ? list[i] : 0.0;
}

// Of a list with a number a clip: it may end early, the rest are then 0; or it
// is whole or left out.
enum class Lists { kMayEndEarly, kAllOrNone };

void CheckCount(const char* key, const std::vector<double>& list, size_t clips,
                Lists rule) {
  const bool wrong = rule == Lists::kAllOrNone
                         ? !list.empty() && list.size() != clips
                         : list.size() > clips;
  if (!wrong) return;
  throw OptionError(key, "found " + std::to_string(list.size()) +
                             (list.size() == 1 ? " number" : " numbers") +
                             " for " + std::to_string(clips) +
                             (clips == 1 ? " clip" : " clips"));
}

void CheckLists(const RecordedPeopleOptions& options, size_t clips) {
  CheckOptions(options);
  CheckCount("start", options.start_s, clips, Lists::kMayEndEarly);
  CheckCount("hold", options.hold_s, clips, Lists::kMayEndEarly);
  CheckCount("x", options.x_m, clips, Lists::kAllOrNone);
  CheckCount("y", options.y_m, clips, Lists::kAllOrNone);
  CheckCount("turn", options.turn_deg, clips, Lists::kAllOrNone);
  if (options.x_m.empty() != options.y_m.empty()) {
    throw OptionError(options.x_m.empty() ? "x" : "y",
                      "is missing: a place needs both x and y");
  }
}

// The least distance of two trunks in the time that both are there.
double ClosestOf(const Actor& a, const Actor& b) {
  constexpr double kSampleStep =
      0.1;  // [s]: nobody goes farther than 0.5 m in it
  double closest = std::numeric_limits<double>::infinity();
  for (const TimeSpan& span : a.Facts().present) {
    for (double t = span.begin_s; t <= span.end_s; t += kSampleStep) {
      if (!a.PresentAt(t) || !b.PresentAt(t)) continue;
      closest = std::min(
          closest,
          (a.TrunkAt(t).origin_m - b.TrunkAt(t).origin_m).head<2>().norm());
    }
  }
  return closest;
}

double ClosestOf(const RecordedPeople& some, const RecordedPeople& others) {
  double closest = std::numeric_limits<double>::infinity();
  for (const auto& a : some) {
    for (const auto& b : others) closest = std::min(closest, ClosestOf(*a, *b));
  }
  return closest;
}

// Places one clip after the other.
class ClipPlacer {
 public:
  ClipPlacer(const RecordedPeopleOptions& options, const ClipRoom& room)
      : options_(options), room_(room), seeds_(room.seed) {}

  void Add(const std::vector<RecordedMotion>& motions, size_t clip_idx) {
    // One fork a kind of chance, so that one leaves the others as they are.
    Random random(seeds_.Fork());
    sway_seed_ = seeds_.Fork();
    body_seed_ = seeds_.Fork();
    const bool given = !options_.x_m.empty();
    const Vector2d centre = ExtentOf(motions).centre();
    const double free =
        std::max(0.0, room_.radius_m - ReachOf(motions, centre));
    // A place that is given, and a turn, are taken as they are.
    const int attempts = given && !options_.turn_deg.empty() ? 1 : kAttempts;
    for (int attempt = 0; attempt < attempts; ++attempt) {
      ClipPlace place = Draw(free, &random);
      place.centre_m = centre;
      if (given) {
        place.place_m = {options_.x_m[clip_idx], options_.y_m[clip_idx]};
      }
      if (!options_.turn_deg.empty()) {
        place.turn_rad = options_.turn_deg[clip_idx] * kPi / 180.0;
      }
      RecordedPeople people = Make(motions, place, clip_idx);
      const bool apart = ClosestOf(people, people_) >= room_.min_distance_m;
      if (!apart && !given) continue;
      people_.insert(people_.end(), people.begin(), people.end());
      return;
    }
    throw OptionError(
        "clips", motions.front().clip +
                     ": no place found where its people keep apart from those "
                     "of the clips before; give x and y, later starts or a "
                     "larger scene.motion.area_radius");
  }

  const RecordedPeople& people() const { return people_; }

 private:
  static constexpr int kAttempts = 300;

  // Uniform over a disc and all directions.
  static ClipPlace Draw(double radius_m, Random* random) {
    ClipPlace place;
    const double distance = radius_m * std::sqrt(random->Uniform());
    const double angle = random->Uniform(0.0, 2.0 * kPi);
    place.place_m = distance * Vector2d(std::cos(angle), std::sin(angle));
    place.turn_rad = random->Uniform(-kPi, kPi);
    return place;
  }

  RecordedPeople Make(const std::vector<RecordedMotion>& motions,
                      const ClipPlace& place, size_t clip_idx) const {
    const ClipTiming timing = {At(options_.start_s, clip_idx),
                               At(options_.hold_s, clip_idx),
                               options_.hold_sway_m};
    RecordedPeople people;
    for (size_t i = 0; i < motions.size(); ++i) {
      people.push_back(std::make_shared<RecordedActor>(
          motions[i], place, timing,
          JointSway{options_.joint_sway_m, sway_seed_ + i}, body_seed_ + i));
    }
    return people;
  }

  const RecordedPeopleOptions& options_;
  const ClipRoom& room_;
  Random seeds_;
  uint64_t sway_seed_ = 0;
  uint64_t body_seed_ = 0;
  RecordedPeople people_;
};

}  // namespace

void RecordedPeopleOptions::Describe(OptionVisitor& visitor) {
  visitor.TextList("clips", &clips,
                   "tracks files whose people take the place of simulated "
                   "ones, relative to this file's folder");
  visitor.NumberList("start", &start_s, Between(0.0, 36000.0), "s",
                     "when the people of each clip appear; the rest 0");
  visitor.NumberList("hold", &hold_s, Between(0.0, 36000.0), "s",
                     "for how long they hold the clip's first pose before "
                     "they move; the rest 0");
  visitor.NumberList("x", &x_m, Between(-1000.0, 1000.0), "m",
                     "place of the middle of each clip's way; empty: drawn");
  visitor.NumberList("y", &y_m, Between(-1000.0, 1000.0), "m",
                     "place of the middle of each clip's way; empty: drawn");
  visitor.NumberList("turn", &turn_deg, Between(-360.0, 360.0), "deg",
                     "of each clip about the vertical; empty: drawn");
  visitor.Number("hold_sway", &hold_sway_m, Between(0.0, 0.1), "m",
                 "sway of a body that holds its pose: RMS, forward, 1 m above "
                 "the ankles");
  visitor.Number("joint_sway", &joint_sway_m, Between(0.0, 0.1), "m",
                 "joint centres move with the joint's angle, by half to one "
                 "and a half of this; 0: rigid bones stay rigid");
}

std::vector<RecordedMotion> MotionsOf(const MotionClip& clip,
                                      const Skeleton& skeleton) {
  const std::map<TrackId, Knots> people = KnotsOf(clip);
  const std::vector<int> map = MapJoints(clip, skeleton);
  std::vector<RecordedMotion> motions;
  for (const auto& [id, knots] : people) {
    RecordedMotion motion;
    motion.clip = clip.name;
    motion.id = id;
    motion.skeleton = skeleton;
    motion.pieces = PiecesOf(clip, knots, map);
    if (!motion.pieces.empty()) motions.push_back(std::move(motion));
  }
  if (motions.empty()) {
    throw InputError(clip.name, "",
                     "nobody is there in two frames at most 0.25 s apart");
  }
  return motions;
}

RecordedPeople MakeRecordedPeople(const RecordedPeopleOptions& options,
                                  const std::vector<MotionClip>& clips,
                                  const Skeleton& skeleton,
                                  const ClipRoom& room) {
  CheckLists(options, clips.size());
  ClipPlacer placer(options, room);
  for (size_t i = 0; i < clips.size(); ++i) {
    placer.Add(MotionsOf(clips[i], skeleton), i);
  }
  return placer.people();
}

double EndOf(const RecordedPeople& people) {
  double end_s = 0.0;
  for (const auto& person : people) {
    for (const TimeSpan& span : person->Facts().present) {
      end_s = std::max(end_s, span.end_s);
    }
  }
  return end_s;
}

}  // namespace kinegraph
