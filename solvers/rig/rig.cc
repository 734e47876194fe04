#include "solvers/rig/rig.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/base/median.h"
#include "core/base/random.h"
#include "core/skeleton/body_joints.h"
#include "solvers/cameras/fit_error.h"
#include "solvers/cameras/fit_terms.h"
#include "solvers/cameras/refine.h"
#include "solvers/cameras/segments.h"
#include "solvers/rig/rig_start.h"
#include "solvers/rig/tracklets.h"
#include "solvers/rig/view_pairs.h"
#include "solvers/scene/clock_search.h"
#include "solvers/scene/hypothesis.h"
#include "solvers/scene/view_agreement.h"

namespace kinegraph {
namespace {

constexpr double kMinConfidence = 0.3;
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

CameraRig Magnified(const CameraRig& cameras, double factor) {
  CameraRig magnified;
  for (const Camera& camera : cameras) {
    CameraParameters parameters = camera.parameters();
    parameters.K.topLeftCorner<2, 2>() *= factor;
    magnified.emplace_back(parameters);
  }
  return magnified;
}

CameraRig Scaled(const CameraRig& cameras, double factor) {
  CameraRig scaled;
  for (const Camera& camera : cameras) {
    CameraParameters parameters = camera.parameters();
    parameters.t *= factor;
    scaled.emplace_back(parameters);
  }
  return scaled;
}

DetectionSequence OfViews(const DetectionSequence& detections,
                          const std::vector<int>& views) {
  DetectionSequence part;
  part.header = detections.header;
  part.header.view_names.clear();
  for (const int v : views) {
    part.header.view_names.push_back(
        detections.header.view_names[static_cast<size_t>(v)]);
  }
  for (const DetectionFrame& frame : detections.frames) {
    DetectionFrame kept;
    kept.frame = frame.frame;
    kept.time = frame.time;
    for (const int v : views) {
      kept.views.push_back(frame.views[static_cast<size_t>(v)]);
    }
    part.frames.push_back(std::move(kept));
  }
  return part;
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
        joints_(RigJoints(recording_.header.skeleton)),
        human_(IsHuman(recording_.header.skeleton)),
        intrinsics_(input.intrinsics) {
    result_.views.resize(intrinsics_.size());
  }

  RigResult Run() {
    if (Start() && Adjust()) Judge();
    for (size_t v = 0; v < result_.views.size(); ++v) {
      RigView& view = result_.views[v];
      if (!view.joined && view.left_out.empty()) {
        view.left_out = "it shares no moving people with the others";
      }
    }
    return std::move(result_);
  }

 private:
  // A rig put together from pairs, for one guess of the focal lengths.
  struct Guess {
    CameraRig intrinsics;
    std::vector<ViewTracklet> tracklets;
    std::vector<PairFit> pairs;
    RigStart start;
    double score = -1.0;
  };

  std::vector<Bone> RigBones() const {
    std::vector<Bone> bones;
    const auto place = [&](int joint) {
      const auto at = std::find(joints_.begin(), joints_.end(), joint);
      return at == joints_.end() ? -1 : static_cast<int>(at - joints_.begin());
    };
    for (const Bone& bone : recording_.header.skeleton.bones()) {
      if (place(bone.a) >= 0 && place(bone.b) >= 0) {
        bones.push_back({place(bone.a), place(bone.b)});
      }
    }
    return bones;
  }

  static std::vector<int> Joined(const RigStart& start) {
    std::vector<int> views;
    for (size_t v = 0; v < start.joined.size(); ++v) {
      if (start.joined[v]) views.push_back(static_cast<int>(v));
    }
    return views;
  }

  // How well each view agrees with the others, 0 .. 1 (PairAgreement::score).
  static std::vector<double> Agreements(const CameraRig& cameras,
                                        const DetectionSequence& aligned) {
    constexpr int kFrames = 80;
    std::vector<ViewPeople> people = PeopleOfViews(aligned, kMinConfidence);
    for (size_t v = 0; v < people.size(); ++v) {
      people[v] = Undistorted(people[v], cameras[v]);
    }
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

  Guess GuessAt(double magnification, std::vector<PairFit> pairs) const {
    Guess guess;
    guess.intrinsics = Magnified(intrinsics_, magnification);
    guess.tracklets =
        FollowInViews(guess.intrinsics, recording_, joints_, kMinConfidence);
    guess.pairs = std::move(pairs);
    if (input_.focal_sigma > 0.0) {
      for (PairFit& pair : guess.pairs) {
        PairPoints(guess.tracklets, pair).Refit(1.0, &pair.pose);
      }
    }
    guess.start =
        JoinPairs(guess.intrinsics, guess.tracklets, guess.pairs, RigBones());
    if (guess.start.joined_count() < 2) return guess;
    const std::vector<int> used = Joined(guess.start);
    CameraRig cameras;
    std::vector<int> lags;
    for (const int v : used) {
      cameras.push_back(guess.start.cameras[static_cast<size_t>(v)]);
      lags.push_back(guess.start.lag_frames[static_cast<size_t>(v)]);
    }
    const std::vector<double> agreements =
        Agreements(cameras, Realigned(OfViews(recording_, used), lags));
    guess.score = std::accumulate(agreements.begin(), agreements.end(), 0.0);
    return guess;
  }

  std::vector<PairFit> SearchPairs() const {
    const std::vector<ViewTracklet> tracklets =
        FollowInViews(intrinsics_, recording_, joints_, kMinConfidence);
    const auto views = static_cast<int>(intrinsics_.size());
    const MotionSignals signals(tracklets, joints_, recording_.header.skeleton,
                                views, recording_.header.frame_rate_hz);
    PairSearchOptions options;
    options.frame_rate_hz = recording_.header.frame_rate_hz;
    options.focal_sigma = input_.focal_sigma;
    options.longest_lag_s =
        std::min(options.longest_lag_s,
                 0.4 * static_cast<double>(recording_.frames.size()) /
                     options.frame_rate_hz);
    std::vector<PairFit> pairs;
    for (int a = 0; a < views; ++a) {
      for (int b = a + 1; b < views; ++b) {
        pairs.push_back(SearchViewPair(tracklets, signals, a, b, options));
      }
    }
    return pairs;
  }

  // Pairs, tree, people.
  bool Start() {
    const std::vector<PairFit> pairs = SearchPairs();
    Guess best = GuessAt(1.0, pairs);
    constexpr int kSteps = 3;  // on both sides of the guess, to two sigmas
    for (int step = -kSteps; input_.focal_sigma > 0.0 && step <= kSteps;
         ++step) {
      if (step == 0) continue;
      Guess other =
          GuessAt(std::exp(2.0 * step / kSteps * input_.focal_sigma), pairs);
      if (other.score > best.score) best = std::move(other);
    }
    if (best.start.joined_count() < 2) {
      result_.reasons.push_back(
          "no two views see the same people move: record people who walk "
          "through the room, arms moving, where two cameras and more see them");
      return false;
    }
    guess_ = std::move(best);
    result_.used = Joined(guess_.start);
    for (const int v : result_.used) {
      cameras_.push_back(guess_.start.cameras[static_cast<size_t>(v)]);
      lags_.push_back(guess_.start.lag_frames[static_cast<size_t>(v)]);
    }
    used_recording_ = OfViews(recording_, result_.used);
    aligned_ = Realigned(used_recording_, lags_);
    changes_.assign(cameras_.size(), CameraChange::Zero());
    ScaleByStature();
    return true;
  }

  // The people that the pairs of views tell, at the lags as they are by now.
  void MatchTracklets() {
    for (size_t v = 0; v < lags_.size(); ++v) {
      guess_.start.lag_frames[static_cast<size_t>(result_.used[v])] = lags_[v];
    }
    matches_ =
        PeopleOf(recording_, guess_.tracklets, guess_.pairs, guess_.start);
    for (FrozenPerson& person : matches_.people) {
      for (FrozenFrame& frame : person.frames) {
        for (FrozenDetection& one : frame.detections) {
          one.view_idx =
              static_cast<int>(std::find(result_.used.begin(),
                                         result_.used.end(), one.view_idx) -
                               result_.used.begin());
        }
      }
    }
  }

  // People are as tall as people are; other bodies are seen from some metres
  // away.
  void ScaleByStature() {
    std::vector<ViewPeople> people = PeopleOfViews(aligned_, kMinConfidence);
    for (size_t v = 0; v < people.size(); ++v) {
      people[v] = Undistorted(people[v], cameras_[v]);
    }
    constexpr int kFrames = 100;
    const Stature stature =
        StatureOf(cameras_, people, FramesToLookAt(people, kFrames),
                  recording_.header.skeleton);
    if (stature.count > 0 && stature.median_m > 0.0) {
      cameras_ = Scaled(cameras_, kStatureM / stature.median_m);
    } else if (!human_ && SizeOf(cameras_) > 0.0) {
      constexpr double kRigM = 3.0;
      cameras_ = Scaled(cameras_, kRigM / SizeOf(cameras_));
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
      const Camera& told = intrinsics_[static_cast<size_t>(result_.used[v])];
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
    const std::vector<CameraChange> none(cameras_.size(), CameraChange::Zero());
    fit_ = AdjustBundle(cameras_, segments_, free_, none, options);
    if (!fit_.usable || !clocks || !MoveEnough(segments_)) return fit_.usable;
    const FreeParameters clock = ClockParametersOf(segments_.span_s);
    options.hold_velocities = human_;
    const BundleResult late =
        AdjustBundle(cameras_, segments_, clock, fit_.changes, options);
    if (!late.usable || !ClocksTold(late)) return true;
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
    fit_ = AdjustBundle(
        cameras_, segments_, free_,
        std::vector<CameraChange>(cameras_.size(), CameraChange::Zero()),
        options);
    if (human_) fit_.covariance *= kUnmodelled;
    return fit_.usable;
  }

  // Standard deviation of a view's parameter; 0 where it is not free.
  static double SigmaOf(const BundleResult& fit, size_t view, int place) {
    Eigen::Index at = 0;
    for (size_t v = 0; v < view; ++v) {
      at += static_cast<Eigen::Index>(fit.places[v].size());
    }
    for (const int one : fit.places[view]) {
      if (one == place) return std::sqrt(fit.covariance(at, at));
      ++at;
    }
    return 0.0;
  }

  static bool ClocksTold(const BundleResult& fit) {
    for (size_t v = 0; v < fit.places.size(); ++v) {
      if (SigmaOf(fit, v, kOffsetAt) > kMostClockS) return false;
    }
    return true;
  }

  bool Adjust() {
    bool clocks = true;
    double best = 0.0;
    const auto rounds = [&](int most, int segments, const auto& match) {
      for (int round = 0; round < most; ++round) {
        const auto before = std::make_tuple(cameras_, lags_, changes_);
        match();
        if (!Fit(segments, clocks)) return false;
        Take();
        // Matches that are wrong may draw cameras away; how well all people
        // agree, whoever is matched, then tells.
        const std::vector<double> agreements = Agreements(cameras_, aligned_);
        const double sum =
            std::accumulate(agreements.begin(), agreements.end(), 0.0);
        if (sum < kLeastOfUsual * best) {
          std::tie(cameras_, lags_, changes_) = before;
          aligned_ = WithClocks(Realigned(used_recording_, lags_), changes_);
          break;
        }
        best = std::max(best, sum);
        if (Settled()) break;
      }
      return true;
    };
    constexpr int kFew = 500;
    constexpr int kMany = 3500;
    const auto by_tracklets = [&] { MatchTracklets(); };
    const auto by_tracks = [&] {
      ScaleByStature();
      matches_ = input_.match(cameras_, aligned_);
    };
    const bool usable = [&] {
      // Clocks wait until cameras are nearly right.
      clocks = false;
      if (!rounds(1, kFew, by_tracklets)) return false;
      clocks = true;
      if (!rounds(12, kFew, by_tracklets) || !rounds(4, kMany, by_tracks)) {
        return false;
      }
      // A clock that still moves is not told.
      if (!ClocksRest()) free_.offset = free_.drift = false;
      by_tracks();
      return Measure(kMany);
    }();
    return usable || Fails();
  }

  // Whether the last fit changed hardly anything.
  bool Settled() const {
    constexpr double kRotationRad = 2e-4;
    constexpr double kClockS = 1e-3;
    return std::all_of(fit_.changes.begin(), fit_.changes.end(),
                       [](const CameraChange& change) {
                         return change.segment<3>(kRotationAt).norm() <
                                    kRotationRad &&
                                std::abs(change[kOffsetAt]) < kClockS;
                       });
  }

  bool ClocksRest() const {
    constexpr double kMostStepS = 0.005;
    return std::all_of(fit_.changes.begin(), fit_.changes.end(),
                       [](const CameraChange& change) {
                         return std::abs(change[kOffsetAt]) < kMostStepS;
                       });
  }

  bool Fails() {
    result_.used.clear();
    result_.reasons.push_back(
        "what the views show cannot be put together in one room");
    return false;
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
    const std::vector<CameraChange> none(cameras_.size(), CameraChange::Zero());
    std::vector<BundleResult> fits;
    std::vector<FitError> errors;
    for (const int half : {0, 1}) {
      fits.push_back(AdjustBundle(cameras_, HalfOf(segments_, halving, half),
                                  free, none, options));
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
    const std::vector<double> agreements = Agreements(cameras_, aligned_);
    const double usual = Median(agreements);
    const Halves frames = HalvesOf(Halving::kTime);
    const Halves joints = HalvesOf(Halving::kJoints);
    const Halves people = HalvesOf(Halving::kPeople);
    const FitError error = MeasureFit(
        cameras_, segments_,
        std::vector<CameraChange>(cameras_.size(), CameraChange::Zero()),
        Options(0).segments);
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
                               ? SigmaOf(fit_, v, kOffsetAt)
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
  const std::vector<int> joints_;
  const bool human_;
  const CameraRig intrinsics_;
  RigResult result_;
  // Of the joined views.
  CameraRig cameras_;
  std::vector<int> lags_;
  std::vector<CameraChange> changes_;  // clocks alone, after the lags
  DetectionSequence used_recording_;
  DetectionSequence aligned_;
  Guess guess_;
  FrozenMatches matches_;
  // The last fit.
  SceneSegments segments_;
  FreeParameters free_;
  BundleResult fit_;
};

}  // namespace

const char* ToString(RigVerdict verdict) {
  switch (verdict) {
    case RigVerdict::kCalibrated:
      return "calibrated";
    case RigVerdict::kPartly:
      return "partly";
    case RigVerdict::kRefused:
      return "refused";
  }
  return "";
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
    part.intrinsics.push_back(input.intrinsics[static_cast<size_t>(v)]);
  }
  RigResult again = RigEstimate(part).Run();
  const bool all_sure = std::all_of(
      again.views.begin(), again.views.end(),
      [](const RigView& view) { return view.joined && view.left_out.empty(); });
  for (size_t i = 0; i < sure.size(); ++i) {
    result.views[static_cast<size_t>(sure[i])] = again.views[i];
  }
  for (int& v : again.used) v = sure[static_cast<size_t>(v)];
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
      FramesToLookAt(PeopleOfViews(result.recording, kMinConfidence), kFrames);
  const ExchangedSides found =
      FindExchangedSides(result.cameras, FramesOf(result.recording, frames));
  std::vector<char> views;
  for (const RigView& view : result.views) views.push_back(!view.joined);
  for (size_t v = 0; v < result.used.size(); ++v) {
    views[static_cast<size_t>(result.used[v])] =
        found.gain.is_enough() && found.views[v];
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
