#include "solvers/rig/rig.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/random.h"
#include "core/base/text.h"
#include "core/geometry/lens.h"
#include "core/skeleton/body_joints.h"
#include "solvers/cameras/fit_error.h"
#include "solvers/cameras/refine.h"
#include "solvers/cameras/segments.h"
#include "solvers/rig/rig_start.h"
#include "solvers/scene/clock_search.h"
#include "solvers/scene/hypothesis.h"
#include "solvers/scene/view_agreement.h"

namespace kinegraph {
namespace {

constexpr double kStatureM = 1.7;
// Standard deviation [m], per axis, of a detector's persistent error of one
// joint of one person in one view, for people 1.7 m tall. For OpenPose's joints
// the median distance, 1.18 sigma, is 6 to 14 mm. If errors are larger, only
// the weights of the fit depend on this value: the covariance uses the variance
// estimated from the recording (ReducedSystem::AddPrior).
constexpr double kLastingOffsetM = 0.007;
// For people, factor on the fit's variances, which assume independent motion
// segments with equal noise; accounts for outliers, heavy tails and occluded
// joints.
constexpr double kUnmodelled = 2.5;
// Largest sigmas of a calibrated view: in degrees, and as a fraction of the
// rig's size.
constexpr double kMostRotationDeg = 0.8;
constexpr double kMostPlace = 0.025;
// Upper bounds on errors that the verdict `calibrated` promises for all views,
// and the minimum probability that they hold.
constexpr double kPromisedDeg = 0.3;
constexpr double kPromisedPlace = 0.01;
constexpr double kLeastLikely = 0.8;
// Largest sigma [s] of a clock that is reported.
constexpr double kMostClockS = 0.02;
// Standard deviation of a uniform distribution over one frame interval: 1 /
// sqrt(12).
constexpr double kOfAFrame = 0.29;
// Largest difference between fits to halves of the joints, in units of the
// limits above.
constexpr double kMostApart = 2.0;
// People whose positions spread less than this stay in one place (the same
// limit as in `doctor`, a fifth of a stature).
constexpr double kOneSpotM = 0.34;
// Sigma of principal points about the given ones, as a fraction of the image's
// width.
constexpr double kShiftShare = 0.015;
// Sigma of the logarithm of an unknown focal length, for fields of view of 40
// to 90 degrees.
constexpr double kFocalUnknown = 0.3;
// Sigma of k1 and of k2 about the given ones, for telephoto to wide-angle
// lenses.
constexpr double kLensSigma = 0.2;
// If clocks are not determined, lags that differ from the first view's by at
// most this many frames are set equal to it.
constexpr int kNearFrames = 2;
// Sigma of the clock drift of cameras [s/s].
constexpr double kDriftSigma = 2e-4;
// Sigma of the capture times given in files [s].
constexpr double kTimeSigmaS = 0.02;
constexpr double kLongestDeviationS = 0.1;  // largest error searched
// Number of motion segments in the first rounds of matching and fitting.
constexpr int kFewSegments = 500;
// Iterations of a fit. Each halves the error: after 8 it is below a hundredth
// of the first step; in the first rounds, which are repeated with better
// matches, a tenth suffices.
constexpr int kFitIterations = 8;
constexpr int kRoundIterations = 5;
// Minimum agreement of a view, relative to the median view and absolute; below
// these its pose is wrong.
constexpr double kLeastOfUsual = 0.8;
constexpr double kLeastAgreement = 0.5;

// Greatest common divisor of the steps between frame numbers: n if a detector
// ran on every n-th frame.
int64_t NumberStep(const std::vector<DetectionFrame>& frames) {
  int64_t step = 0;
  for (const DetectionFrame& frame : frames) {
    step = std::gcd(step, frame.frame - frames.front().frame);
  }
  return std::max<int64_t>(1, step);
}

// Refuses recordings with so many missing frames, each of which is stored, that
// their frame numbers are probably wrong.
void CheckGaps(const std::vector<DetectionFrame>& frames, int64_t step) {
  constexpr int64_t kMostMissing = 1'000'000;
  int64_t widest = 0;
  size_t after = 0;
  for (size_t k = 1; k < frames.size(); ++k) {
    const int64_t gap = frames[k].frame - frames[k - 1].frame;
    if (gap <= widest) continue;
    widest = gap;
    after = k;
  }
  const int64_t all = (frames.back().frame - frames.front().frame) / step + 1;
  if (all - static_cast<int64_t>(frames.size()) <= kMostMissing) return;
  throw InputError(fmt::format(
      "--detections: frame {} is followed by frame {}, expected at most {} "
      "missing frames in a recording: calibrate the parts before and after "
      "separately",
      frames[after - 1].frame, frames[after].frame, kMostMissing));
}

// The recording with every NumberStep-th frame number from the first to the
// last, numbered consecutively, at nominal times, which replace the capture
// times. `late_s`: mean difference of each view's capture times from the
// nominal times.
DetectionSequence Regular(DetectionSequence detections,
                          std::vector<double>* late_s) {
  DetectionSequence recording;
  recording.header = detections.header;
  const int64_t step = NumberStep(detections.frames);
  CheckGaps(detections.frames, step);
  recording.header.frame_rate_hz /= static_cast<double>(step);
  const double beat_s = 1.0 / recording.header.frame_rate_hz;
  const int64_t first = detections.frames.front().frame;
  const TimeNs zero = detections.frames.front().time;
  late_s->assign(recording.header.view_names.size(), 0.0);
  for (DetectionFrame& frame : detections.frames) {
    frame.frame = (frame.frame - first) / step;
    while (static_cast<int64_t>(recording.frames.size()) < frame.frame) {
      DetectionFrame empty;
      empty.frame = static_cast<int64_t>(recording.frames.size());
      empty.views.resize(frame.views.size());
      recording.frames.push_back(std::move(empty));
    }
    const double regular_s = static_cast<double>(frame.frame) * beat_s;
    for (size_t v = 0; v < frame.views.size(); ++v) {
      (*late_s)[v] +=
          (ToSeconds(frame.views[v].capture_time - zero) - regular_s) /
          static_cast<double>(detections.frames.size());
    }
    recording.frames.push_back(std::move(frame));
  }
  for (DetectionFrame& frame : recording.frames) {
    frame.time = FromSeconds(static_cast<double>(frame.frame) * beat_s);
    for (ViewDetections& view : frame.views) view.capture_time = frame.time;
  }
  return recording;
}

// Whether any capture time differs from its frame's time.
bool HasTimes(const DetectionSequence& detections) {
  return std::any_of(detections.frames.begin(), detections.frames.end(),
                     [](const DetectionFrame& frame) {
                       return std::any_of(
                           frame.views.begin(), frame.views.end(),
                           [&](const ViewDetections& view) {
                             return view.capture_time != frame.time;
                           });
                     });
}

// k1 and k2 of the lens; 0 without a lens.
Eigen::Vector2d RadialOf(const Camera& camera) {
  if (camera.lens() == nullptr) return Eigen::Vector2d::Zero();
  const std::vector<double> terms = camera.lens()->parameters();
  return {terms[0], terms[1]};
}

// Twice the rms distance of the cameras from their centroid.
double SizeOf(const CameraRig& cameras) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  const auto count = static_cast<double>(cameras.size());
  for (const Camera& camera : cameras) middle += camera.centre() / count;
  double squares = 0.0;
  for (const Camera& camera : cameras) {
    squares += (camera.centre() - middle).squaredNorm() / count;
  }
  return 2.0 * std::sqrt(squares);
}

// Probability that all views keep the error bounds that `calibrated` promises:
// the fraction of draws from the covariance that keep them.
double LikelyRight(const Eigen::MatrixXd& covariance,
                   const std::vector<std::vector<int>>& of_views,
                   double size_m) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance);
  const Eigen::MatrixXd root =
      solver.eigenvectors() *
      solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  constexpr int kDraws = 2000;
  Random random(1);
  Eigen::VectorXd normal(root.cols());
  int right = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    for (double& one : normal) one = random.Normal(0.0, 1.0);
    const Eigen::VectorXd error = root * normal;
    Eigen::Index at = 0;
    bool within = true;
    for (const auto& places : of_views) {
      within =
          within && kDegPerRad * error.segment<3>(at).norm() <= kPromisedDeg &&
          error.segment<3>(at + kCentreAt).norm() <= kPromisedPlace * size_m;
      at += static_cast<Eigen::Index>(places.size());
    }
    right += within ? 1 : 0;
  }
  return static_cast<double>(right) / kDraws;
}

