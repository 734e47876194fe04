#include "core/evaluation/derivatives.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "core/base/constants.h"
#include "core/evaluation/correspondence.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;

constexpr int kContacts = 1;  // index of the scope "around contacts"

struct Motion {
  Vector3d velocity_m_s = Vector3d::Zero();
  Vector3d acceleration_m_s2 = Vector3d::Zero();
};
using OptionalMotion = std::optional<Motion>;

// Motion of one joint of one person, one entry per frame.
struct JointMotion {
  std::vector<OptionalMotion> truth, found;
};

OptionalMotion MotionAt(const Joint3d& before, const Joint3d& at,
                        const Joint3d& after, double rate_hz) {
  if (!before.present() || !at.present() || !after.present()) {
    return std::nullopt;
  }
  return Motion{
      0.5 * rate_hz * (after.position_m - before.position_m),
      rate_hz * rate_hz *
          (after.position_m - 2.0 * at.position_m + before.position_m)};
}

const JointDerivatives* OwnOf(const PersonPose& person, int joint) {
  if (person.derivatives.empty()) return nullptr;
  const auto& own = person.derivatives[joint];
  return own.has_value() ? &*own : nullptr;
}

// Replaces differences of positions by the derivatives of the estimator's
// model, if any.
void UseModel(const PersonPose& before, const PersonPose& at,
              const PersonPose& after, int joint, double rate_hz,
              OptionalMotion* motion, DerivativeResult* result) {
  const JointDerivatives* own = OwnOf(at, joint);
  if (!motion->has_value() || own == nullptr) return;
  (*motion)->velocity_m_s = own->velocity_m_s;
  result->velocity_source = DerivativeSource::kModel;
  if (own->acceleration_m_s2.has_value()) {
    (*motion)->acceleration_m_s2 = *own->acceleration_m_s2;
    result->acceleration_source = DerivativeSource::kModel;
    return;
  }
  const JointDerivatives* first = OwnOf(before, joint);
  const JointDerivatives* last = OwnOf(after, joint);
  if (first == nullptr || last == nullptr) return;
  (*motion)->acceleration_m_s2 =
      0.5 * rate_hz * (last->velocity_m_s - first->velocity_m_s);
  result->acceleration_source = DerivativeSource::kModelVelocity;
}

// `pairs`: the frames of one true person.
std::vector<JointMotion> MotionOf(const std::vector<PersonPair>& pairs,
                                  const JointPairs& joints, double rate_hz,
                                  int64_t stride, DerivativeResult* result) {
  std::vector<JointMotion> motions(joints.size());
  for (size_t k = 0; k < pairs.size(); ++k) {
    const bool inside = k > 0 && k + 1 < pairs.size() &&
                        pairs[k + 1].frame - pairs[k - 1].frame == 2 * stride;
    const bool same = inside && pairs[k - 1].found != nullptr &&
                      pairs[k].found != nullptr &&
                      pairs[k + 1].found != nullptr &&
                      pairs[k - 1].found->id == pairs[k].found->id &&
                      pairs[k + 1].found->id == pairs[k].found->id;
    for (size_t j = 0; j < joints.size(); ++j) {
      OptionalMotion truth;
      OptionalMotion found;
      if (inside) {
        const auto at = [&](size_t i) -> const Joint3d& {
          return pairs[i].truth->joints[joints[j].a];
        };
        truth = MotionAt(at(k - 1), at(k), at(k + 1), rate_hz);
      }
      if (same) {
        const auto at = [&](size_t i) -> const Joint3d& {
          return pairs[i].found->joints[joints[j].b];
        };
        found = MotionAt(at(k - 1), at(k), at(k + 1), rate_hz);
        UseModel(*pairs[k - 1].found, *pairs[k].found, *pairs[k + 1].found,
                 joints[j].b, rate_hz, &found, result);
      }
      motions[j].truth.push_back(truth);
      motions[j].found.push_back(found);
    }
  }
  return motions;
}

