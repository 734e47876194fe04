#include "solvers/rig/rig.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/base/median.h"
#include "core/base/random.h"
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

constexpr double kDegrees = 57.29577951308232;
constexpr double kStatureM = 1.7;
// How far a detector is off for a whole recording, of each person's joint in
// each view, on each axis (of people 1.7 m tall): OpenPose's joints by 6 to 14
// mm in the median of both axes, the mean of which is 1.18 of these.
constexpr double kLastingOffsetM = 0.007;
// Variances are so many times what stretches say that are independent of each
// other and have one noise: outliers, tails and joints that are hidden.
constexpr double kUnmodelled = 3.0;
// A view is calibrated when it is as sure as this: degrees, and shares of the
// rig's size.
constexpr double kMostRotationDeg = 0.8;
constexpr double kMostPlace = 0.025;
// What `calibrated` promises of every view, and how likely that must be.
constexpr double kPromisedDeg = 0.3;
constexpr double kPromisedPlace = 0.01;
constexpr double kLeastLikely = 0.8;
// A clock that is less sure than this is not told.
constexpr double kMostClockS = 0.02;
// Standard deviation of what is anywhere within a frame, in frames.
constexpr double kOfAFrame = 0.29;
// Fits on halves of the joints may differ by this many times as much.
constexpr double kMostApart = 2.0;
// People whose places are no farther apart than this stay in one spot (the
// limit of `doctor`, a fifth of a person).
constexpr double kOneSpotM = 0.34;
// A view that agrees with the others this much less than the usual one does is
// in the wrong place, and so are all where hardly anybody agrees.
constexpr double kLeastOfUsual = 0.8;
constexpr double kLeastAgreement = 0.5;

// Every frame number from first to last, each at its time; no clock but the
// frames' own. `late_s`: the mean of what each view's times told beside it.
DetectionSequence Regular(DetectionSequence detections,
                          std::vector<double>* late_s) {
  DetectionSequence recording;
  recording.header = detections.header;
  const double beat_s = 1.0 / recording.header.frame_rate_hz;
  const int64_t first = detections.frames.front().frame;
  const TimeNs zero = detections.frames.front().time;
  late_s->assign(recording.header.view_names.size(), 0.0);
  for (DetectionFrame& frame : detections.frames) {
    while (!recording.frames.empty() &&
           recording.frames.back().frame + 1 < frame.frame) {
      DetectionFrame empty;
      empty.frame = recording.frames.back().frame + 1;
      empty.views.resize(frame.views.size());
      recording.frames.push_back(std::move(empty));
    }
    const double regular_s = static_cast<double>(frame.frame - first) * beat_s;
    for (size_t v = 0; v < frame.views.size(); ++v) {
      (*late_s)[v] +=
          (ToSeconds(frame.views[v].capture_time - zero) - regular_s) /
          static_cast<double>(detections.frames.size());
    }
    recording.frames.push_back(std::move(frame));
  }
  for (DetectionFrame& frame : recording.frames) {
    frame.time = FromSeconds(static_cast<double>(frame.frame - first) * beat_s);
    for (ViewDetections& view : frame.views) view.capture_time = frame.time;
  }
  return recording;
}

// Twice the rms distance of the cameras from their middle.
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

class RigEstimate {
 public:
  explicit RigEstimate(const RigInput& input)
      : input_(input),
        recording_(
            Regular(WithUsualConfidences(input.detections), &told_late_s_)),
        human_(IsHuman(recording_.header.skeleton)),
        intrinsics_(input.intrinsics) {
    result_.views.resize(intrinsics_.size());
  }

  RigResult Run() {
    if (!Start()) {
      result_.reasons.push_back(
          "no two views see the same people move: record people who walk "
          "through the room, arms moving, where two cameras and more see them");
    } else if (!Adjust()) {
      result_.used.clear();
      result_.reasons.push_back(
          "what the views show cannot be put together in one room");
    } else {
      Judge();
    }
    for (size_t v = 0; v < result_.views.size(); ++v) {
      RigView& view = result_.views[v];
      if (!view.joined && view.left_out.empty()) {
        view.left_out = "it shares no moving people with the others";
      }
    }
    return std::move(result_);
  }

