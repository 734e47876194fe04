#include "apps/compare/scores.h"

#include <glog/logging.h>

#include <algorithm>
#include <map>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/evaluation/correspondence.h"
#include "core/evaluation/motion.h"
#include "core/evaluation/mpjpe.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {
namespace {

// Only what two views saw.
TrackSequence ObservedAlone(TrackSequence tracks) {
  for (TrackFrame& frame : tracks.frames) {
    for (PersonPose& person : frame.people) {
      for (Joint3d& joint : person.joints) {
        if (joint.status != JointStatus::kObserved) {
          joint.status = JointStatus::kMissing;
        }
      }
    }
  }
  return tracks;
}

// One series an actor, laid out by the truth.
std::vector<RatioSeries> ErrorSeries(const std::vector<PersonError>& people,
                                     double PersonError::*error) {
  std::map<int64_t, RatioSeries> actors;
  for (const PersonError& person : people) {
    actors[person.actor].push_back(
        {person.*error, static_cast<double>(person.joint_count)});
  }
  std::vector<RatioSeries> series;
  series.reserve(actors.size());
  for (auto& [actor, units] : actors) series.push_back(std::move(units));
  return series;
}

void AddTruth(const Comparison& comparison, const BootstrapOptions& bootstrap,
              StrategyScores* scores) {
  const TrackSequence& tracks = scores->run.tracks;
  MpjpeOptions options;
  options.frames = comparison.scored_frames();
  // In the world of CMU Panoptic y points down.
  const std::string& skeleton = comparison.truth->header.skeleton.name();
  if (skeleton == Panoptic19().name() || skeleton == Panoptic15().name()) {
    options.up = -Eigen::Vector3d::UnitY();
  }
  BootstrapOptions none = bootstrap;
  none.resamples = 1;  // its own intervals are not used
  const MpjpeResult mpjpe =
      EvaluateMpjpe(*comparison.truth, tracks, options, none);
  scores->mpjpe = ErrorSeries(mpjpe.people, &PersonError::raw_m);
  scores->mpjpe_bias_removed =
      ErrorSeries(mpjpe.people, &PersonError::bias_removed_m);
  scores->truth_consistency =
      EvaluateConsistency(*comparison.truth, tracks, options.frames).all;
  if (comparison.protocol.has_value()) {
    scores->pcp = EvaluatePcp(*comparison.truth, tracks, *comparison.protocol);
  }
}

void AddMotion(const Comparison& comparison, StrategyScores* scores) {
  const TrackSequence& alike = scores->run.alike;
  const double rate_hz = comparison.rate_hz();
  scores->acceleration = DifferenceSeries(alike, comparison.people, 2, rate_hz);
  scores->jerk = DifferenceSeries(alike, comparison.people, 3, rate_hz);
  scores->power = PowerSeries(alike, comparison.people, rate_hz);
  BootstrapOptions none;
  none.resamples = 1;
  scores->bone_spread_m =
      EvaluateMotion(ObservedAlone(alike), rate_hz, {}, none)
          .bone_length_spread_m;
  const auto joints = static_cast<int64_t>(alike.header.skeleton.joint_count());
  for (const PersonFrames& person : comparison.people) {
    scores->joints_possible +=
        joints * static_cast<int64_t>(person.frames.size());
  }
  for (const TrackFrame& frame : alike.frames) {
    for (const PersonPose& person : frame.people) {
      scores->joints += CountPresent(person.joints);
    }
  }
}

void AddHeldOut(const Comparison& comparison, const HeldOutScores& held_out,
                StrategyScores* scores) {
  BootstrapOptions bootstrap = comparison.bootstrap();
  // Quantiles cost a walk over all joints a resample.
  constexpr int64_t kMostWork = 400'000'000;
  const auto joints = static_cast<int64_t>(held_out.joints.size());
  bootstrap.resamples = std::clamp<int64_t>(
      kMostWork / std::max<int64_t>(1, joints), 200, bootstrap.resamples);
  scores->held_out = SummariseHeldOut(held_out, AllJoints(), bootstrap);
  scores->held_out_errors = TruncatedErrors(held_out, AllJoints());
  scores->unit_frames = FramesOf(held_out);
  const std::vector<int64_t>& frames = scores->unit_frames;
  for (const HeldOutJoint& joint : held_out.joints) {
    const int64_t frame = held_out.people[joint.person_idx].frame;
    const auto unit = std::lower_bound(frames.begin(), frames.end(), frame);
    scores->joint_units.push_back(static_cast<int32_t>(unit - frames.begin()));
    scores->joint_errors_px.push_back(
        joint.predicted ? static_cast<float>(joint.error_px) : -1.0F);
  }
  for (int c = 0; c < kJointClassCount; ++c) {
    scores->held_out_by_class.push_back(
        TruncatedErrors(held_out, JointsOfClass(static_cast<JointClass>(c))));
  }
  bootstrap.resamples = 1;
  for (size_t view = 0; view < comparison.views().size(); ++view) {
    scores->held_out_by_view.push_back(SummariseHeldOut(
        held_out, JointsOfView(static_cast<int>(view)), bootstrap));
  }
  scores->held_out_consistency = HeldOutConsistency(held_out);
}

// Held-out errors of one camera in every fold, into `parts` [fold, view].
void ScoreView(const Comparison& comparison, const Strategy& strategy,
               const FoldValues& values, size_t view,
               std::vector<HeldOutScores>* parts) {
  const size_t views = comparison.views().size();
  const bool same = SameRun(comparison, values);
  TrackSequence tracks;
  for (size_t fold = 0; fold < comparison.folds.size(); ++fold) {
    const Fold& scored = comparison.folds[fold];
    if (fold == 0 || !same) {
      tracks = RunWithout(comparison, strategy, values[fold], *scored.recording,
                          view);
    }
    ScoreWithout(comparison, scored, view, tracks,
                 &(*parts)[fold * views + view]);
  }
}

}  // namespace

