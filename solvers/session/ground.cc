#include "solvers/session/ground.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/base/constants.h"
#include "core/base/median.h"
#include "core/data/stance.h"
#include "core/evaluation/statistics.h"
#include "solvers/cameras/camera_change.h"
#include "solvers/session/run.h"
#include "solvers/session/subject_gauge.h"

namespace kinegraph {
namespace {

// Feet slower than this are standing; a swinging foot reaches 3 m/s.
constexpr double kStandingMps = 0.4;
constexpr double kRestS = 0.1;  // shortest interval of a measured speed
// Ankles are 0.039 of the stature (here 1.72 m) above the floor (Drillis and
// Contini, 1966); toes and heels are above it by the thickness of the shoe.
constexpr double kAnkleHeightM = 0.067;
constexpr double kToeHeightM = 0.02;
constexpr int64_t kFewestFeet = 50;  // positions of resting foot joints

struct FootJoint {
  int joint = -1;
  double height_m = 0.0;
};

std::vector<FootJoint> FeetOf(const Skeleton& skeleton) {
  std::vector<FootJoint> feet;
  const auto add = [&](const std::string& name, double height_m) {
    const int joint = skeleton.IndexOf(name);
    if (joint >= 0) feet.push_back({joint, height_m});
  };
  for (const std::string side : {"l_", "r_"}) {
    add(side + "ankle", kAnkleHeightM);
    add(side + "big_toe", kToeHeightM);
    add(side + "heel", kToeHeightM);
  }
  return feet;
}

// Sum over people and frames of the directions from ankles to shoulders; it is
// nearly vertical because people bend to all sides.
Eigen::Vector3d MeanBodyAxis(const Skeleton& skeleton,
                             const std::vector<TrackFrame>& frames) {
  const auto middle = [&](const Pose3d& joints, const std::string& part) {
    return ObservedMiddle(joints, skeleton.IndexOf("l_" + part),
                          skeleton.IndexOf("r_" + part));
  };
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const TrackFrame& frame : frames) {
    for (const PersonPose& person : frame.people) {
      const auto below = middle(person.joints, "ankle");
      const auto above = middle(person.joints, "shoulder");
      if (below.has_value() && above.has_value()) {
        sum += (*above - *below).normalized();
      }
    }
  }
  return sum;
}

// A position in which a joint of a foot rests for a while.
struct Stand {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // mean position
  double height_m = 0.0;                            // above the floor
  double weight = 1.0;  // toe, heel and ankle of one foot share one weight
  int samples = 0;
};

// The positions of a person's joints in an earlier frame.
struct Past {
  TimeNs time = 0;
  const Pose3d* joints = nullptr;
};

// The longest interval over which speed is measured: three times kRestS or, at
// low frame rates, one and a half times the usual interval between frames with
// people, but at most kLongestS, because in more time a foot may make a step.
TimeNs LongestRest(const std::vector<TrackFrame>& frames) {
  constexpr double kLongestS = 0.6;
  std::vector<double> steps_s;
  const TrackFrame* last = nullptr;
  for (const TrackFrame& frame : frames) {
    if (frame.people.empty()) continue;
    if (last != nullptr) steps_s.push_back(ToSeconds(frame.time - last->time));
    last = &frame;
  }
  const double usual_s = Median(std::move(steps_s));
  return FromSeconds(
      std::max(3.0 * kRestS, std::min(1.5 * usual_s, kLongestS)));
}

// The newest entry that is at least kRestS old, and less than `longest`. Over
// shorter intervals, which high frame rates would give, noise would appear as
// speed.
const Past* LongEnoughAgo(const std::deque<Past>& past, TimeNs now,
                          TimeNs longest) {
  for (auto at = past.rbegin(); at != past.rend(); ++at) {
    if (now - at->time < FromSeconds(kRestS)) continue;
    return now - at->time < longest ? &*at : nullptr;
  }
  return nullptr;
}

// Whether a joint has not moved, apart from the sway of a standing person.
bool Rests(size_t joint, const Past& before, TimeNs now,
           const PersonPose& person) {
  const Joint3d& last = (*before.joints)[joint];
  const Joint3d& one = person.joints[joint];
  return last.status == JointStatus::kObserved &&
         one.status == JointStatus::kObserved &&
         (one.position_m - last.position_m).norm() <=
             kStandingMps * ToSeconds(now - before.time);
}

// The stands of all people.
std::vector<Stand> StandsIn(const Skeleton& skeleton,
                            const std::vector<TrackFrame>& frames) {
  constexpr double kFarM = 0.3;  // a shuffling foot begins a new stand
  const std::vector<FootJoint> feet = FeetOf(skeleton);
  const TimeNs longest = LongestRest(frames);
  std::vector<Stand> stands;
  std::map<TrackId, std::deque<Past>> pasts;
  std::map<std::pair<TrackId, int>, size_t> open;  // current stands
  for (const TrackFrame& frame : frames) {
    for (const PersonPose& person : frame.people) {
      std::deque<Past>& past = pasts[person.id];
      const Past* const before = LongEnoughAgo(past, frame.time, longest);
      for (const FootJoint& foot : feet) {
        const auto j = static_cast<size_t>(foot.joint);
        if (before == nullptr || !Rests(j, *before, frame.time, person)) {
          open.erase({person.id, foot.joint});
          continue;
        }
        const Eigen::Vector3d& point = person.joints[j].position_m;
        const auto [at, is_new] =
            open.try_emplace({person.id, foot.joint}, stands.size());
        if (is_new || (stands[at->second].point - point).norm() > kFarM) {
          at->second = stands.size();
          stands.push_back({point, foot.height_m,
                            2.0 / static_cast<double>(feet.size()), 1});
          continue;
        }
        Stand& stand = stands[at->second];
        ++stand.samples;
        stand.point += (point - stand.point) / stand.samples;
      }
      past.push_back({frame.time, &person.joints});
      while (past.front().time < frame.time - longest - FromSeconds(kRestS)) {
        past.pop_front();
      }
    }
  }
  return stands;
}

int64_t SamplesOf(const std::vector<Stand>& stands) {
  int64_t samples = 0;
  for (const Stand& stand : stands) samples += stand.samples;
  return samples;
}

// A rotation that maps `up` to z and keeps the old x axis (or the old y axis if
// x points up) in the plane of the new x and z.
Eigen::Matrix3d Upright(const Eigen::Vector3d& up) {
  const Eigen::Vector3d old = std::abs(up.x()) < 0.9 ? Eigen::Vector3d::UnitX()
                                                     : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d x = (old - old.dot(up) * up).normalized();
  Eigen::Matrix3d R;
  R.row(0) = x.transpose();
  R.row(1) = up.cross(x).transpose();
  R.row(2) = up.transpose();
  return R;
}

double MedianOf(const std::vector<Stand>& feet, int axis) {
  std::vector<double> values;
  for (const Stand& foot : feet) {
    values.push_back(foot.point[axis] - (axis == 2 ? foot.height_m : 0.0));
  }
  return Quantile(values, 0.5);
}

// Standard deviation of the mean standing direction as an estimate of up; not
// small, because some people are always bent.
constexpr double kBodySigmaRad = 0.12;
// Calibrations often have one vertical axis, to within kAxisSigmaRad; such an
// axis is preferred unless another direction is e^kAxisOdds = 148 times as
// likely.
constexpr double kAxisSigmaRad = 0.035;
constexpr double kAxisOdds = 5.0;

// A candidate for up, before feet are considered.
struct Guess {
  Eigen::Vector3d up;
  bool is_axis = false;  // an axis of the original world
};

std::vector<Guess> GuessesOf(const Eigen::Vector3d& body) {
  std::vector<Guess> guesses = {{body, false}};
  Eigen::Index axis = 0;
  body.cwiseAbs().maxCoeff(&axis);
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  up[axis] = body[axis] > 0.0 ? 1.0 : -1.0;
  constexpr double kNear = 0.87;  // cosine of 30 degrees
  if (up.dot(body) > kNear) guesses.push_back({up, true});
  return guesses;
}

// The floor z = a + b x + c y about the median position of the feet.
struct Floor {
  Eigen::Vector3d abc = Eigen::Vector3d::Zero();
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  double cost = 0.0;  // negative log posterior density, up to a constant

