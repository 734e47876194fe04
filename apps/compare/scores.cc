#include "apps/compare/scores.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "apps/common/held_out_cameras.h"
#include "apps/common/progress.h"
#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/evaluation/correspondence.h"
#include "core/evaluation/motion.h"
#include "core/evaluation/mpjpe.h"
#include "core/evaluation/statistics.h"
#include "core/kinematics/angles.h"

namespace kinegraph {

// Input of the smoothing balance, common to all strategies.
struct BalanceBasis {
  std::vector<std::vector<JointTraces>> detected, raw;  // [fold][view]
  JointTraces truth;          // relabelled to the tracks' identities and joints
  JointTraces triangulation;  // with all cameras
};

namespace {

// Keeps only observed joints (two or more inlier views).
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

// One series per actor, with a unit for each of the actor's true person-frames.
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

// Errors of the flexion angles that both skeletons define.
std::vector<AngleErrors> FlexionErrors(const Comparison& comparison,
                                       const TrackSequence& tracks) {
  const TrackSequence& truth = *comparison.truth;
  std::vector<std::pair<JointAngle, JointAngle>> angles;
  std::vector<AngleErrors> errors;
  for (const JointAngle& expected : AnglesOf(truth.header.skeleton)) {
    if (expected.name.find("flexion") == std::string::npos) continue;
    for (const JointAngle& found : AnglesOf(tracks.header.skeleton)) {
      if (found.name != expected.name) continue;
      angles.emplace_back(expected, found);
      errors.push_back({expected.name, {}});
    }
  }
  std::map<int64_t, std::vector<RatioSeries>> actors;
  const JointPairs joints =
      CommonJoints(truth.header.skeleton, tracks.header.skeleton);
  for (const PersonPair& pair : PairPeople(truth, tracks, joints, kPersonGateM,
                                           comparison.scored_frames())) {
    std::vector<RatioSeries>& series = actors[pair.truth->id.value()];
    series.resize(angles.size());
    for (size_t a = 0; a < angles.size(); ++a) {
      RatioUnit& unit = series[a].emplace_back();
      if (pair.found == nullptr) continue;
      const auto expected =
          MeasureAngle(angles[a].first, *pair.truth, comparison.up);
      const auto found =
          MeasureAngle(angles[a].second, *pair.found, comparison.up);
      if (!expected.has_value() || !found.has_value()) continue;
      const double turn = std::remainder(found->deg - expected->deg, 360.0);
      unit = {turn * turn, 1.0};
    }
  }
  for (auto& [actor, series] : actors) {
    for (size_t a = 0; a < angles.size(); ++a) {
      errors[a].squared_deg2.push_back(std::move(series[a]));
    }
  }
  return errors;
}

void AddTruth(const Comparison& comparison, const BootstrapOptions& bootstrap,
              StrategyScores* scores) {
  const TrackSequence& tracks = scores->run.tracks;
  MpjpeOptions options;
  options.frames = comparison.scored_frames();
  options.up = comparison.up;
  BootstrapOptions none = bootstrap;
  none.resamples = 1;  // these intervals are not used
  const MpjpeResult mpjpe =
      EvaluateMpjpe(*comparison.truth, tracks, options, none);
  scores->mpjpe = ErrorSeries(mpjpe.people, &PersonError::raw_m);
  scores->mpjpe_bias_removed =
      ErrorSeries(mpjpe.people, &PersonError::bias_removed_m);
  scores->truth_consistency =
      EvaluateConsistency(*comparison.truth, tracks, options.frames).all;
  scores->derivatives =
      EvaluateDerivatives(*comparison.truth, tracks,
                          {comparison.rate_hz(), options.frames, options.up});
  if (comparison.angles) scores->angles = FlexionErrors(comparison, tracks);
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
  // Quantiles cost a pass over all joints per resample.
  constexpr int64_t kMostWork = 400'000'000;  // joints times resamples
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

// Appends the held-out errors of one camera in each fold to `parts` (at index
// fold * views + view) and, with a `balance`, adds the camera's spectra.
void ScoreView(const Comparison& comparison, const Strategy& strategy,
               const FoldValues& values, size_t view,
               const BalanceBasis* balance, std::vector<HeldOutScores>* parts,
               SmoothingSpectra* spectra) {
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
    if (balance == nullptr) continue;
    spectra->Add(
        balance->detected[fold][view], balance->raw[fold][view],
        ImageTraces(tracks, comparison.scene().cameras[view], {scored.frames}),
        static_cast<int>(view));
  }
}

std::vector<SmoothingBalance> BalanceOf(const Comparison& comparison,
                                        const SmoothingSpectra& spectra,
                                        double metres) {
  std::vector<SmoothingBalance> joints;
  for (int j = 0; j < comparison.scene().skeleton.joint_count(); ++j) {
    SmoothingBalance one = spectra.OfJoint(j);
    one.error_m *= metres;
    one.removed_m *= metres;
    one.kept_m *= metres;
    one.attainable_m *= metres;
    joints.push_back(one);
  }
  return joints;
}

void AddBalance(const Comparison& comparison, const BalanceBasis& basis,
                std::vector<SmoothingSpectra> views, StrategyScores* scores) {
  for (size_t view = 1; view < views.size(); ++view) {
    views.front().Merge(views[view]);
  }
  scores->balance =
      BalanceOf(comparison, views.front(), comparison.run.scale.metres());
  if (!comparison.truth.has_value()) return;
  SmoothingSpectra of_truth(comparison.rate_hz());
  of_truth.Add(basis.truth, basis.triangulation,
               WorldTraces(scores->run.alike, {}), std::nullopt);
  scores->truth_balance = BalanceOf(comparison, of_truth, 1.0);
}

// The truth with the identities and joints of the tracks paired with it.
TrackSequence TruthAsTracked(const Comparison& comparison,
                             const TrackSequence& tracks) {
  const JointPairs joints =
      CommonJoints(comparison.truth->header.skeleton, tracks.header.skeleton);
  TrackSequence truth;
  truth.header = tracks.header;
  for (const PersonPair& pair :
       PairPeople(*comparison.truth, tracks, joints, kPersonGateM,
                  comparison.scored_frames())) {
    if (pair.found == nullptr) continue;
    if (truth.frames.empty() || truth.frames.back().frame != pair.frame) {
      truth.frames.emplace_back().frame = pair.frame;
    }
    PersonPose& person = truth.frames.back().people.emplace_back();
    person.id = pair.found->id;
    person.joints.resize(tracks.header.skeleton.joint_count());
    for (const JointPair& joint : joints) {
      person.joints[joint.b] = pair.truth->joints[joint.a];
    }
  }
  return truth;
}

constexpr double kMmPerM = 1000.0;

// Square root of the pooled mean of series of squares.
double RootOfRatio(const std::vector<RatioSeries>& series,
                   const DrawCounts* counts) {
  return std::sqrt(PooledRatio(series, counts));
}

Interval Scaled(Interval interval, double factor) {
  interval.low *= factor;
  interval.high *= factor;
  interval.standard_error *= factor;
  return interval;
}

// Builds the measures of one strategy against the baseline.
class MeasureList {
 public:
  MeasureList(const BootstrapOptions& bootstrap, bool is_baseline)
      : bootstrap_(bootstrap), is_baseline_(is_baseline) {}