bool IsOfLens(int place) { return place == kLensAt || place == kLensK2At; }

// The conditional covariance of the other parameters given principal points and
// lenses, whose rows and columns are 0.
Eigen::MatrixXd GivenLenses(const Eigen::MatrixXd& covariance,
                            const std::vector<std::vector<int>>& of_views) {
  std::vector<Eigen::Index> lenses;
  Eigen::Index at = 0;
  for (const auto& places : of_views) {
    for (const int place : places) {
      if (place == kShiftAt || place == kShiftAt + 1 || IsOfLens(place)) {
        lenses.push_back(at);
      }
      ++at;
    }
  }
  if (lenses.empty()) return covariance;
  const Eigen::MatrixXd cross = covariance(Eigen::all, lenses);
  Eigen::MatrixXd given =
      covariance -
      cross * covariance(lenses, lenses).ldlt().solve(cross.transpose());
  given(Eigen::all, lenses).setZero();
  given(lenses, Eigen::all).setZero();
  return given;
}

// Removes k1 and k2, which the calibration record does not contain. What
// remains is the marginal covariance, which includes their uncertainty.
void DropLens(std::vector<std::vector<int>>* of_views,
              Eigen::MatrixXd* covariance) {
  std::vector<Eigen::Index> kept;
  Eigen::Index at = 0;
  for (auto& places : *of_views) {
    for (const int place : places) {
      if (!IsOfLens(place)) kept.push_back(at);
      ++at;
    }
    places.erase(std::remove_if(places.begin(), places.end(), IsOfLens),
                 places.end());
  }
  *covariance = Eigen::MatrixXd((*covariance)(kept, kept));
}

// Largest standard deviation of three parameters in any direction.
double Spread(const Eigen::MatrixXd& covariance, Eigen::Index begin) {
  const Eigen::Matrix3d block = covariance.block<3, 3>(begin, begin);
  return std::sqrt(std::max(
      0.0,
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(block).eigenvalues()[2]));
}

// Residuals of one view in standard deviations, each capped at 10: sum and
// number by time bin.
using ViewResiduals = std::map<int64_t, std::pair<double, int>>;

// Distance [sigmas], capped at 10, of a joint from the nearest detection of
// this joint in the given frame of a view; nullopt if it is not detected or
// cannot be projected into the view.
std::optional<double> NearestOff(const Camera& camera,
                                 const MotionSegment& segment,
                                 const SegmentState& state, int view,
                                 const DetectionFrame& frame, TimeNs middle,
                                 double noise_scale) {
  constexpr double kMostOff = 10.0;
  SegmentMeasurement one = segment.measurements.front();
  one.view_idx = view;
  std::optional<double> nearest;
  for (const Detection& person : frame.views[view].detections) {
    const Keypoint& joint = person.joints[segment.joint];
    if (!joint.found) continue;
    one.px = joint.px;
    one.time_s = ToSeconds(frame.views[view].capture_time - middle);
    const auto r = SegmentResidual(camera, CameraChange::Zero(), segment, state,
                                   one, noise_scale);
    if (!r.has_value()) return std::nullopt;
    nearest = std::min({kMostOff, r->norm(), nearest.value_or(kMostOff)});
  }
  return nearest;
}

// Residuals of each view, or of view `only`: distances between the joints
// triangulated from the other views and the nearest detected joint, regardless
// of matches, because people in a view that moved remain unmatched.
std::vector<ViewResiduals> ResidualsBeside(
    const CameraRig& cameras, const DetectionSequence& aligned,
    const SceneSegments& segments, const SegmentOptions& options,
    std::optional<size_t> only = std::nullopt) {
  const std::vector<CameraChange> none = NoChanges(cameras.size());
  const TimeNs first = aligned.frames.front().time;
  const TimeNs middle = first + (aligned.frames.back().time - first) / 2;
  std::vector<ViewResiduals> views(cameras.size());
  for (const MotionSegment& segment : segments.segments) {
    const auto bin = static_cast<int64_t>(
        std::floor(segment.middle_s / BinLength(segments)));
    const TimeNs at = middle + FromSeconds(segment.middle_s);
    const auto frame = std::lower_bound(
        aligned.frames.begin(), aligned.frames.end(), at,
        [](const DetectionFrame& one, TimeNs time) { return one.time < time; });
    if (frame == aligned.frames.end()) continue;
    for (size_t v = 0; v < cameras.size(); ++v) {
      if (only.value_or(v) != v) continue;
      const auto view = static_cast<int>(v);
      MotionSegment others = segment;
      auto& seen = others.measurements;
      seen.erase(std::remove_if(seen.begin(), seen.end(),
                                [&](const SegmentMeasurement& one) {
                                  return one.view_idx == view;
                                }),
                 seen.end());
      if (std::all_of(seen.begin(), seen.end(),
                      [&](const SegmentMeasurement& one) {
                        return one.view_idx == seen.front().view_idx;
                      })) {
        continue;
      }
      SegmentState state = segment.state;
      if (!SolveSegment(cameras, none, others, segments.noise_scale, options,
                        &state)) {
        continue;
      }
      const auto off = NearestOff(cameras[v], others, state, view, *frame, at,
                                  segments.noise_scale);
      if (!off.has_value()) continue;
      auto& [sum, count] = views[v][bin];
      sum += *off;
      count += 1;
    }
  }
  return views;
}

// A step in a view's residuals.
struct ViewStep {
  int64_t bin = 0;     // the first bin after the step
  double ratio = 1.0;  // mean of the worse side / mean of the better side
  bool is_worse_before = false;
};

// The most significant step of a view's residuals with at least three bins on
// both sides; ratio 1 if none exceeds six standard deviations.
ViewStep StepOf(const ViewResiduals& view) {
  std::vector<std::pair<int64_t, double>> means;
  for (const auto& [bin, one] : view) {
    means.emplace_back(bin, one.first / one.second);
  }
  const auto count = static_cast<double>(means.size());
  double all = 0.0;
  double squares = 0.0;
  for (const auto& [bin, mean] : means) {
    all += mean;
    squares += mean * mean;
  }
  constexpr size_t kLeastBins = 3;
  constexpr double kLeastSigmas = 6.0;
  ViewStep step;
  double most = kLeastSigmas;
  double sum = 0.0;
  double sum_squares = 0.0;
  for (size_t k = 1; k + kLeastBins <= means.size(); ++k) {
    const double mean = means[k - 1].second;
    sum += mean;
    sum_squares += mean * mean;
    if (k < kLeastBins) continue;
    const auto before = static_cast<double>(k);
    const double after = count - before;
    const double first = sum / before;
    const double second = (all - sum) / after;
    const double variance = (sum_squares - sum * first +
                             (squares - sum_squares) - (all - sum) * second) /
                            std::max(1.0, count - 2.0);
    const double sigma =
        std::sqrt(std::max(1e-12, variance) * (1.0 / before + 1.0 / after));
    if (std::abs(first - second) <= most * sigma) continue;
    most = std::abs(first - second) / sigma;
    step.bin = means[k].first;
    step.is_worse_before = first > second;
    step.ratio =
        std::max(first, second) / std::max(1e-9, std::min(first, second));
  }
  return step;
}

// Mean of the residuals on one side of a step.
double MeanOf(const ViewResiduals& view, const ViewStep& step, bool worse) {
  double sum = 0.0;
  double count = 0.0;
  for (const auto& [bin, one] : view) {
    if (((bin < step.bin) == step.is_worse_before) != worse) continue;
    sum += one.first;
    count += one.second;
  }
  return sum / std::max(1.0, count);
}

class RigEstimate {
 public:
  RigEstimate(const RigInput& input, int attempt)
      : input_(input),
        attempt_(attempt),
        // A second attempt ignores the given times, because they may be wrong.
        has_times_(attempt == 0 && HasTimes(input.detections)),
        recording_(
            Regular(WithUsualConfidences(input.detections), &given_late_s_)),
        human_(IsHuman(recording_.header.skeleton)),
        intrinsics_(input.intrinsics) {
    result_.views.resize(intrinsics_.size());
    forgotten_frames_.resize(intrinsics_.size(), 0);
  }