// The index of the greatest `score` within `reach` of `middle`; -1 if there is
// none.
template <typename Score>
int Greatest(int middle, int reach, int count, const Score& score) {
  int best = -1;
  double most = 0.0;
  for (int k = std::max(0, middle - reach);
       k <= std::min(count - 1, middle + reach); ++k) {
    const std::optional<double> here = score(k);
    if (!here.has_value() || (best >= 0 && *here <= most)) continue;
    best = k;
    most = *here;
  }
  return best;
}

// Marks the frames around contacts of an ankle and returns the number of
// contacts.
int64_t MarkContacts(const JointMotion& ankle, const Vector3d& up, int reach,
                     std::vector<bool>* at_contact) {
  constexpr double kG_m_s2 = 9.81;
  const int count = static_cast<int>(ankle.truth.size());
  const auto slowed = [&](int k) -> std::optional<double> {
    if (!ankle.truth[k].has_value()) return std::nullopt;
    return ankle.truth[k]->acceleration_m_s2.dot(up);
  };
  int64_t contacts = 0;
  for (int k = 1; k < count; ++k) {
    const OptionalMotion& before = ankle.truth[k - 1];
    const auto here = slowed(k);
    if (!here.has_value() || *here <= kG_m_s2 || !before.has_value() ||
        before->velocity_m_s.dot(up) >= 0.0 ||
        Greatest(k, reach, count, slowed) != k) {
      continue;
    }
    ++contacts;
    for (int i = std::max(0, k - reach); i <= std::min(count - 1, k + reach);
         ++i) {
      (*at_contact)[i] = true;
    }
  }
  return contacts;
}

double SquaredVelocityError(const Motion& truth, const Motion& found) {
  return (found.velocity_m_s - truth.velocity_m_s).squaredNorm();
}
double SquaredAccelerationError(const Motion& truth, const Motion& found) {
  return (found.acceleration_m_s2 - truth.acceleration_m_s2).squaredNorm();
}

// Sums that become DerivativeErrors.
struct ErrorSums {
  int64_t count = 0;
  double velocity = 0.0, speed = 0.0, acceleration = 0.0, length = 0.0;
  int64_t peaks = 0;
  double peak = 0.0, instant_s = 0.0;

  void Add(const Motion& truth, const Motion& found) {
    ++count;
    velocity += SquaredVelocityError(truth, found);
    speed += found.velocity_m_s.norm() - truth.velocity_m_s.norm();
    acceleration += SquaredAccelerationError(truth, found);
    length += found.acceleration_m_s2.norm() - truth.acceleration_m_s2.norm();
  }
  DerivativeErrors Errors() const {
    const auto mean = [](double sum, int64_t of) {
      return of == 0 ? kNan : sum / static_cast<double>(of);
    };
    return {count,
            std::sqrt(mean(velocity, count)),
            mean(speed, count),
            std::sqrt(mean(acceleration, count)),
            mean(length, count),
            peaks,
            100.0 * mean(peak, peaks),
            1000.0 * mean(instant_s, peaks)};
  }
};

using ScopedSums = std::array<ErrorSums, kDerivativeScopes>;

// Adds the errors at the peaks of a joint to each of `sums`.
void AddPeaks(const JointMotion& joint, const std::vector<bool>& at_contact,
              double rate_hz, const std::vector<ScopedSums*>& sums) {
  const int count = static_cast<int>(joint.truth.size());
  const int around = std::max(1, static_cast<int>(std::lround(0.25 * rate_hz)));
  const int reach = std::max(1, static_cast<int>(std::lround(0.1 * rate_hz)));
  const auto length = [](const std::vector<OptionalMotion>& motion) {
    return [&motion](int k) -> std::optional<double> {
      if (!motion[k].has_value()) return std::nullopt;
      return motion[k]->acceleration_m_s2.norm();
    };
  };
  const auto of_truth = length(joint.truth);
  const auto of_found = length(joint.found);
  double squares = 0.0;
  double total = 0.0;
  for (int k = 0; k < count; ++k) {
    const auto here = of_truth(k);
    if (!here.has_value()) continue;
    squares += *here * *here;
    total += 1.0;
  }
  const double least = 2.0 * std::sqrt(squares / total);
  for (int k = 0; k < count; ++k) {
    const auto peak = of_truth(k);
    if (!peak.has_value() || *peak <= least ||
        Greatest(k, around, count, of_truth) != k) {
      continue;
    }
    const int at = Greatest(k, reach, count, of_found);
    if (at < 0) continue;
    const double share = *of_found(at) / *peak - 1.0;
    for (ScopedSums* each : sums) {
      for (int scope = 0; scope < kDerivativeScopes; ++scope) {
        if (scope == kContacts && !at_contact[k]) continue;
        ErrorSums& sum = (*each)[scope];
        ++sum.peaks;
        sum.peak += share;
        sum.instant_s += std::abs(at - k) / rate_hz;
      }
    }
  }
}