  void Plain(Measure measure, double value) {
    measure.value = value;
    measures_.push_back(std::move(measure));
  }

  // A pooled ratio of series.
  void Ratio(Measure measure, const std::vector<RatioSeries>& own,
             const std::vector<RatioSeries>& baseline, double factor = 1.0) {
    Ratio(std::move(measure), own, baseline, factor, bootstrap_);
  }
  void Ratio(Measure measure, const std::vector<RatioSeries>& own,
             const std::vector<RatioSeries>& baseline, double factor,
             const BootstrapOptions& bootstrap,
             RatioScore score = PooledRatio) {
    measure.value = factor * score(own, nullptr);
    if (!std::isnan(measure.value)) {
      measure.interval = Scaled(RatioInterval(score, own, bootstrap), factor);
      measure.difference = measure.value - factor * score(baseline, nullptr);
      if (!is_baseline_ && !std::isnan(measure.difference)) {
        measure.difference_interval =
            Scaled(PairedInterval(score, own, baseline, bootstrap), factor);
      }
    }
    measure.verdict = VerdictOf(measure.difference_interval);
    measures_.push_back(std::move(measure));
  }

  // The square root of the pooled ratio of series of squares.
  void Root(Measure measure, const std::vector<RatioSeries>& own,
            const std::vector<RatioSeries>& baseline) {
    Ratio(std::move(measure), own, baseline, 1.0, bootstrap_, RootOfRatio);
  }