  RigResult Run() {
    if (!Start()) {
      result_.reasons.push_back(WhyNoStart());
    } else if (!Adjust()) {
      result_.used.clear();
      result_.reasons.push_back(
          "no arrangement of the cameras explains what the views show");
    } else {
      Judge();
    }
    for (size_t v = 0; v < result_.views.size(); ++v) {
      RigView& view = result_.views[v];
      if (!view.joined && view.left_out.empty()) {
        view.left_out = "it shares no moving subjects with the other views";
      }
    }
    return std::move(result_);
  }

 private:
  bool Start() {
    RigSearch search;
    search.focal_sigma = input_.focal_sigma;
    search.attempt = attempt_;
    if (has_times_) search.longest_lag_s = kLongestDeviationS;
    if (input_.in_step) search.longest_lag_s = 0.0;
    search.progress = [&](int done, int total) {
      Report("pairs of views", done, total);
    };
    given_lags_.assign(intrinsics_.size(), 0);
    for (size_t v = 0; v < intrinsics_.size() && has_times_; ++v) {
      given_lags_[v] = -static_cast<int>(
          std::lround(given_late_s_[v] * recording_.header.frame_rate_hz));
    }
    if (has_times_) recording_ = Realigned(recording_, given_lags_);
    start_ = FindRigStart(recording_, intrinsics_, search);
    if (start_.views.empty()) return false;
    result_.used = start_.views;
    cameras_ = start_.cameras;
    lags_ = start_.lag_frames;
    used_recording_ = OfViews(recording_, result_.used);
    aligned_ = Realigned(used_recording_, lags_);
    changes_ = NoChanges(cameras_.size());
    ScaleByStature();
    return true;
  }

  // Sets the scale by the median stature of people, or for other subjects by an
  // assumed size of the rig.
  void ScaleByStature() {
    constexpr int kFrames = 100;
    const Stature stature = StatureOf(cameras_, aligned_, kFrames);
    if (stature.count > 0 && stature.median_m > 0.0) {
      cameras_ = Rescaled(cameras_, kStatureM / stature.median_m);
    } else if (!human_ && SizeOf(cameras_) > 0.0) {
      constexpr double kRigM = 3.0;
      cameras_ = Rescaled(cameras_, kRigM / SizeOf(cameras_));
    }
  }

  BundleOptions Options(int max_segments) const {
    BundleOptions options;
    options.segments.max_segments = max_segments;
    // Clocks are determined only by segments of at least three frames.
    constexpr double kFrames = 2.2;
    options.segments.span_s = std::max(
        options.segments.span_s, kFrames / recording_.header.frame_rate_hz);
    options.rotation_sigma_rad = 1.0;
    options.centre_sigma_m = 10.0;
    // For people, Measure() multiplies the covariance by kUnmodelled. The prior
    // sigmas of focal lengths, lenses and principal points are divided by its
    // square root in advance, so that the result has the intended sigmas.
    const double factor = human_ ? 1.0 / std::sqrt(kUnmodelled) : 1.0;
    options.focal_sigma = factor * std::max(1e-3, input_.focal_sigma);
    options.offset_sigma_s = has_times_ ? kTimeSigmaS : 0.1;
    options.drift_sigma = kDriftSigma;
    options.lens_sigma = factor * kLensSigma;
    options.shift_sigma_px =
        factor * kShiftShare * ImageWidth(intrinsics_[result_.used[0]]);
    for (size_t v = 0; v < cameras_.size(); ++v) {
      options.focal_prior.push_back(FocalPrior(v));
    }
    if (human_) {
      options.lasting_offset_m = kLastingOffsetM;
      options.segments.tapered = true;
    }
    // The fit overestimates the information of correlated errors by this
    // factor, so priors are weighted by it too; otherwise lenses would absorb
    // the persistent errors of people's joints.
    options.samples_at_once = samples_at_once_;
    options.max_iterations = kFitIterations;
    return options;
  }

  // Logarithm of the ratio of the given to the current focal length.
  double FocalPrior(size_t v) const {
    const Camera& given = intrinsics_[result_.used[v]];
    return std::log(given.focal_px() / cameras_[v].focal_px());
  }

  // The current cameras with the given principal points and lenses, which are
  // the means of the priors; LensChanges() are the changes from these to the
  // current values.
  CameraRig WithGivenLenses() const {
    CameraRig cameras;
    for (size_t v = 0; v < cameras_.size(); ++v) {
      const Camera& given = intrinsics_[result_.used[v]];
      cameras.push_back(Edited(cameras_[v], [&](CameraParameters* camera) {
        camera->K.block<2, 1>(0, 2) = given.K().block<2, 1>(0, 2);
        camera->lens = given.lens();
      }));
    }
    return cameras;
  }
  std::vector<CameraChange> LensChanges() const {
    std::vector<CameraChange> changes = NoChanges(cameras_.size());
    for (size_t v = 0; v < cameras_.size(); ++v) {
      const Camera& given = intrinsics_[result_.used[v]];
      changes[v].segment<2>(kShiftAt) =
          cameras_[v].K().block<2, 1>(0, 2) - given.K().block<2, 1>(0, 2);
      const Eigen::Vector2d added = RadialOf(cameras_[v]) - RadialOf(given);
      changes[v][kLensAt] = added[0];
      changes[v][kLensK2At] = added[1];
    }
    return changes;
  }

  // Clock correction [s], added to the capture times in the files.
  double ClockOf(size_t v) const {
    const auto of_recording = static_cast<size_t>(result_.used[v]);
    return changes_[v][kOffsetAt] -
           (lags_[v] + given_lags_[of_recording]) /
               recording_.header.frame_rate_hz -
           given_late_s_[of_recording];
  }

  // Fits cameras, then clocks.
  bool Fit(int max_segments, bool clocks) {
    BundleOptions options = Options(max_segments);
    if (max_segments == kFewSegments) options.max_iterations = kRoundIterations;
    segments_ = MakeSegments(cameras_, aligned_, matches_, options.segments);
    free_ = FreeParameters();
    free_.rotation = free_.centre = true;
    free_.focal = input_.focal_sigma > 0.0;
    // Lens parameters would absorb mismatches while the matching is uncertain.
    free_.shift = free_.lens = free_.lens_k2 = clocks && !input_.lenses_known;
    const CameraRig cameras = WithGivenLenses();
    fit_ = AdjustBundle(cameras, segments_, free_, LensChanges(), options);
    if (fit_.usable && human_) samples_at_once_ = fit_.samples_at_once;
    if (!fit_.usable || !clocks || input_.in_step || !MoveEnough(segments_)) {
      return fit_.usable;
    }
    const FreeParameters clock = ClockParametersOf(segments_.span_s);
    options.hold_velocities = human_;
    const BundleResult late =
        AdjustBundle(cameras, segments_, clock, fit_.changes, options);
    if (!late.usable) return true;
    for (size_t v = 0; v < cameras_.size(); ++v) {
      if (late.Sigma(v, kOffsetAt) > kMostClockS) return true;
    }
    free_.offset = clock.offset;
    free_.drift = clock.drift;
    fit_.changes = late.changes;
    return true;
  }

  // Covariance of cameras and clocks at the current estimate.
  bool Measure(int max_segments) {
    BundleOptions options = Options(max_segments);
    segments_ = MakeSegments(cameras_, aligned_, matches_, options.segments);
    options.hold_cameras = true;
    fit_ = AdjustBundle(WithGivenLenses(), segments_, free_, LensChanges(),
                        options);
    if (human_) fit_.covariance *= kUnmodelled;
    return fit_.usable;
  }