  Eigen::Vector3d Up() const {
    return Eigen::Vector3d(-abc[1], -abc[2], 1.0).normalized();
  }
};

Eigen::Vector2d SlopeOf(const Eigen::Vector3d& up) {
  return -up.head<2>() / up.z();
}

// Fits the floor robustly in a nearly upright world: feet on steps and chairs
// have little weight. `body`: the upward direction according to people's poses;
// `axis`: an axis of the original world that may be vertical, or null.
Floor FitFloor(const std::vector<Stand>& feet, const Eigen::Vector3d& body,
               const Eigen::Vector3d* axis) {
  constexpr double kSigmaM = 0.03;  // of a stand's height
  // Upper limit of the cost of a foot that is not on the floor, as on a step or
  // a chair.
  constexpr double kMostCost = 2.0;
  Floor floor;
  floor.middle = {MedianOf(feet, 0), MedianOf(feet, 1)};
  floor.abc[0] = MedianOf(feet, 2);
  Eigen::Matrix3d prior = 1e-9 * Eigen::Matrix3d::Identity();
  Eigen::Vector3d pull = Eigen::Vector3d::Zero();
  const auto hold = [&](const Eigen::Vector3d& up, double sigma) {
    prior.diagonal().tail<2>().array() += std::pow(sigma, -2);
    pull.tail<2>() += SlopeOf(up) / (sigma * sigma);
  };
  hold(body, kBodySigmaRad);
  if (axis != nullptr) hold(*axis, kAxisSigmaRad);
  for (int iteration = 0; iteration < 20; ++iteration) {
    Eigen::Matrix3d H = prior;
    Eigen::Vector3d g = pull;
    floor.cost = axis != nullptr ? 0.0 : kAxisOdds;
    for (const Stand& foot : feet) {
      const Eigen::Vector3d row(1.0, foot.point.x() - floor.middle.x(),
                                foot.point.y() - floor.middle.y());
      const double z = foot.point.z() - foot.height_m;
      const double off = (z - row.dot(floor.abc)) / kSigmaM;
      const double weight =
          foot.weight / ((1.0 + off * off) * kSigmaM * kSigmaM);
      H += weight * row * row.transpose();
      g += weight * z * row;
      floor.cost +=
          foot.weight * std::min(0.5 * std::log1p(off * off), kMostCost);
    }
    const auto away = [&](const Eigen::Vector3d& up, double sigma) {
      return 0.5 * (floor.abc.tail<2>() - SlopeOf(up)).squaredNorm() /
             (sigma * sigma);
    };
    floor.cost += away(body, kBodySigmaRad);
    if (axis != nullptr) floor.cost += away(*axis, kAxisSigmaRad);
    floor.abc = H.ldlt().solve(g);
  }
  return floor;
}

// A rotation of the world that makes z point up.
struct Upturn {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  double cost = std::numeric_limits<double>::infinity();  // Floor::cost
};

// The most likely up near a candidate. The fit is linear in the slope, so a few
// rounds suffice for tilts of a few degrees.
Upturn TurnUp(const std::vector<Stand>& feet, const Eigen::Vector3d& body,
              const Guess& guess) {
  Upturn result;
  result.R = Upright(guess.up);
  for (int round = 0; round < 3; ++round) {
    std::vector<Stand> turned = feet;
    for (Stand& foot : turned) foot.point = result.R * foot.point;
    const Eigen::Vector3d axis = result.R * guess.up;
    const Floor floor =
        FitFloor(turned, result.R * body, guess.is_axis ? &axis : nullptr);
    result.cost = floor.cost;
    result.R =
        Eigen::Quaterniond::FromTwoVectors(floor.Up(), Eigen::Vector3d::UnitZ())
            .toRotationMatrix() *
        result.R;
  }
  return result;
}

}  // namespace