int64_t PiecesOfScoring(const Comparison& comparison, size_t strategies) {
  // Each camera left out, the run with all, and the scores.
  const size_t pieces = comparison.views().size() + 2;
  return static_cast<int64_t>(strategies * pieces);
}

std::vector<StrategyScores> ScoreStrategies(
    const Comparison& comparison, const std::vector<Strategy>& strategies,
    const std::vector<FoldValues>& values, const Tick& tick) {
  CHECK_EQ(values.size(), strategies.size());
  std::vector<StrategyScores> all(strategies.size());
  const size_t views = comparison.views().size();
  const size_t folds = comparison.folds.size();
  const size_t pieces = views + 1;
  // One after the other, so that a strategy's scores do not wait in memory.
  for (size_t s = 0; s < strategies.size(); ++s) {
    StrategyScores& scores = all[s];
    std::vector<HeldOutScores> parts(views * folds);
    try {
      ParallelFor(comparison.threads, static_cast<int>(pieces), [&](int i) {
        const auto piece = static_cast<size_t>(i);
        if (piece == 0) {
          scores.run = RunWithAll(comparison, strategies[s], values[s]);
        } else {
          ScoreView(comparison, strategies[s], values[s], piece - 1, &parts);
        }
        if (tick) tick();
      });
    } catch (const InputError& error) {
      scores.refused = error.what();
      continue;
    } catch (const OptionError& error) {
      scores.refused = error.what();
      continue;
    }
    HeldOutScores held_out;
    for (const HeldOutScores& part : parts) {
      const size_t before = held_out.people.size();
      held_out.people.insert(held_out.people.end(), part.people.begin(),
                             part.people.end());
      for (HeldOutJoint joint : part.joints) {
        joint.person_idx += before;
        held_out.joints.push_back(joint);
      }
    }
    ParallelFor(comparison.threads, 2, [&](int i) {
      if (i == 0) {
        AddHeldOut(comparison, held_out, &scores);
        return;
      }
      AddMotion(comparison, &scores);
      if (comparison.truth.has_value()) {
        AddTruth(comparison, comparison.bootstrap(), &scores);
      }
    });
    scores.run.tracks = TrackSequence();  // its covariances are large
    if (tick) tick();
  }
  return all;
}

void AddCommon(std::vector<StrategyScores*> scores) {
  scores.erase(std::remove_if(scores.begin(), scores.end(),
                              [](const StrategyScores* one) {
                                return !one->refused.empty();
                              }),
               scores.end());
  if (scores.empty()) return;
  const size_t joints = scores.front()->joint_errors_px.size();
  std::vector<char> common(joints, 1);
  for (const StrategyScores* one : scores) {
    CHECK_EQ(one->joint_errors_px.size(), joints);
    for (size_t j = 0; j < joints; ++j) {
      if (one->joint_errors_px[j] < 0.0F) common[j] = 0;
    }
  }
  for (StrategyScores* one : scores) {
    one->held_out_common.assign(one->held_out_errors.size(), RatioUnit());
    std::vector<double> errors_px;
    for (size_t j = 0; j < joints; ++j) {
      if (!common[j]) continue;
      errors_px.push_back(one->joint_errors_px[j]);
      RatioUnit& unit = one->held_out_common[one->joint_units[j]];
      unit.sum +=
          std::min<double>(one->joint_errors_px[j], kHeldOutTruncationPx);
      unit.weight += 1.0;
    }
    one->held_out_common_median_px = Quantile(std::move(errors_px), 0.5);
  }
}

void AddLags(const Comparison& comparison, const TrackSequence& reference,
             StrategyScores* scores) {
  if (!scores->refused.empty()) return;
  const TrackSequence& tracks = scores->run.alike;
  const std::vector<FrameRange> frames = comparison.scored_frames();
  scores->lag_to_batch_s =
      EstimateLag(reference, tracks, comparison.rate_hz(), frames);
  if (!comparison.truth.has_value()) return;
  scores->lag_to_truth_s =
      EstimateLag(*comparison.truth, tracks, comparison.rate_hz(), frames);
}

}  // namespace kinegraph