  // Alternates between matching and fitting; false if a fit fails or if fewer
  // than two views are matched in the end.
  bool Adjust() {
    double best = 0.0;
    const auto rounds = [&](int most, int segments, bool clocks,
                            const auto& match) {
      for (int round = 0; round < most; ++round) {
        const auto before = std::make_tuple(cameras_, lags_, changes_);
        match();
        if (!Fit(segments, clocks)) return false;
        Take();
        // Wrong matches may move the cameras away from the solution. If the
        // agreement of all people, which does not depend on matches, falls by
        // more than a fifth, the round is undone.
        const std::vector<double> agreements =
            AgreementsOfViews(cameras_, aligned_);
        const double sum =
            std::accumulate(agreements.begin(), agreements.end(), 0.0);
        if (sum < kLeastOfUsual * best) {
          std::tie(cameras_, lags_, changes_) = before;
          aligned_ = WithClocks(Realigned(used_recording_, lags_), changes_);
          break;
        }
        best = std::max(best, sum);
        Report("adjusting", std::min(++rounds_, kMostRounds), kMostRounds);
        if (Rests(1e-3, 2e-4)) break;
      }
      return true;
    };
    constexpr int kMany = 3500;
    const auto by_tracklets = [&] {
      start_.lag_frames = lags_;
      matches_ = PeopleOf(recording_, start_);
    };
    const auto by_tracks = [&] {
      ScaleByStature();
      matches_ = input_.match(cameras_, aligned_);
    };
    // Clocks are fitted once cameras are approximately right.
    if (!rounds(1, kFewSegments, false, by_tracklets) ||
        !rounds(12, kFewSegments, true, by_tracklets) ||
        !rounds(4, kMany, true, by_tracks)) {
      return false;
    }
    // A clock that has not converged is not reported.
    if (!Rests(0.005, 1e9)) free_.offset = free_.drift = false;
    if (!free_.offset) ForgetNearLags();
    by_tracks();
    if (!DropUnmatched(kMany)) return false;
    return Measure(kMany);
  }

  // If clocks are not determined, lags of one or two frames are chance results
  // of the search and are removed.
  void ForgetNearLags() {
    changes_ = NoChanges(cameras_.size());
    for (size_t v = 0; v < lags_.size(); ++v) {
      const int apart = std::abs(lags_[v] - lags_[0]);
      if (apart > kNearFrames) continue;
      forgotten_frames_[result_.used[v]] = apart;
      lags_[v] = lags_[0];
      // Capture times in the files are kept, including fractions of a frame.
      if (has_times_) changes_[v][kOffsetAt] -= ClockOf(v) - ClockOf(0);
    }
    aligned_ = WithClocks(Realigned(used_recording_, lags_), changes_);
  }

  // Drops views with hardly any matches: they do not constrain their cameras
  // and would make all others uncertain. False if fewer than two remain.
  bool DropUnmatched(int max_segments) {
    constexpr double kLeastShare = 0.02;  // of the median view's segments
    constexpr int kLeast = 20;
    const SceneSegments segments = MakeSegments(cameras_, aligned_, matches_,
                                                Options(max_segments).segments);
    std::vector<double> count(cameras_.size(), 0.0);
    for (const MotionSegment& segment : segments.segments) {
      std::vector<char> seen(cameras_.size(), 0);
      for (const SegmentMeasurement& one : segment.measurements) {
        seen[one.view_idx] = 1;
      }
      for (size_t v = 0; v < seen.size(); ++v) count[v] += seen[v];
    }
    const double least = std::max<double>(kLeast, kLeastShare * Median(count));
    std::vector<int> kept;
    for (size_t v = 0; v < count.size(); ++v) {
      if (count[v] >= least) kept.push_back(static_cast<int>(v));
    }
    if (kept.size() == count.size()) return true;
    if (kept.size() < 2) return false;
    CameraRig cameras;
    std::vector<int> lags;
    std::vector<CameraChange> changes;
    std::vector<int> used;
    for (size_t v = 0, k = 0; v < count.size(); ++v) {
      if (k < kept.size() && kept[k] == static_cast<int>(v)) {
        cameras.push_back(cameras_[v]);
        lags.push_back(lags_[v]);
        changes.push_back(changes_[v]);
        used.push_back(result_.used[v]);
        ++k;
      } else {
        result_.views[result_.used[v]].left_out =
            "at its estimated pose its detections do not match those of the "
            "other views: it may show another time or another room, or its "
            "images "
            "may be mirrored";
      }
    }
    cameras_ = std::move(cameras);
    lags_ = std::move(lags);
    changes_ = std::move(changes);
    result_.used = std::move(used);
    used_recording_ = OfViews(recording_, result_.used);
    aligned_ = WithClocks(Realigned(used_recording_, lags_), changes_);
    matches_ = input_.match(cameras_, aligned_);
    return true;
  }

  // Whether the last fit changed clocks and rotations by less than these
  // limits.
  bool Rests(double clock_s, double rotation_rad) const {
    return std::all_of(
        fit_.changes.begin(), fit_.changes.end(), [&](const CameraChange& one) {
          return std::abs(one[kOffsetAt]) < clock_s &&
                 one.segment<3>(kRotationAt).norm() < rotation_rad;
        });
  }

  // Applies the fit's cameras, and adds its clock changes to the current
  // clocks.
  void Take() {
    for (size_t v = 0; v < fit_.changes.size(); ++v) {
      changes_[v][kOffsetAt] += fit_.changes[v][kOffsetAt];
      changes_[v][kDriftAt] += fit_.changes[v][kDriftAt];
      // Whole frames are moved to the lag, so that matches keep their frames.
      const double rate_hz = recording_.header.frame_rate_hz;
      const auto frames =
          static_cast<int>(std::lround(changes_[v][kOffsetAt] * rate_hz));
      lags_[v] -= frames;
      changes_[v][kOffsetAt] -= frames / rate_hz;
    }
    for (size_t v = 1; v < fit_.changes.size() && has_times_; ++v) {
      // The correction of given times is limited to three of their sigmas.
      const double late_s = ClockOf(v) - ClockOf(0);
      const double most_s = 3.0 * kTimeSigmaS;
      changes_[v][kOffsetAt] -= late_s - std::clamp(late_s, -most_s, most_s);
    }
    cameras_ = RefinedCameras(WithGivenLenses(), fit_.changes);
    aligned_ = WithClocks(Realigned(used_recording_, lags_), changes_);
  }

  // Fits to the two halves: their difference in units of the limits for a
  // calibrated view, and the mean residual on the held-out half; 0 if a half
  // does not suffice.
  struct Halves {
    bool are_there = false;
    std::vector<double> apart;
    std::vector<double> left_out_px;
  };
  Halves HalvesOf(Halving halving) const {
    BundleOptions options = Options(1500);
    options.wants_covariance = false;
    FreeParameters free = free_;
    free.offset = free.drift = false;
    // Half of a recording constrains lenses less than all of it.
    free.shift = free.lens = free.lens_k2 = false;
    std::vector<BundleResult> fits;
    std::vector<FitError> errors;
    for (const int half : {0, 1}) {
      Report("held-out halves", ++halves_, kMostHalves);
      fits.push_back(AdjustBundle(cameras_, HalfOf(segments_, halving, half),
                                  free, NoChanges(cameras_.size()), options));
      if (!fits.back().usable) {
        return {false, std::vector<double>(cameras_.size(), 0.0),
                std::vector<double>(cameras_.size(), 0.0)};
      }
      errors.push_back(MeasureFit(cameras_,
                                  HalfOf(segments_, halving, 1 - half),
                                  fits.back().changes, options.segments));
    }
    Halves halves;
    halves.are_there = true;
    for (size_t v = 0; v < cameras_.size(); ++v) {
      const CameraChange off = fits[0].changes[v] - fits[1].changes[v];
      halves.apart.push_back(std::max(
          kDegPerRad * off.segment<3>(kRotationAt).norm() / kMostRotationDeg,
          off.segment<3>(kCentreAt).norm() / (kMostPlace * SizeOf(cameras_))));
      halves.left_out_px.push_back(0.5 *
                                   (errors[0].MeanPx(static_cast<int>(v)) +
                                    errors[1].MeanPx(static_cast<int>(v))));
    }
    return halves;
  }