std::optional<Ground> GroundOf(const TrackHeader& header,
                               const std::vector<TrackFrame>& frames) {
  const Eigen::Vector3d axis = MeanBodyAxis(header.skeleton, frames);
  std::vector<Stand> feet = StandsIn(header.skeleton, frames);
  Ground ground;
  ground.foot_count = SamplesOf(feet);
  if (!(axis.norm() > 0.0) || ground.foot_count < kFewestFeet) {
    return std::nullopt;
  }
  // If most people lie, their mean axis is not vertical: the up direction
  // according to Stance replaces it if they differ by more than 50 degrees.
  const Eigen::Vector3d mean = axis.normalized();
  const Eigen::Vector3d body =
      StanceOf(header.skeleton, frames).UpUnlike(mean).value_or(mean);
  Upturn best;
  for (const Guess& guess : GuessesOf(body)) {
    const Upturn one = TurnUp(feet, body, guess);
    if (one.cost < best.cost) best = one;
  }
  const Eigen::Matrix3d R = Upright(best.R.row(2).transpose());
  for (Stand& foot : feet) foot.point = R * foot.point;
  ground.R = R;
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  ground.t = -Eigen::Vector3d(MedianOf(feet, 0), MedianOf(feet, 1),
                              FitFloor(feet, up, &up).abc[0]);
  double squares = 0.0;
  for (const Stand& foot : feet) {
    const double off = foot.point.z() - foot.height_m + ground.t.z();
    // Clamped at a decimetre, for feet on a step or a chair.
    squares += foot.samples * std::min(off * off, 0.01);
  }
  ground.spread_m = std::sqrt(squares / static_cast<double>(ground.foot_count));
  ground.tilt_deg =
      kDegPerRad * std::acos(std::min(1.0, std::max(-1.0, R(2, 2))));
  return ground;
}