  void Pcp(Measure measure, const PcpResult& own, const PcpResult& baseline) {
    constexpr PcpGroup kAll = PcpGroup::kTotal;
    measure.less_is_better = false;
    measure.value = MeanOfActors(own, kAll);
    measure.interval = MeanOfActorsInterval(own, kAll, bootstrap_);
    measure.difference = measure.value - MeanOfActors(baseline, kAll);
    if (!is_baseline_) {
      measure.difference_interval =
          MeanOfActorsDifference(own, baseline, kAll, bootstrap_);
    }
    measure.verdict = VerdictOf(measure.difference_interval);
    measures_.push_back(std::move(measure));
  }

  std::vector<Measure> Take() { return std::move(measures_); }

 private:
  BootstrapOptions bootstrap_;
  bool is_baseline_;
  std::vector<Measure> measures_;
};

void AddHeldOutMeasures(const StrategyScores& own,
                        const StrategyScores& baseline, MeasureList* list) {
  list->Ratio({kHeldOut, "held-out error, mean of min(error, 30 px)", "px", 2},
              {own.held_out_errors}, {baseline.held_out_errors});
  list->Ratio(
      {"held_out_common_px",
       "held-out error of the joints that every strategy predicts", "px", 2},
      {own.held_out_common}, {baseline.held_out_common});
  list->Plain(
      {"held_out_common_median_px",
       "held-out error of the joints that every strategy predicts, median",
       "px", 2},
      own.held_out_common_median_px);
  for (const auto& [figure, key, title] :
       {std::tuple{HeldOutFigure::kMedian, "median", "median"},
        {HeldOutFigure::kP90, "p90", "90th percentile"},
        {HeldOutFigure::kP97, "p97", "97th percentile"}}) {
    Measure measure = {std::string("held_out_") + key + "_px",
                       std::string("held-out error, ") + title, "px", 2};
    measure.interval = own.held_out.intervals_px[static_cast<int>(figure)];
    list->Plain(std::move(measure), own.held_out.figure_px(figure));
  }
  list->Plain({"predicted_percent", "joints predicted", "%", 1},
              own.held_out.predicted.percent());
  for (int c = 0; c < kJointClassCount; ++c) {
    const std::string name = ToString(static_cast<JointClass>(c));
    list->Ratio(
        {"held_out_" + name + "_px", "held-out error, " + name, "px", 2},
        {own.held_out_by_class[c]}, {baseline.held_out_by_class[c]});
  }
}

void AddMotionMeasures(const StrategyScores& own,
                       const StrategyScores& baseline,
                       const BootstrapOptions& bootstrap, MeasureList* list) {
  list->Ratio({"acceleration_m_s2", "acceleration", "m/s^2", 2},
              own.acceleration, baseline.acceleration);
  list->Ratio({"jerk_m_s3", "jerk", "m/s^3", 1}, own.jerk, baseline.jerk);
  // A RatioUnit of PowerSeries is a segment of two seconds, and successive
  // segments overlap by half: a block is two of them.
  BootstrapOptions segments = bootstrap;
  segments.block_length = 2;
  list->Ratio({"power_above_6hz_mm2", "power above 6 Hz", "mm^2", 2}, own.power,
              baseline.power, kMmPerM * kMmPerM, segments);
  list->Plain({"bone_spread_mm", "bone-length spread", "mm", 1},
              kMmPerM * own.bone_spread_m);
  list->Plain({"joints_given_percent", "joints with a position", "%", 1},
              own.joints_possible == 0
                  ? kNan
                  : 100.0 * static_cast<double>(own.joints) /
                        static_cast<double>(own.joints_possible));
  list->Plain({"lag_to_batch_ms", "lag behind batch", "ms", 0},
              1e3 * own.lag_to_batch_s.value_or(kNan));
  // 0: final at once. NaN: final at the end of the recording.
  list->Plain(
      {"final_after_ms", "delay until a pose is final", "ms", 0},
      own.run.delay.has_value() ? 1e3 * ToSeconds(*own.run.delay) : kNan);
}

void AddDerivativeMeasures(const DerivativeResult& own,
                           const DerivativeResult& baseline,
                           MeasureList* list) {
  for (int scope = 0; scope < kDerivativeScopes; ++scope) {
    const std::string key = scope == 0 ? "" : "contact_";
    const std::string where = scope == 0 ? "" : ", around contacts";
    const DerivativeErrors& all = own.all[scope];
    list->Root(
        {key + "velocity_rms_m_s", "velocity error, RMS" + where, "m/s", 3},
        own.velocity_m2_s2[scope], baseline.velocity_m2_s2[scope]);
    list->Plain({key + "speed_bias_m_s", "speed, bias" + where, "m/s", 3},
                all.speed_bias_m_s);
    list->Root({key + "acceleration_rms_m_s2",
                "acceleration error, RMS" + where, "m/s^2", 2},
               own.acceleration_m2_s4[scope],
               baseline.acceleration_m2_s4[scope]);
    list->Plain({key + "acceleration_bias_m_s2",
                 "magnitude of acceleration, bias" + where, "m/s^2", 2},
                all.acceleration_bias_m_s2);
    list->Plain({key + "peak_acceleration_error_percent",
                 "peak acceleration, relative error" + where, "%", 1},
                all.peak_error_percent);
    list->Plain(
        {key + "peak_instant_ms",
         "time of peak acceleration, mean absolute error" + where, "ms", 1},
        all.peak_instant_ms);
  }
}

void AddAngleMeasures(const std::vector<AngleErrors>& own,
                      const std::vector<AngleErrors>& baseline,
                      MeasureList* list) {
  std::vector<RatioSeries> own_all;
  std::vector<RatioSeries> baseline_all;
  for (size_t a = 0; a < own.size(); ++a) {
    const auto& mine = own[a].squared_deg2;
    const auto& other = baseline[a].squared_deg2;
    list->Root({own[a].name + "_rms_deg", own[a].name + ", RMS", "deg", 2},
               mine, other);
    own_all.insert(own_all.end(), mine.begin(), mine.end());
    baseline_all.insert(baseline_all.end(), other.begin(), other.end());
  }
  list->Root({"flexion_rms_deg", "all flexions, RMS", "deg", 2}, own_all,
             baseline_all);
}

void AddBalanceMeasures(const std::vector<SmoothingBalance>& joints,
                        const std::string& prefix, const std::string& by,
                        MeasureList* list) {
  const SmoothingBalance all = PooledBalance(joints);
  for (const auto& [key, title, value_m] :
       {std::tuple{"motion_error_mm", "error of motion, segments of 1 s, RMS",
                   all.error_m},
        {"motion_removed_mm", "motion removed or delayed", all.removed_m},
        {"noise_kept_mm", "noise kept", all.kept_m},
        {"attainable_error_mm", "attainable error of motion (Wiener filter)",
         all.attainable_m}}) {
    list->Plain({prefix + key, std::string(title) + by, "mm", 1},
                kMmPerM * value_m);
  }
}

void AddTruthMeasures(const StrategyScores& own, const StrategyScores& baseline,
                      MeasureList* list) {
  list->Ratio({"mpjpe_mm", "MPJPE", "mm", 1}, own.mpjpe, baseline.mpjpe,
              kMmPerM);
  list->Ratio({"mpjpe_bias_removed_mm", "MPJPE, bias removed", "mm", 1},
              own.mpjpe_bias_removed, baseline.mpjpe_bias_removed, kMmPerM);
  if (own.pcp.has_value() && baseline.pcp.has_value()) {
    list->Pcp({"pcp_percent", "PCP", "%", 2}, *own.pcp, *baseline.pcp);
  }
  list->Plain({"lag_to_truth_ms", "lag behind the truth", "ms", 0},
              1e3 * own.lag_to_truth_s.value_or(kNan));
  list->Plain(
      {"truth_covered_percent", "true joints in the 95 % ellipsoid", "%", 1},
      own.truth_consistency.covered.percent());
  list->Plain(
      {"truth_nees_per_dof", "NEES per degree of freedom, truth", "", 2},
      own.truth_consistency.nees_per_dof);
  AddBalanceMeasures(own.truth_balance, "truth_",
                     ", measured against the truth", list);
  AddDerivativeMeasures(*own.derivatives, *baseline.derivatives, list);
  if (!own.angles.empty()) AddAngleMeasures(own.angles, baseline.angles, list);
}

std::vector<Measure> MeasuresOf(const Comparison& comparison,
                                const StrategyScores& own,
                                const StrategyScores& baseline) {
  const bool is_baseline = &own == &baseline;
  const BootstrapOptions bootstrap = comparison.bootstrap();
  MeasureList list(bootstrap, is_baseline);
  AddHeldOutMeasures(own, baseline, &list);
  AddMotionMeasures(own, baseline, bootstrap, &list);
  AddBalanceMeasures(own.balance, "", "", &list);
  list.Plain({"held_out_covered_percent", "held-out joints in the 95 % ellipse",
              "%", 1},
             own.held_out_consistency.covered.percent());
  list.Plain(
      {"held_out_nees_per_dof", "NEES per degree of freedom, held-out", "", 2},
      own.held_out_consistency.nees_per_dof);
  if (comparison.truth.has_value()) AddTruthMeasures(own, baseline, &list);
  return list.Take();
}

// Distances between the joints observed in both `a` and `b` [m], in the order
// of frames.
std::vector<double> Distances(const TrackSequence& a, const TrackSequence& b) {
  std::vector<double> distances;
  for (const TrackFrame& frame : a.frames) {
    const TrackFrame* other = FindFrame(b, frame.frame);
    if (other == nullptr) continue;
    for (const PersonPose& person : frame.people) {
      const auto same = std::find_if(
          other->people.begin(), other->people.end(),
          [&person](const PersonPose& one) { return one.id == person.id; });
      if (same == other->people.end()) continue;
      for (size_t j = 0; j < person.joints.size(); ++j) {
        if (person.joints[j].status != JointStatus::kObserved ||
            same->joints[j].status != JointStatus::kObserved) {
          continue;
        }
        distances.push_back(
            (person.joints[j].position_m - same->joints[j].position_m).norm());
      }
    }
  }
  return distances;
}

void AddLagSweep(CompareResult* result) {
  const auto batch =
      std::find_if(result->strategies.begin(), result->strategies.end(),
                   [](const StrategyResult& one) {
                     return one.strategy.name == kOfflineReference && one.ran();
                   });
  if (batch == result->strategies.end()) return;
  for (size_t s = 0; s < result->strategies.size(); ++s) {
    const StrategyResult& one = result->strategies[s];
    if (one.strategy.lag_frames < 0 || !one.ran()) continue;
    const std::vector<double> distances =
        Distances(one.scores.run.alike, batch->scores.run.alike);
    result->lag_sweep.push_back(
        {s, one.strategy.lag_frames, Quantile(distances, 0.5),
         Quantile(distances, 0.95), Quantile(distances, 0.99)});
  }
}

// StrategyRun::alike of the named strategy, which is run with its default
// values if it was not requested or was refused; empty if it is refused with
// these.
TrackSequence AlikeOf(const std::string& name, const Comparison& comparison,
                      const std::vector<Strategy>& strategies,
                      const std::vector<StrategyScores>& scores) {
  const size_t at = IndexOf(strategies, name);
  if (at < strategies.size() && scores[at].refused.empty()) {
    return scores[at].run.alike;
  }
  const Strategy strategy = ChooseStrategies({name}).front();
  const StrategyValues defaults = DefaultValues(strategy, comparison.rate_hz(),
                                                comparison.options.estimators);
  TrackSequence alike;
  RefusalOf([&] {
    alike = RunWithAll(comparison, strategy,
                       FoldValues(comparison.folds.size(), defaults))
                .alike;
  });
  return alike;
}

// Lags relative to the truth and to `reference`, if there are any.
void AddLags(const Comparison& comparison, const TrackSequence& reference,
             StrategyScores* scores) {
  if (!scores->refused.empty()) return;
  const TrackSequence& tracks = scores->run.alike;
  const std::vector<FrameRange> frames = comparison.scored_frames();
  if (!reference.frames.empty()) {
    scores->lag_to_batch_s =
        EstimateLag(reference, tracks, comparison.rate_hz(), frames);
  }
  if (!comparison.truth.has_value()) return;
  scores->lag_to_truth_s =
      EstimateLag(*comparison.truth, tracks, comparison.rate_hz(), frames);
}

BalanceBasis MakeBalanceBasis(const Comparison& comparison) {
  const Strategy raw = ChooseStrategies({"raw_dlt"}).front();
  const StrategyValues values =
      DefaultValues(raw, comparison.rate_hz(), comparison.options.estimators);
  const auto views = static_cast<int>(comparison.views().size());
  BalanceBasis basis;
  basis.detected.resize(comparison.folds.size());
  basis.raw.resize(comparison.folds.size());
  for (size_t f = 0; f < comparison.folds.size(); ++f) {
    const Fold& fold = comparison.folds[f];
    const HeldOutSet set = PartIn({fold.frames}, comparison.set);
    basis.detected[f].resize(comparison.views().size());
    basis.raw[f].resize(comparison.views().size());
    ParallelFor(comparison.threads, views, [&](int view) {
      basis.detected[f][view] = DetectedTraces(
          set, fold.recording->detections, view, comparison.scene().skeleton);
      basis.raw[f][view] = ImageTraces(
          RunWithout(comparison, raw, values, *fold.recording, view),
          comparison.scene().cameras[view], {fold.frames});
    });
  }
  if (!comparison.truth.has_value()) return basis;
  const TrackSequence tracks =
      RunWithAll(comparison, raw, FoldValues(comparison.folds.size(), values))
          .alike;
  basis.triangulation = WorldTraces(tracks, {});
  basis.truth = WorldTraces(TruthAsTracked(comparison, tracks), {});
  return basis;
}

}  // namespace

std::vector<StrategyScores> ScoreStrategies(
    const Comparison& comparison, const std::vector<Strategy>& strategies,
    const std::vector<FoldValues>& values, const std::string& what,
    const BalanceBasis* balance) {
  CHECK_EQ(values.size(), strategies.size());
  std::vector<StrategyScores> all(strategies.size());
  const size_t views = comparison.views().size();
  const size_t folds = comparison.folds.size();
  // Work items of a strategy: its runs without each camera in turn, and those
  // with all cameras.
  const size_t pieces = views + 1;
  // Scoring counts as one more step.
  Progress progress(what,
                    static_cast<int64_t>(strategies.size() * (pieces + 1)));
  // One strategy at a time, so that the tracks with covariances and the
  // HeldOutScores of only one are in memory.
  for (size_t s = 0; s < strategies.size(); ++s) {
    StrategyScores& scores = all[s];
    std::vector<HeldOutScores> parts(views * folds);
    std::vector<SmoothingSpectra> spectra(
        views, SmoothingSpectra(comparison.rate_hz()));
    scores.refused = RefusalOf([&] {
      ParallelFor(comparison.threads, static_cast<int>(pieces), [&](int i) {
        const auto piece = static_cast<size_t>(i);
        if (piece == 0) {
          scores.run = RunWithAll(comparison, strategies[s], values[s]);
        } else {
          ScoreView(comparison, strategies[s], values[s], piece - 1, balance,
                    &parts, &spectra[piece - 1]);
        }
        progress.Advance();
      });
    });
    if (!scores.refused.empty()) continue;
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
        if (balance != nullptr) {
          AddBalance(comparison, *balance, std::move(spectra), &scores);
        }
        return;
      }
      AddMotion(comparison, &scores);
      if (comparison.truth.has_value()) {
        AddTruth(comparison, comparison.bootstrap(), &scores);
      }
    });
    scores.run.tracks = TrackSequence();  // its covariances are large
    progress.Advance();
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