  void Judge() {
    result_.cameras = cameras_;
    result_.covariance = fit_.covariance;
    result_.places = fit_.places;
    DropLens(&result_.places, &result_.covariance);
    result_.recording = aligned_;
    result_.size_m = SizeOf(cameras_);
    result_.clocks_told = free_.offset || input_.in_step;
    const Eigen::MatrixXd given = GivenLenses(fit_.covariance, fit_.places);
    result_.likely_right =
        LikelyRight(fit_.covariance, fit_.places, result_.size_m);
    result_.likely_by_lenses = LikelyRight(given, fit_.places, result_.size_m);
    if (!UndecidedViews().empty()) {
      // Two explanations fit equally well, so each is half as likely.
      result_.likely_right *= 0.5;
      result_.likely_by_lenses *= 0.5;
    }
    const std::vector<double> agreements =
        AgreementsOfViews(cameras_, aligned_);
    const double usual = Median(agreements);
    const Halves frames = HalvesOf(Halving::kTime);
    const Halves joints = HalvesOf(Halving::kJoints);
    const Halves people = HalvesOf(Halving::kPeople);
    // A wand has too few joints for halves, and its detection errors are not
    // persistent.
    const Halves& tell = human_ || joints.are_there ? joints : frames;
    const FitError error = MeasureFit(
        cameras_, segments_, NoChanges(cameras_.size()), Options(0).segments);
    const std::vector<std::string> breaks = Breaks();
    const std::vector<char> alike = PlacedOnlyBy(&PairFit::is_pose_undecided);
    Eigen::Index at = 0;
    size_t sure = 0;
    for (size_t v = 0; v < cameras_.size(); ++v) {
      RigView& view = result_.views[result_.used[v]];
      view.joined = true;
      view.rotation_sigma_deg = kDegPerRad * Spread(fit_.covariance, at);
      view.centre_sigma_m = Spread(fit_.covariance, at + kCentreAt);
      const double rotation_deg = kDegPerRad * Spread(given, at);
      const double centre_m = Spread(given, at + kCentreAt);
      at += static_cast<Eigen::Index>(fit_.places[v].size());
      view.clock_s = v == 0 ? 0.0 : ClockOf(v) - ClockOf(0);
      view.clock_sigma_s =
          free_.offset ? fit_.Sigma(v, kOffsetAt)
          : v == 0 || input_.in_step
              ? 0.0
              : std::hypot(kOfAFrame, forgotten_frames_[result_.used[v]]) /
                    recording_.header.frame_rate_hz;
      view.drift = changes_[v][kDriftAt];
      view.mean_px = error.MeanPx(static_cast<int>(v));
      view.left_out_px = {frames.left_out_px[v], joints.left_out_px[v],
                          people.left_out_px[v]};
      view.halves_apart = tell.apart[v];
      view.agreement = agreements[v];
      const bool is_sure =
          rotation_deg <= kMostRotationDeg &&
          centre_m <= kMostPlace * result_.size_m && tell.are_there &&
          tell.apart[v] <= kMostApart && DeterminesFocal() && !HasOddFocal(v) &&
          !HasOddDrift(v) && agreements[v] >= kLeastAgreement &&
          agreements[v] >= kLeastOfUsual * usual;
      view.left_out = !breaks[v].empty() ? breaks[v]
                      : alike[result_.used[v]] != 0
                          ? "people move so much alike that another pose, with "
                            "people exchanged, fits nearly as well"
                      : is_sure ? ""
                                : WhyUnsure(rotation_deg, centre_m, tell, v,
                                            agreements[v], usual);
      sure += view.left_out.empty() ? 1 : 0;
    }
    if (sure == cameras_.size()) result_.other_focal = OtherFocal();
    Verdict(sure);
  }

  // Whether each view of the recording is placed only by pairs for which
  // `is_undecided` returns true: the other pairs that agree with the rig do not
  // connect it with more than half of the views. False for views without any
  // pair that agrees.
  std::vector<char> PlacedOnlyBy(bool (PairFit::*is_undecided)() const) const {
    constexpr double kSameS = 0.25;  // as in PairFit::rival
    constexpr double kSameRad = 20.0 / kDegPerRad;
    const double most = kSameS * recording_.header.frame_rate_hz;
    const size_t count = cameras_.size();
    std::vector<size_t> group(count);
    std::iota(group.begin(), group.end(), size_t{0});
    std::vector<char> placed(count, 0);
    for (const PairFit& pair : start_.pairs) {
      const auto at = [&](int view) {
        return static_cast<size_t>(
            std::find(result_.used.begin(), result_.used.end(), view) -
            result_.used.begin());
      };
      const size_t a = at(pair.a);
      const size_t b = at(pair.b);
      if (a == count || b == count ||
          std::abs(lags_[b] - lags_[a] - pair.lag) > most ||
          Eigen::AngleAxisd(pair.pose.R.transpose() * cameras_[b].R() *
                            cameras_[a].R().transpose())
                  .angle() > kSameRad) {
        continue;
      }
      placed[a] = placed[b] = 1;
      if ((pair.*is_undecided)()) continue;
      std::replace(group.begin(), group.end(), size_t{group[b]},
                   size_t{group[a]});
    }
    const auto views = std::count(placed.begin(), placed.end(), 1);
    std::vector<char> undecided(intrinsics_.size(), 0);
    for (size_t v = 0; v < count; ++v) {
      const bool is_connected =
          2 * std::count(group.begin(), group.end(), group[v]) > views;
      undecided[result_.used[v]] = placed[v] != 0 && !is_connected ? 1 : 0;
    }
    return undecided;
  }

  // Names of the views placed only by pairs for which another lag or pose fits
  // nearly as well.
  std::vector<std::string> UndecidedViews() const {
    const std::vector<char> undecided = PlacedOnlyBy(&PairFit::is_undecided);
    std::vector<std::string> views;
    for (const int v : result_.used) {
      if (undecided[v] == 0) continue;
      views.push_back(Printable(recording_.header.view_names[v]));
    }
    return views;
  }

  // Describes the views whose focal lengths, as estimated from the recording,
  // differ from the stated values; empty if all agree.
  std::string OtherFocal() const {
    if (!input_.focal_stated || cameras_.size() < 3) return "";
    BundleOptions options = Options(0);
    options.focal_sigma = kFocalUnknown;
    FreeParameters free = free_;
    free.focal = true;
    free.offset = free.drift = false;
    const BundleResult fit = AdjustBundle(WithGivenLenses(), segments_, free,
                                          LensChanges(), options);
    if (!fit.usable) return "";
    // Exceeded by one correct focal length in a thousand.
    constexpr double kMostSigmas = 3.3;
    std::vector<std::string> found;
    for (size_t v = 0; v < cameras_.size(); ++v) {
      const double off = fit.changes[v][kFocalAt] - options.focal_prior[v];
      const double sigma =
          (human_ ? std::sqrt(kUnmodelled) : 1.0) * fit.Sigma(v, kFocalAt);
      if (std::abs(off) <=
          kMostSigmas * std::hypot(sigma, input_.focal_sigma)) {
        continue;
      }
      const double given_px = intrinsics_[result_.used[v]].focal_px();
      found.push_back(
          fmt::format("{} {:.0f} +- {:.0f} px instead of {:.0f}",
                      Printable(recording_.header.view_names[result_.used[v]]),
                      given_px * std::exp(off), given_px * sigma, given_px));
    }
    return fmt::format("{}", fmt::join(found, ", "));
  }

  // Describes the limit that a view exceeds, with the measured value.
  std::string WhyUnsure(double rotation_deg, double centre_m,
                        const Halves& halves, size_t v, double agreement,
                        double usual) const {
    if (!DeterminesFocal())
      return "the recording does not determine its focal length";
    if (HasOddFocal(v)) {
      return fmt::format(
          "it fits only with a focal length of {:.0f} px, although {:.0f} px "
          "is stated or typical",
          cameras_[v].focal_px(), intrinsics_[result_.used[v]].focal_px());
    }
    if (HasOddDrift(v)) {
      return fmt::format(
          "it fits only with a clock that drifts by {:.1f} ms per second: its "
          "lag may be wrong by one stride, or its frame rate differs",
          1e3 * changes_[v][kDriftAt]);
    }
    if (agreement < kLeastAgreement || agreement < kLeastOfUsual * usual) {
      return fmt::format(
          "the agreement of its detections with the other views is only "
          "{:.2f} (1 is perfect; median of the views: {:.2f})",
          agreement, usual);
    }
    if (rotation_deg > kMostRotationDeg ||
        centre_m > kMostPlace * result_.size_m) {
      return fmt::format(
          "its pose is too uncertain: sigmas of {:.1f} degrees and {:.1f} % of "
          "the rig's size, the limits are {:.1f} and {:.1f}",
          rotation_deg, 100.0 * centre_m / result_.size_m, kMostRotationDeg,
          100.0 * kMostPlace);
    }
    if (!halves.are_there)
      return "one half of the recording alone does not determine its pose";
    return fmt::format(
        "its poses from the two halves of the data differ by {:.1f} times the "
        "permitted uncertainty",
        halves.apart[v]);
  }