CameraRig OnGround(const CameraRig& cameras, const Ground& ground) {
  return Edited(cameras, [&](CameraParameters* camera) {
    camera->R = camera->R * ground.R.transpose();
    camera->t = camera->t - camera->R * ground.t;
  });
}

void TurnRecord(const Ground& ground, RefinementRecord* record) {
  const Eigen::Index size = record->covariance.rows();
  Eigen::MatrixXd turn = Eigen::MatrixXd::Identity(size, size);
  Eigen::Index at = 0;
  for (const RefinementRecord::Camera& camera : record->cameras) {
    for (size_t i = 0; i < camera.places.size(); ++i, ++at) {
      // The three coordinates of a centre are adjacent, so one block covers
      // them.
      if (camera.places[i] == kCentreAt) turn.block<3, 3>(at, at) = ground.R;
    }
  }
  record->covariance = turn * record->covariance * turn.transpose();
}

RunOptions QuickOptions(RunOptions options) {
  options.refine = RefineOptions();
  options.estimators.mode = Mode::kPaper;
  options.tracker.life.second_pass = false;
  options.identity.link = false;
  return options;
}

std::optional<Ground> FindGround(const RunOptions& options,
                                 const RunRequest& request,
                                 const DetectionSequence& detections) {
  RunRequest asked = request;
  asked.corrections.clear();
  asked.kept_matches = KeptMatches::kNone;
  TrackSequence tracks =
      TrackSequenceOf(QuickOptions(options), asked, detections);
  const SubjectScale scale = ScaleOf(tracks);
  for (TrackFrame& frame : tracks.frames) {
    frame = scale.IntoRun(std::move(frame));
  }
  std::optional<Ground> ground = GroundOf(tracks.header, tracks.frames);
  if (ground.has_value()) {
    ground->t *= scale.metres();
    ground->spread_m *= scale.metres();
  }
  return ground;
}

}  // namespace kinegraph