 private:
  bool Start() {
    start_ = FindRigStart(recording_, intrinsics_, input_.focal_sigma);
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

  // People are as tall as people are; other bodies are seen from some metres
  // away.
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
    // Three frames at least, of which clocks tell.
    constexpr double kFrames = 2.2;
    options.segments.span_s = std::max(
        options.segments.span_s, kFrames / recording_.header.frame_rate_hz);
    options.rotation_sigma_rad = 1.0;
    options.centre_sigma_m = 10.0;
    options.focal_sigma = std::max(1e-3, input_.focal_sigma);
    options.offset_sigma_s = 0.1;
    options.drift_sigma = 2e-4;
    for (size_t v = 0; v < cameras_.size(); ++v) {
      const Camera& told = intrinsics_[result_.used[v]];
      options.focal_told.push_back(
          std::log(told.focal_px() / cameras_[v].focal_px()));
    }
    if (human_) {
      options.lasting_offset_m = kLastingOffsetM;
      options.segments.tapered = true;
    }
    // Cameras rest by then; single stretches may go on.
    options.max_iterations = 12;
    return options;
  }

  // Cameras, then clocks.
  bool Fit(int max_segments, bool clocks) {
    BundleOptions options = Options(max_segments);
    segments_ = MakeSegments(cameras_, aligned_, matches_, options.segments);
    free_ = FreeParameters();
    free_.rotation = free_.centre = true;
    free_.focal = input_.focal_sigma > 0.0;
    fit_ = AdjustBundle(cameras_, segments_, free_, NoChanges(cameras_.size()),
                        options);
    if (!fit_.usable || !clocks || !MoveEnough(segments_)) return fit_.usable;
    const FreeParameters clock = ClockParametersOf(segments_.span_s);
    options.hold_velocities = human_;
    const BundleResult late =
        AdjustBundle(cameras_, segments_, clock, fit_.changes, options);
    if (!late.usable) return true;
    for (size_t v = 0; v < cameras_.size(); ++v) {
      if (late.Sigma(v, kOffsetAt) > kMostClockS) return true;
    }
    free_.offset = clock.offset;
    free_.drift = clock.drift;
    fit_.changes = late.changes;
    return true;
  }

  // How sure cameras and clocks are together, where they are by now.
  bool Measure(int max_segments) {
    BundleOptions options = Options(max_segments);
    segments_ = MakeSegments(cameras_, aligned_, matches_, options.segments);
    options.hold_cameras = true;
    fit_ = AdjustBundle(cameras_, segments_, free_, NoChanges(cameras_.size()),
                        options);
    if (human_) fit_.covariance *= kUnmodelled;
    return fit_.usable;
  }

  // Matches, cameras and clocks in turn; false where nothing fits.
  bool Adjust() {
    double best = 0.0;
    const auto rounds = [&](int most, int segments, bool clocks,
                            const auto& match) {
      for (int round = 0; round < most; ++round) {
        const auto before = std::make_tuple(cameras_, lags_, changes_);
        match();
        if (!Fit(segments, clocks)) return false;
        Take();
        // Matches that are wrong may draw cameras away; how well all people
        // agree, whoever is matched, then tells.
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
        if (Rests(1e-3, 2e-4)) break;
      }
      return true;
    };
    constexpr int kFew = 500;
    constexpr int kMany = 3500;
    const auto by_tracklets = [&] {
      start_.lag_frames = lags_;
      matches_ = PeopleOf(recording_, start_);
    };
    const auto by_tracks = [&] {
      ScaleByStature();
      matches_ = input_.match(cameras_, aligned_);
    };
    // Clocks wait until cameras are nearly right.
    if (!rounds(1, kFew, false, by_tracklets) ||
        !rounds(12, kFew, true, by_tracklets) ||
        !rounds(4, kMany, true, by_tracks)) {
      return false;
    }
    // A clock that still moves is not told.
    if (!Rests(0.005, 1e9)) free_.offset = free_.drift = false;
    by_tracks();
    return Measure(kMany);
  }