  // Describes, for each view, a change during the recording, at which its
  // residuals step and those of the other views do not; empty if there is none.
  std::vector<std::string> Breaks() const {
    // Even without a change, a view's residuals may be twice as large in one
    // part of a recording, if people are occluded or far away.
    constexpr double kLeastRatio = 2.0;
    constexpr double kMoreThanOthers = 1.5;
    const std::vector<ViewResiduals> residuals =
        ResidualsBeside(cameras_, aligned_, segments_, Options(0).segments);
    std::vector<ViewStep> steps;
    std::vector<double> ratios;
    for (const ViewResiduals& one : residuals) {
      steps.push_back(StepOf(one));
      ratios.push_back(steps.back().ratio);
    }
    std::vector<std::string> breaks(residuals.size());
    if (residuals.size() < 3)
      return breaks;  // with two views, either may have changed
    const double usual = Median(ratios);
    for (size_t v = 0; v < breaks.size(); ++v) {
      if (ratios[v] < kLeastRatio || ratios[v] < kMoreThanOthers * usual) {
        continue;
      }
      const std::string cause = WhatExplains(v, steps[v], residuals[v]);
      if (cause.empty()) continue;
      const double middle_s = 0.5 * segments_.span_s;
      const ViewStep step = Sharpened(v, steps[v]);
      const auto frame = static_cast<int64_t>(std::lround(
          (middle_s + static_cast<double>(step.bin) * BinLength(segments_)) *
          recording_.header.frame_rate_hz));
      breaks[v] = fmt::format(
          "at about frame {} its residuals change {:.0f}-fold and those of the "
          "other views do not: {}; calibrate the parts before and after "
          "separately",
          input_.detections.frames.front().frame +
              frame * NumberStep(input_.detections.frames),
          ratios[v], cause);
    }
    return breaks;
  }

  // Describes whether a separate clock or pose on the worse side of a view's
  // step explains the step; empty if neither does. For a camera rotated by 3
  // degrees the pose explains a third of the excess (the robust loss limits the
  // fit); for Shelf's cam2, where people are occluded, nothing. The limit of a
  // fifth is based on few recordings. The best of thirty lags gains by chance,
  // so a clock must explain half.
  std::string WhatExplains(size_t v, const ViewStep& step,
                           const ViewResiduals& residuals) const {
    constexpr double kLeastByClock = 0.5;
    constexpr double kLeastByPlace = 0.2;
    const double better = MeanOf(residuals, step, /*worse=*/false);
    const double worse = MeanOf(residuals, step, /*worse=*/true);
    const auto explained = [&](const CameraRig& cameras,
                               const DetectionSequence& aligned) {
      const ViewResiduals own = ResidualsBeside(cameras, aligned, segments_,
                                                Options(0).segments, v)[v];
      return (worse - MeanOf(own, step, /*worse=*/true)) / (worse - better);
    };
    if (!input_.in_step) {
      constexpr double kFarthestS = 0.5;
      const double frame_s = 1.0 / recording_.header.frame_rate_hz;
      const auto farthest = static_cast<int>(kFarthestS / frame_s);
      double most = 0.0;
      int lag = 0;
      for (int k = -farthest; k <= farthest; ++k) {
        std::vector<CameraChange> late = NoChanges(cameras_.size());
        late[v][kOffsetAt] = k * frame_s;
        const double share = explained(cameras_, WithClocks(aligned_, late));
        if (share <= most) continue;
        most = share;
        lag = k;
      }
      if (most >= kLeastByClock) {
        return fmt::format(
            "its images are {} {} this frame by about {}, because images were "
            "lost or repeated",
            lag > 0 ? "late" : "early",
            step.is_worse_before ? "before" : "after",
            Counted(std::abs(lag) * NumberStep(input_.detections.frames),
                    "frame", "frames"));
      }
    }
    const auto fit = FitToSide(v, step, /*worse=*/true);
    return fit.has_value() && explained(*fit, aligned_) >= kLeastByPlace
               ? "the camera was moved or zoomed"
               : "";
  }

  // The cameras, with view `v` fitted to one side of its step; nullopt if the
  // fit fails.
  std::optional<CameraRig> FitToSide(size_t v, const ViewStep& step,
                                     bool worse) const {
    SceneSegments side = segments_;
    side.segments.clear();
    for (const MotionSegment& segment : segments_.segments) {
      const bool is_before = segment.middle_s < static_cast<double>(step.bin) *
                                                    BinLength(segments_);
      if ((is_before == step.is_worse_before) == worse) {
        side.segments.push_back(segment);
      }
    }
    BundleOptions options = Options(0);
    options.wants_covariance = false;
    FreeParameters free;
    free.rotation = free.centre = true;
    free.offset = !input_.in_step;
    std::vector<char> moves(cameras_.size(), 0);
    moves[v] = 1;
    const BundleResult fit = AdjustBundle(
        cameras_, side, free, NoChanges(cameras_.size()), options, moves);
    if (!fit.usable) return std::nullopt;
    return RefinedCameras(cameras_, fit.changes);
  }

  // The same step with the view fitted to its better side: a camera fitted to
  // both sides lies between the two poses and blurs the time of the step.
  ViewStep Sharpened(size_t v, const ViewStep& step) const {
    const auto better = FitToSide(v, step, /*worse=*/false);
    if (!better.has_value()) return step;
    const ViewStep sharp = StepOf(
        ResidualsBeside(*better, aligned_, segments_, Options(0).segments)[v]);
    return sharp.ratio > step.ratio ? sharp : step;
  }

  // Recommends what to record next.
  const char* Record() const {
    return human_ ? "record people who walk through the whole room, arms "
                    "moving, for a minute"
                  : "move the subject through the whole room for a minute";
  }

  // Describes why no two views were joined: what was tracked, and what pairs
  // share.
  std::string WhyNoStart() const {
    if (recording_.header.skeleton.joint_count() < 2) {
      return "the subject is a single point: at least two joints are needed";
    }
    constexpr double kLeastS = 1.0;
    const double rate_hz = recording_.header.frame_rate_hz;
    const double span_s =
        static_cast<double>(recording_.frames.size()) / rate_hz;
    if (span_s < kLeastS) {
      return fmt::format(
          "the recording is {:.2g} s long, but tracklets must last at least "
          "one second: {}",
          span_s, Record());
    }
    std::vector<int> tracklets(intrinsics_.size(), 0);
    for (const ViewTracklet& one : start_.tracklets) ++tracklets[one.view];
    std::vector<std::string> counts;
    for (size_t v = 0; v < tracklets.size(); ++v) {
      counts.push_back(fmt::format(
          "{} {}", Printable(recording_.header.view_names[v]), tracklets[v]));
    }
    const auto seeing =
        tracklets.size() - std::count(tracklets.begin(), tracklets.end(), 0);
    const std::string followed = fmt::format(
        "tracklets of at least a second, by view: {}", fmt::join(counts, ", "));
    if (seeing < 2) {
      return fmt::format(
          "fewer than two views have a tracklet of at least one second and ten "
          "detections ({}): {}",
          followed, Record());
    }
    double most = 0.0;
    for (const PairFit& pair : start_.pairs) {
      most = std::max(most, pair.evidence);
    }
    return fmt::format(
        "no two views see the same {} move: the best pair shares {:.1f} s "
        "({}); {}, where at least two cameras see {}",
        human_ ? "people" : "thing", most, followed, Record(),
        human_ ? "them" : "it");
  }

  void Report(const std::string& stage, int done, int total) const {
    if (input_.progress) input_.progress(stage, done, total);
  }