const char* ToString(Verdict verdict) {
  constexpr const char* kNames[] = {"-", "not significant", "less", "more"};
  return kNames[static_cast<int>(verdict)];
}

const Measure* StrategyResult::Find(const std::string& key) const {
  for (const Measure& measure : measures) {
    if (measure.key == key) return &measure;
  }
  return nullptr;
}

std::vector<const StrategyResult*> CompareResult::Ran() const {
  std::vector<const StrategyResult*> ran;
  for (const StrategyResult& one : strategies) {
    if (one.ran()) ran.push_back(&one);
  }
  return ran;
}

Verdict VerdictOf(const Interval& difference) {
  if (std::isnan(difference.low) || std::isnan(difference.high)) {
    return Verdict::kNone;
  }
  if (difference.high < 0.0) return Verdict::kLess;
  if (difference.low > 0.0) return Verdict::kMore;
  return Verdict::kSame;
}

void Score(CompareResult* result) {
  const Comparison& comparison = result->comparison;
  std::vector<Strategy> strategies;
  std::vector<FoldValues> values;
  for (const StrategyResult& one : result->strategies) {
    strategies.push_back(one.strategy);
    values.push_back(one.values);
  }
  const BalanceBasis basis = MakeBalanceBasis(comparison);
  std::vector<StrategyScores> scores =
      ScoreStrategies(comparison, strategies, values, "scoring", &basis);
  const StrategyScores& baseline = scores[result->baseline_idx];
  if (!baseline.refused.empty()) {
    throw InputError("--baseline=" + result->baseline().strategy.name + ": " +
                     baseline.refused);
  }
  const TrackSequence reference =
      AlikeOf(kOfflineReference, comparison, strategies, scores);
  const bool robust =
      comparison.options.estimators.filters.points == PointKind::kRobust;
  result->points = AlikeOf(robust ? "robust_triangulation" : "raw_dlt",
                           comparison, strategies, scores);
  for (size_t s = 0; s < strategies.size(); ++s) {
    AddLags(comparison, reference, &scores[s]);
    result->strategies[s].scores = std::move(scores[s]);
  }
  AddMeasures(result);
}

void AddMeasures(CompareResult* result) {
  std::vector<StrategyScores*> scores;
  for (StrategyResult& one : result->strategies) scores.push_back(&one.scores);
  AddCommon(std::move(scores));
  const StrategyScores& baseline = result->baseline().scores;
  ParallelFor(result->comparison.threads,
              static_cast<int>(result->strategies.size()), [&](int s) {
                StrategyResult& one = result->strategies[s];
                if (!one.ran()) return;
                one.measures =
                    MeasuresOf(result->comparison, one.scores, baseline);
              });
  AddLagSweep(result);
}

}  // namespace kinegraph