// Step between compared frames, in frames of the tracks: 2 where the truth has
// every other frame. 0: no person has two frames.
int64_t StrideOf(const std::map<TrackId, std::vector<PersonPair>>& people) {
  int64_t stride = 0;
  for (const auto& [id, pairs] : people) {
    for (size_t k = 1; k < pairs.size(); ++k) {
      const int64_t step = pairs[k].frame - pairs[k - 1].frame;
      if (step > 0 && (stride == 0 || step < stride)) stride = step;
    }
  }
  return stride;
}

}  // namespace

DerivativeResult EvaluateDerivatives(const TrackSequence& truth,
                                     const TrackSequence& tracks,
                                     const DerivativeOptions& options) {
  const Skeleton& skeleton = truth.header.skeleton;
  const JointPairs joints = CommonJoints(skeleton, tracks.header.skeleton);
  std::map<TrackId, std::vector<PersonPair>> people;
  for (const PersonPair& pair :
       PairPeople(truth, tracks, joints, kPersonGateM, options.frames)) {
    people[pair.truth->id].push_back(pair);
  }
  DerivativeResult result;
  std::vector<ScopedSums> of_joint(joints.size());
  ScopedSums of_all;
  for (const JointPair& joint : joints) {
    result.joints.push_back(skeleton.joints()[joint.a]);
  }
  const int64_t stride = StrideOf(people);
  const double rate_hz =
      options.rate_hz / static_cast<double>(std::max<int64_t>(1, stride));
  const int reach = std::max(1, static_cast<int>(std::lround(0.1 * rate_hz)));
  for (const auto& [id, pairs] : people) {
    const std::vector<JointMotion> motions =
        MotionOf(pairs, joints, rate_hz, stride, &result);
    std::vector<bool> at_contact(pairs.size(), false);
    for (size_t j = 0; j < joints.size(); ++j) {
      if (result.joints[j] != "l_ankle" && result.joints[j] != "r_ankle") {
        continue;
      }
      result.contacts +=
          MarkContacts(motions[j], options.up, reach, &at_contact);
    }
    for (int scope = 0; scope < kDerivativeScopes; ++scope) {
      result.velocity_m2_s2[scope].emplace_back(pairs.size());
      result.acceleration_m2_s4[scope].emplace_back(pairs.size());
    }
    for (size_t j = 0; j < joints.size(); ++j) {
      const JointMotion& motion = motions[j];
      for (size_t k = 0; k < pairs.size(); ++k) {
        if (!motion.truth[k].has_value() || !motion.found[k].has_value()) {
          continue;
        }
        const Motion& expected = *motion.truth[k];
        const Motion& found = *motion.found[k];
        for (int scope = 0; scope < kDerivativeScopes; ++scope) {
          if (scope == kContacts && !at_contact[k]) continue;
          of_joint[j][scope].Add(expected, found);
          of_all[scope].Add(expected, found);
          result.velocity_m2_s2[scope].back()[k].Add(
              SquaredVelocityError(expected, found));
          result.acceleration_m2_s4[scope].back()[k].Add(
              SquaredAccelerationError(expected, found));
        }
      }
      AddPeaks(motion, at_contact, rate_hz, {&of_joint[j], &of_all});
    }
  }
  for (int scope = 0; scope < kDerivativeScopes; ++scope) {
    for (const ScopedSums& sums : of_joint) {
      result.by_joint[scope].push_back(sums[scope].Errors());
    }
    result.all[scope] = of_all[scope].Errors();
  }
  return result;
}

}  // namespace kinegraph