  void Verdict(size_t sure) {
    const bool all = sure == result_.views.size();
    const bool right = result_.likely_right >= kLeastLikely;
    constexpr size_t kFewest = 2;
    result_.verdict = all && right      ? RigVerdict::kCalibrated
                      : sure >= kFewest ? RigVerdict::kPartly
                                        : RigVerdict::kRefused;
    if (!result_.clocks_told) {
      result_.reasons.push_back(
          "clocks are known to whole frames only: record faster motion, or use "
          "--in_step if the cameras share a trigger");
    }
    if (sure < result_.views.size() && sure == cameras_.size()) {
      result_.reasons.push_back(
          "some views share no motion with the others, or have another frame "
          "rate or time: see the views left out");
    }
    if (sure == cameras_.size()) {
      if (result_.likely_right < kLeastLikely) {
        result_.reasons.push_back(WhyNotLikely());
      }
      return;
    }
    if (!DeterminesFocal()) {
      result_.reasons.push_back(
          "two cameras do not determine their focal lengths: specify them "
          "(--focal, --cameras), or add a third camera");
    } else if (cameras_.size() == kFewest && FaceEachOther()) {
      result_.reasons.push_back(
          "two cameras that face each other hardly determine depth: add a "
          "third camera at the side");
    } else if (human_ && PlacesApart(segments_) < kOneSpotM) {
      result_.reasons.push_back(
          fmt::format("people stay in one place (half of the time within "
                      "{:.2f} m), so a detector's persistent errors cannot be "
                      "distinguished from rotated cameras: {}",
                      PlacesApart(segments_), Record()));
    } else {
      result_.reasons.push_back(WhyLeftOut());
      if (result_.verdict == RigVerdict::kRefused) {
        result_.reasons.push_back(fmt::format("to improve: {}", Record()));
      }
    }
  }

  // The views left out, grouped by cause: "a, b: CAUSE; c: CAUSE".
  std::string WhyLeftOut() const {
    std::vector<std::string> causes;
    std::vector<std::string> views;  // of each cause
    for (const int v : result_.used) {
      const std::string& why = result_.views[v].left_out;
      if (why.empty()) continue;
      const std::string name = Printable(recording_.header.view_names[v]);
      const auto known = std::find(causes.begin(), causes.end(), why);
      if (known == causes.end()) {
        causes.push_back(why);
        views.push_back(name);
      } else {
        views[static_cast<size_t>(known - causes.begin())] += ", " + name;
      }
    }
    for (size_t i = 0; i < causes.size(); ++i) {
      views[i] += ": " + causes[i];
    }
    return fmt::format("{}", fmt::join(views, "; "));
  }

  // Describes why a rig whose views are all accurate is less certain than
  // promised.
  std::string WhyNotLikely() const {
    const std::vector<std::string> undecided = UndecidedViews();
    if (!undecided.empty()) {
      return fmt::format(
          "the motion is so regular that other lags and poses of {} fit nearly "
          "as well: record {}, or use --in_step if the cameras share a trigger",
          fmt::join(undecided, ", "),
          human_ ? "people who stop, turn and change their speed"
                 : "motion that does not repeat");
    }
    double deg = 0.0;
    double share = 0.0;
    for (const int v : result_.used) {
      deg = std::max(deg, result_.views[v].rotation_sigma_deg);
      share = std::max(share, result_.views[v].centre_sigma_m / result_.size_m);
    }
    const std::string off = fmt::format(
        "cameras may be off by {:.1f} degrees and {:.1f} % of the rig's size "
        "(standard deviation)",
        deg, 100.0 * share);
    if (!input_.lenses_known && result_.likely_by_lenses >= kLeastLikely) {
      return "lens: the recording does not determine principal points and "
             "distortion well enough, and because of these " +
             off +
             "; specify lenses that are measured (--cameras), or record " +
             (human_ ? "people" : "it") + " up to the edges of all images";
    }
    const std::string what =
        !input_.lenses_known
            ? "specify lenses that are measured (--cameras), or "
        : input_.focal_sigma > 0.0 ? "specify focal lengths that are measured "
                                     "(--focal, --cameras), or "
                                   : "";
    return "every view is calibrated, but not certainly to 0.3 degrees and 1 % "
           "of the rig's size: " +
           off + "; " + what + "record longer and more people";
  }

  // Two cameras whose axes intersect, as is typical in a room, fit any focal
  // lengths (Newsam et al., "Recovering Unknown Focal Lengths in
  // Self-Calibration: An Essentially Linear Algorithm and Degenerate
  // Configurations", 1996).
  bool DeterminesFocal() const {
    constexpr double kNearlyKnown = 0.03;
    return cameras_.size() > 2 || input_.focal_sigma <= kNearlyKnown;
  }

  // Whether a focal length is implausible; with such a value, mirrored images
  // and wrong lags may fit.
  bool HasOddFocal(size_t v) const {
    constexpr double kMostSigmas = 3.3;  // one in a thousand
    return std::abs(FocalPrior(v)) > kMostSigmas * kFocalUnknown;
  }

  // Whether a drift is implausible. Because steps repeat, a lag of one stride
  // with a drift may fit nearly as well as the truth. Files of 29.97 Hz read as
  // 30 Hz drift by a thousandth.
  bool HasOddDrift(size_t v) const {
    constexpr double kMostSigmas = 3.3;  // one in a thousand
    constexpr double kNtsc = 1e-3;
    const double drift =
        std::abs(changes_[v][kDriftAt] - changes_[0][kDriftAt]);
    return drift > kMostSigmas * kDriftSigma &&
           std::abs(drift - kNtsc) > kDriftSigma;
  }

  bool FaceEachOther() const {
    constexpr double kCosine = -0.94;  // cosine of 160 degrees
    return cameras_[0].R().row(2).dot(cameras_[1].R().row(2)) < kCosine;
  }

  static constexpr int kMostRounds = 17;
  static constexpr int kMostHalves = 6;

  const RigInput& input_;
  const int attempt_;
  const bool has_times_;
  std::vector<double> given_late_s_;
  std::vector<int> given_lags_;
  DetectionSequence recording_;
  const bool human_;
  const CameraRig intrinsics_;
  std::vector<int> forgotten_frames_;  // lags removed, by view
  int rounds_ = 0;
  mutable int halves_ = 0;
  RigResult result_;
  // Indexed by joined view.
  CameraRig cameras_;
  std::vector<int> lags_;
  std::vector<CameraChange> changes_;  // clocks only, after the lags
  DetectionSequence used_recording_;
  DetectionSequence aligned_;
  RigStart start_;
  FrozenMatches matches_;
  // Results of the last fit.
  SceneSegments segments_;
  FreeParameters free_;
  BundleResult fit_;
  double samples_at_once_ = 1.0;  // of the last fit
};

}  // namespace

const char* ToString(RigVerdict verdict) {
  constexpr std::array kNames = {"calibrated", "partly", "refused"};
  return kNames[static_cast<size_t>(verdict)];
}