  // Whether the last fit moved clocks and cameras by less than this.
  bool Rests(double clock_s, double rotation_rad) const {
    return std::all_of(
        fit_.changes.begin(), fit_.changes.end(), [&](const CameraChange& one) {
          return std::abs(one[kOffsetAt]) < clock_s &&
                 one.segment<3>(kRotationAt).norm() < rotation_rad;
        });
  }

  // The fit's cameras, and its clocks on the frames as they were.
  void Take() {
    for (size_t v = 0; v < fit_.changes.size(); ++v) {
      changes_[v][kOffsetAt] += fit_.changes[v][kOffsetAt];
      changes_[v][kDriftAt] += fit_.changes[v][kDriftAt];
      // Whole frames are a lag: who is who then stays with its frame.
      const double rate_hz = recording_.header.frame_rate_hz;
      const auto frames =
          static_cast<int>(std::lround(changes_[v][kOffsetAt] * rate_hz));
      lags_[v] -= frames;
      changes_[v][kOffsetAt] -= frames / rate_hz;
    }
    cameras_ = RefinedCameras(cameras_, fit_.changes);
    aligned_ = WithClocks(Realigned(used_recording_, lags_), changes_);
  }

  // How likely every joined view is as right as `calibrated` promises: the
  // share of errors drawn from the covariance that are.
  double LikelyRight() const {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
        fit_.covariance);
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
      for (const auto& places : fit_.places) {
        within = within &&
                 kDegrees * error.segment<3>(at).norm() <= kPromisedDeg &&
                 error.segment<3>(at + kCentreAt).norm() <=
                     kPromisedPlace * SizeOf(cameras_);
        at += static_cast<Eigen::Index>(places.size());
      }
      right += within ? 1 : 0;
    }
    return static_cast<double>(right) / kDraws;
  }

  double Spread(Eigen::Index begin) const {
    return std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(
                         fit_.covariance.block<3, 3>(begin, begin))
                         .eigenvalues()[2]);
  }

  // Fits on either half: how far they are apart, in what a view may be unsure,
  // and what they leave of the half that they were not given, 0 where there is
  // none.
  struct Halves {
    std::vector<double> apart;
    std::vector<double> left_out_px;
  };
  Halves HalvesOf(Halving halving) const {
    BundleOptions options = Options(1500);
    options.wants_covariance = false;
    FreeParameters free = free_;
    free.offset = free.drift = false;
    std::vector<BundleResult> fits;
    std::vector<FitError> errors;
    for (const int half : {0, 1}) {
      fits.push_back(AdjustBundle(cameras_, HalfOf(segments_, halving, half),
                                  free, NoChanges(cameras_.size()), options));
      if (!fits.back().usable) {
        return {std::vector<double>(cameras_.size(), 1e9),
                std::vector<double>(cameras_.size(), 0.0)};
      }
      errors.push_back(MeasureFit(cameras_,
                                  HalfOf(segments_, halving, 1 - half),
                                  fits.back().changes, options.segments));
    }
    Halves halves;
    for (size_t v = 0; v < cameras_.size(); ++v) {
      const CameraChange off = fits[0].changes[v] - fits[1].changes[v];
      halves.apart.push_back(std::max(
          kDegrees * off.segment<3>(kRotationAt).norm() / kMostRotationDeg,
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
    result_.recording = aligned_;
    result_.size_m = SizeOf(cameras_);
    result_.clocks_told = free_.offset;
    result_.likely_right = LikelyRight();
    const std::vector<double> agreements =
        AgreementsOfViews(cameras_, aligned_);
    const double usual = Median(agreements);
    const Halves frames = HalvesOf(Halving::kTime);
    const Halves joints = HalvesOf(Halving::kJoints);
    const Halves people = HalvesOf(Halving::kPeople);
    const FitError error = MeasureFit(
        cameras_, segments_, NoChanges(cameras_.size()), Options(0).segments);
    Eigen::Index at = 0;
    size_t sure = 0;
    for (size_t v = 0; v < cameras_.size(); ++v) {
      const auto of_recording = static_cast<size_t>(result_.used[v]);
      RigView& view = result_.views[of_recording];
      view.joined = true;
      view.rotation_sigma_deg = kDegrees * Spread(at);
      view.centre_sigma_m = Spread(at + kCentreAt);
      at += static_cast<Eigen::Index>(fit_.places[v].size());
      view.clock_s = changes_[v][kOffsetAt] -
                     lags_[v] / recording_.header.frame_rate_hz -
                     told_late_s_[of_recording];
      view.clock_sigma_s = free_.offset || v == 0
                               ? fit_.Sigma(v, kOffsetAt)
                               : kOfAFrame / recording_.header.frame_rate_hz;
      view.drift = changes_[v][kDriftAt];
      view.mean_px = error.MeanPx(static_cast<int>(v));
      view.left_out_px = {frames.left_out_px[v], joints.left_out_px[v],
                          people.left_out_px[v]};
      view.halves_apart = joints.apart[v];
      view.agreement = agreements[v];
      const bool is_sure = view.rotation_sigma_deg <= kMostRotationDeg &&
                           view.centre_sigma_m <= kMostPlace * result_.size_m &&
                           joints.apart[v] <= kMostApart && TellsFocal() &&
                           agreements[v] >= kLeastAgreement &&
                           agreements[v] >= kLeastOfUsual * usual;
      if (!is_sure) view.left_out = "its place is not sure enough";
      sure += is_sure ? 1 : 0;
    }
    Verdict(sure);
  }

  void Verdict(size_t sure) {
    const bool all = sure == result_.views.size();
    const bool right = result_.likely_right >= kLeastLikely;
    constexpr size_t kFewest = 2;
    result_.verdict = all && right      ? RigVerdict::kCalibrated
                      : sure >= kFewest ? RigVerdict::kPartly
                                        : RigVerdict::kRefused;
    if (!free_.offset) {
      result_.reasons.push_back(
          "the clocks are not told beyond whole frames: record faster motion");
    }
    if (sure < result_.views.size() && sure == cameras_.size()) {
      result_.reasons.push_back(
          "some views see nobody with the others: record people who walk where "
          "each of them and another one see them");
    }
    if (sure == cameras_.size()) {
      if (right) return;
      const std::string focal =
          input_.focal_sigma > 0.0
              ? "say focal lengths that are measured (--focal, --cameras), or "
              : "";
      result_.reasons.push_back(
          "every view has its place, but 0.3 degrees and 1 % of the rig's size "
          "are not sure: " +
          focal + "record longer, and more people");
      return;
    }
    if (!TellsFocal()) {
      result_.reasons.push_back(
          "two cameras do not tell their focal lengths: say them (--focal, "
          "--cameras), or add a third camera");
    } else if (cameras_.size() == kFewest && FaceEachOther()) {
      result_.reasons.push_back(
          "two cameras that face each other hardly tell depth: put a third one "
          "beside them");
    } else if (human_ && PlacesApart(segments_) < kOneSpotM) {
      result_.reasons.push_back(
          "people stay in one spot, where a detector's lasting errors look "
          "like cameras that are turned: record people who walk through all "
          "of the room, arms moving, for a minute");
    } else {
      result_.reasons.push_back(
          "what people do leaves cameras unsure: record people who walk "
          "through all of the room, arms moving, for a minute");
    }
  }

  // Two cameras whose axes meet, as those of a room do, fit any focal lengths
  // (Newsam et al., "Recovering Unknown Focal Lengths in Self-Calibration: An
  // Essentially Linear Algorithm and Degenerate Configurations", 1996).
  bool TellsFocal() const {
    constexpr double kNearlyKnown = 0.03;
    return cameras_.size() > 2 || input_.focal_sigma <= kNearlyKnown;
  }

  bool FaceEachOther() const {
    constexpr double kCosine = -0.94;  // of 160 degrees
    return cameras_[0].R().row(2).dot(cameras_[1].R().row(2)) < kCosine;
  }

  const RigInput& input_;
  std::vector<double> told_late_s_;
  const DetectionSequence recording_;
  const bool human_;
  const CameraRig intrinsics_;
  RigResult result_;
  // Of the joined views.
  CameraRig cameras_;
  std::vector<int> lags_;
  std::vector<CameraChange> changes_;  // clocks alone, after the lags
  DetectionSequence used_recording_;
  DetectionSequence aligned_;
  RigStart start_;
  FrozenMatches matches_;
  // The last fit.
  SceneSegments segments_;
  FreeParameters free_;
  BundleResult fit_;
};

}  // namespace

const char* ToString(RigVerdict verdict) {
  constexpr std::array kNames = {"calibrated", "partly", "refused"};
  return kNames[static_cast<size_t>(verdict)];
}

namespace {

// With left and right as the detections have them.
RigResult EstimateAsShown(const RigInput& input) {
  RigResult result = RigEstimate(input).Run();
  std::vector<int> sure;
  bool unsure = false;
  for (size_t v = 0; v < result.views.size(); ++v) {
    const RigView& view = result.views[v];
    if (view.joined && view.left_out.empty()) {
      sure.push_back(static_cast<int>(v));
    }
    unsure = unsure || (view.joined && !view.left_out.empty());
  }
  if (result.verdict != RigVerdict::kPartly || !unsure) return result;
  // Without those that may spoil it.
  RigInput part = input;
  part.detections = OfViews(input.detections, sure);
  part.intrinsics.clear();
  for (const int v : sure) {
    part.intrinsics.push_back(input.intrinsics[v]);
  }
  RigResult again = RigEstimate(part).Run();
  const bool all_sure = std::all_of(
      again.views.begin(), again.views.end(),
      [](const RigView& view) { return view.joined && view.left_out.empty(); });
  for (size_t i = 0; i < sure.size(); ++i) {
    result.views[sure[i]] = again.views[i];
  }
  for (int& v : again.used) v = sure[v];
  for (RigView& view : result.views) {
    if (!view.left_out.empty()) view.joined = false;
  }
  again.verdict = all_sure ? RigVerdict::kPartly : RigVerdict::kRefused;
  again.reasons = result.reasons;
  again.views = std::move(result.views);
  return again;
}

double SumOfAgreements(const RigResult& result) {
  double sum = 0.0;
  for (const RigView& view : result.views) {
    if (view.joined) sum += view.agreement;
  }
  return sum;
}

// Views whose left and right may be exchanged: what agrees better so, and what
// found no place.
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

}  // namespace

RigResult EstimateRig(const RigInput& input) {
  if (input.detections.frames.empty()) {
    RigResult nothing;
    nothing.views.resize(input.intrinsics.size());
    nothing.reasons.push_back("there are no detections");
    return nothing;
  }
  RigResult result = EstimateAsShown(input);
  if (result.verdict == RigVerdict::kRefused ||
      !IsHuman(input.detections.header.skeleton)) {
    return result;
  }
  const std::vector<char> views = MayBeExchanged(result);
  if (std::count(views.begin(), views.end(), 1) == 0) return result;
  RigInput exchanged = input;
  ExchangeSides(views, &exchanged.detections);
  RigResult again = EstimateAsShown(exchanged);
  if (SumOfAgreements(again) <
      SumOfAgreements(result) + AgreementGain::kLeastGain) {
    return result;
  }
  again.reasons.push_back(
      "left and right are exchanged in some views: track with " +
      ExchangeSidesFlag(views, input.detections.header.view_names));
  return again;
}

}  // namespace kinegraph