namespace {

// The input restricted to some views.
RigInput PartOf(const RigInput& input, const std::vector<int>& views) {
  RigInput part = input;
  part.detections = OfViews(input.detections, views);
  part.intrinsics.clear();
  for (const int v : views) part.intrinsics.push_back(input.intrinsics[v]);
  return part;
}

// Maps the result for the views `kept` back to all views. `whole`: the earlier
// result, which contains the reasons why the other views are left out.
RigResult OfWhole(RigResult part, const std::vector<int>& kept,
                  RigResult whole) {
  for (RigView& view : whole.views) view.joined = false;
  for (size_t i = 0; i < kept.size(); ++i) {
    whole.views[kept[i]] = part.views[i];
  }
  for (int& v : part.used) v = kept[v];
  if (part.verdict == RigVerdict::kCalibrated) {
    part.verdict = RigVerdict::kPartly;
  }
  part.views = std::move(whole.views);
  return part;
}

// The reason for a view that is left out.
std::string ReasonOf(const DetectionHeader& header, const RigResult& result,
                     size_t v) {
  return Printable(header.view_names[v]) +
         " is left out: " + result.views[v].left_out;
}

// Adds the views that are left out to the reasons.
void DescribeLeftOut(const DetectionHeader& header, RigResult* result) {
  for (size_t v = 0; v < result->views.size(); ++v) {
    const RigView& view = result->views[v];
    if (view.joined || view.left_out.empty()) continue;
    result->reasons.push_back(ReasonOf(header, *result, v));
  }
}

// Whether a later attempt may replace a refused attempt: three views check each
// other, while two views of a failed recording may fit by chance (Campus: two
// of three views with an estimated sigma of 0.2 degrees and an error of 150
// degrees).
bool IsRescue(const RigResult& result) {
  constexpr size_t kFewest = 3;
  return result.verdict != RigVerdict::kRefused &&
         result.used.size() >= kFewest;
}

// The joined views that are accurate. If the result is refused: of three or
// more joined views all but the one that agrees least with the others, which
// may spoil them; of two both.
std::vector<int> ViewsToKeep(const RigResult& result) {
  std::vector<int> kept = result.used;
  if (result.verdict != RigVerdict::kRefused) {
    kept.erase(std::remove_if(
                   kept.begin(), kept.end(),
                   [&](int v) { return !result.views[v].left_out.empty(); }),
               kept.end());
  } else if (kept.size() > 2) {
    kept.erase(std::min_element(kept.begin(), kept.end(), [&](int x, int y) {
      return result.views[x].agreement < result.views[y].agreement;
    }));
  }
  return kept;
}

// Estimates with left and right as detected, without the views that are not
// accurate.
RigResult EstimateAsShown(const RigInput& input, int attempt) {
  RigResult result = RigEstimate(input, attempt).Run();
  bool is_part = false;
  for (std::vector<int> kept = ViewsToKeep(result);
       kept.size() >= 2 && kept.size() < result.used.size();
       kept = ViewsToKeep(result)) {
    RigResult again =
        OfWhole(RigEstimate(PartOf(input, kept), attempt).Run(), kept, result);
    if (result.verdict == RigVerdict::kRefused && !IsRescue(again)) break;
    result = std::move(again);
    is_part = true;
  }
  if (is_part) DescribeLeftOut(input.detections.header, &result);
  return result;
}

double SumOfAgreements(const RigResult& result) {
  double sum = 0.0;
  for (const RigView& view : result.views) {
    if (view.joined) sum += view.agreement;
  }
  return sum;
}

// Views whose left and right may be exchanged: views that agree better if
// exchanged, and views not joined.
std::vector<char> MayBeExchanged(const RigResult& result) {
  constexpr int kFrames = 40;
  const std::vector<int> frames =
      FramesToLookAt(PeopleOfViews(result.recording), kFrames);
  const ExchangedSides found =
      FindExchangedSides(result.cameras, FramesOf(result.recording, frames));
  std::vector<char> views;
  for (const RigView& view : result.views) views.push_back(!view.joined);
  for (size_t v = 0; v < result.used.size(); ++v) {
    views[result.used[v]] = found.gain.is_enough() && found.views[v];
  }
  return views;
}

// The recording with one view's frame rate scaled by `factor`: frame k shows
// the view's frame k * factor.
DetectionSequence AtRate(const DetectionSequence& detections, size_t view,
                         double factor) {
  DetectionSequence moved = detections;
  const auto count = static_cast<int64_t>(detections.frames.size());
  for (int64_t k = 0; k < count; ++k) {
    ViewDetections& shown = moved.frames[k].views[view];
    shown.detections.clear();
    const auto from = std::llround(static_cast<double>(k) * factor);
    if (from < count) {
      shown.detections = detections.frames[from].views[view].detections;
    }
  }
  return moved;
}

// Checks whether views that were not joined have another frame rate. The pair
// with a joined view then has several seconds of evidence at that rate, far
// more than at any other lag or at the stated rate. A camera that was moved
// fits partly at both rates.
void AskRates(const RigInput& input, RigResult* result) {
  constexpr double kLeastEvidenceS = 3.0;
  constexpr double kMostRival = 0.6;  // of the evidence
  const DetectionHeader& header = input.detections.header;
  const double rate_hz = header.frame_rate_hz;
  if (result->used.empty()) return;
  for (size_t v = 0; v < result->views.size(); ++v) {
    RigView& view = result->views[v];
    if (view.joined) continue;
    const RigInput pair = PartOf(input, {result->used[0], static_cast<int>(v)});
    const auto fit_at = [&](double factor) {
      std::vector<double> late_s;
      return FindRigStart(
          AtRate(Regular(WithUsualConfidences(pair.detections), &late_s), 1,
                 factor),
          pair.intrinsics, {});
    };
    const double stated_s = fit_at(1.0).pairs[0].evidence;
    const std::string reason = ReasonOf(header, *result, v);
    double best = kLeastEvidenceS;
    for (const double rate : {24.0, 25.0, 30.0, 50.0, 60.0, 100.0, 120.0}) {
      const double factor = rate / rate_hz;
      if (std::abs(factor - 1.0) < 0.02) continue;
      const RigStart start = fit_at(factor);
      if (start.views.size() < 2) continue;
      const PairFit& fit = start.pairs[0];
      if (fit.evidence <= best ||
          std::max(fit.rival, stated_s) > kMostRival * fit.evidence) {
        continue;
      }
      best = fit.evidence;
      view.left_out = fmt::format(
          "read at {:.4g} Hz instead of {:.4g}, its motion agrees with view "
          "{}: --set=input.view_frame_rate.{}={:.4g}",
          rate, rate_hz, Printable(header.view_names[result->used[0]]),
          Printable(header.view_names[v]), rate);
    }
    std::replace(result->reasons.begin(), result->reasons.end(), reason,
                 ReasonOf(header, *result, v));
  }
}

RigResult EstimateWithSides(const RigInput& input) {
  if (input.detections.frames.empty()) {
    RigResult nothing;
    nothing.views.resize(input.intrinsics.size());
    nothing.reasons.push_back("there are no detections");
    return nothing;
  }
  RigResult result = EstimateAsShown(input, 0);
  // Because the search is random, a recording is not refused after one attempt.
  if (result.verdict == RigVerdict::kRefused) {
    RigResult second = EstimateAsShown(input, 1);
    if (IsRescue(second)) result = std::move(second);
  }
  if (result.verdict == RigVerdict::kRefused ||
      !IsHuman(input.detections.header.skeleton)) {
    return result;
  }
  const std::vector<char> views = MayBeExchanged(result);
  if (std::count(views.begin(), views.end(), 1) == 0) return result;
  RigInput exchanged = input;
  ExchangeSides(views, &exchanged.detections);
  RigResult again = EstimateAsShown(exchanged, 0);
  // A mirrored image (except for its lens) and a lag of half a stride also look
  // like exchanged sides, so high confidence is required for reporting wrong
  // detections.
  if (again.verdict == RigVerdict::kRefused ||
      again.likely_by_lenses < kLeastLikely ||
      (!IsRescue(again) && input.intrinsics.size() > 2) ||
      (!again.other_focal.empty() && result.other_focal.empty()) ||
      SumOfAgreements(again) <
          SumOfAgreements(result) + AgreementGain::kLeastGain) {
    return result;
  }
  again.reasons.push_back(
      "left and right are exchanged in some views: track with " +
      ExchangeSidesFlag(views, input.detections.header.view_names));
  return again;
}

// If the recording contradicts the stated focal lengths, which then bias all
// cameras, estimates the rig without them; refused if that fails.
RigResult WithoutFocal(const RigInput& input, RigResult result) {
  RigInput part = input;
  part.focal_stated = false;
  part.focal_sigma = kFocalUnknown;
  RigResult again = EstimateWithSides(part);
  const std::string found =
      "the recording contradicts the focal lengths that were stated: " +
      result.other_focal;
  if (again.verdict == RigVerdict::kRefused) {
    result.verdict = RigVerdict::kRefused;
    result.reasons.push_back(found +
                             "; without these the cameras are undetermined");
    return result;
  }
  again.reasons.push_back(found + "; all are estimated as if none were stated");
  if (again.verdict == RigVerdict::kCalibrated) {
    again.verdict = RigVerdict::kPartly;
  }
  return again;
}

}  // namespace

RigResult EstimateRig(const RigInput& input) {
  RigResult result = EstimateWithSides(input);
  if (!result.other_focal.empty()) result = WithoutFocal(input, result);
  AskRates(input, &result);
  return result;
}

}  // namespace kinegraph
