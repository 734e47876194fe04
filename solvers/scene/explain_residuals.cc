// Finds the individual cameras and clocks whose errors explain the residuals of
// the matches.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "core/base/constants.h"
#include "core/evaluation/statistics.h"
#include "solvers/cameras/refine.h"
#include "solvers/scene/hypothesis.h"

namespace kinegraph {
namespace {

// Fractions of the subject's size (1.7 m for a person). Persistent biases of
// detectors by joint: medians of 10 to 39 mm, 90th percentiles of 30 to 86 mm.
constexpr double kLeastBias = 0.007;  // averaged over joints
constexpr double kUsualBias = 0.015;  // typical of one joint
constexpr double kBeyondBias = 0.09;  // exceeds the bias of any joint
// Spread of the positions, also relative to the size, above which people count
// as walking.
constexpr double kWalkingSpread = 0.2;
// Significance threshold in standard deviations of the bias averaged over
// joints and people.
constexpr double kBiasSigmas = 3.0;
// Fractions of the persistent error that a change must explain, and that it
// must remove for a view to be cross-validated.
constexpr double kLeastExplained = 0.4;
constexpr double kLeastRemoved = 0.2;
constexpr double kInsignificantConfidence = 0.3;
constexpr char kWithinStated[] =
    "; this is within the stated uncertainty of the calibration";

// Size of the subjects, from their boxes in the images and their distance [m].
double SubjectSize(const SetUp& set_up) {
  std::vector<double> sizes_m;
  for (size_t v = 0; v < set_up.cameras.size(); ++v) {
    std::vector<double> sizes_px;
    for (const auto& frame : set_up.raw[v].frames) {
      for (const auto& person : frame) sizes_px.push_back(person.size_px);
    }
    std::vector<double> depths_m;
    for (const MotionSegment& segment : set_up.segments.segments) {
      depths_m.push_back(set_up.cameras[v].Depth(PositionOf(segment)));
    }
    if (sizes_px.empty()) continue;
    sizes_m.push_back(Quantile(std::move(sizes_px), 0.5) *
                      Quantile(std::move(depths_m), 0.5) /
                      set_up.cameras[v].focal_px());
  }
  return sizes_m.empty() ? 1.7 : Quantile(std::move(sizes_m), 0.5);
}

bool Sees(const MotionSegment& segment, size_t view) {
  return std::any_of(segment.measurements.begin(), segment.measurements.end(),
                     [&](const SegmentMeasurement& m) {
                       return m.view_idx == static_cast<int>(view);
                     });
}

class Explainer {
 public:
  explicit Explainer(const SetUp& set_up)
      : set_up_(set_up),
        cameras_(set_up.cameras),
        segments_(set_up.segments),
        options_(set_up.options.bundle),
        changes_(NoChanges(set_up.cameras.size())),
        subject_m_(SubjectSize(set_up)) {}

  const std::vector<Finding>& findings() const { return findings_; }
  const std::vector<CameraChange>& changes() const { return changes_; }

  // Applies the model that explains the residuals best. False if none does, or
  // if the best one cannot be distinguished from the detector's bias.
  bool Explain() {
    std::vector<Explanation> explanations;
    std::vector<Explanation> doubtful;
    for (const Model& model : Models()) {
      auto one = FitModel(model);
      if (!one.has_value()) continue;
      (one->doubt.empty() ? explanations : doubtful).push_back(*std::move(one));
    }
    const auto fits_better = [](const Explanation& a, const Explanation& b) {
      return a.gain.all.after_px < b.gain.all.after_px;
    };
    std::stable_sort(explanations.begin(), explanations.end(), fits_better);
    const auto likely =
        std::min_element(doubtful.begin(), doubtful.end(), fits_better);
    // Reported once, for the candidate that would explain most; if it is
    // uncertain, so are the candidates that explain less.
    if (likely != doubtful.end() &&
        (explanations.empty() || fits_better(*likely, explanations.front()))) {
      if (!mentioned_) AddExplanation(*likely, 1);
      mentioned_ = true;
      return false;
    }
    if (explanations.empty()) return false;
    const FitGain& best = explanations.front().gain.all;
    // Models whose residuals differ by less than a tenth of the best gain count
    // as equally good.
    constexpr double kEqual = 0.1;
    const double limit_px =
        best.after_px + kEqual * (best.before_px - best.after_px);
    size_t alike = 0;
    while (alike < explanations.size() &&
           explanations[alike].gain.all.after_px <= limit_px) {
      ++alike;
    }
    for (size_t e = 0; e < alike; ++e) {
      AddExplanation(explanations[e], alike);
    }
    const Explanation& taken = explanations.front();
    (IsClock(taken.model) ? clocks_done_ : cameras_done_) = true;
    for (size_t v = 0; v < changes_.size(); ++v) {
      const CameraChange& change = taken.fit.changes[v];
      if (taken.moves[v] && !IsStated(v, change - changes_[v])) {
        changes_[v] = change;
      }
    }
    return true;
  }

 private:
  struct Model {
    std::string kind;
    FreeParameters free;
  };

  std::vector<Model> Models() const {
    const auto with = [](bool FreeParameters::*parameter) {
      FreeParameters free;
      free.*parameter = true;
      return free;
    };
    std::vector<Model> models;
    // A velocity needs at least three images per segment.
    const bool has_speeds = segments_.frame_s <= 0.5 * options_.segments.span_s;
    if (!clocks_done_ && has_speeds && MoveEnough(segments_)) {
      models.push_back({"clock", ClockParametersOf(segments_.span_s)});
    }
    if (!cameras_done_) {
      models.push_back({"shift", with(&FreeParameters::shift)});
      models.push_back({"rotation", with(&FreeParameters::rotation)});
      models.push_back({"focal_length", with(&FreeParameters::focal)});
      models.push_back({"lens", with(&FreeParameters::lens)});
    }
    return models;
  }

  struct Explanation {
    Model model;
    CrossedGain gain;  // on the held-out halves of the recording
    BundleResult fit;
    std::vector<char> moves;  // the views found to be wrong
    // Why it cannot be distinguished from the detector's bias; empty if it can.
    std::string doubt;
  };

  static bool IsClock(const Model& model) { return model.kind == "clock"; }

  // A spurious clock error is recognised only at convergence, where it lies far
  // outside the plausible range, so clocks get the full number of iterations.
  BundleOptions OptionsOf(const Model& model) const {
    BundleOptions options = options_;
    if (IsClock(model)) options.max_iterations = BundleOptions().max_iterations;
    return options;
  }

  CrossedGain Cross(Halving halving, const Model& model,
                    const std::vector<char>& moves) const {
    return CrossFit(cameras_, segments_, halving, model.free, changes_,
                    OptionsOf(model), moves);
  }

  BundleResult Fit(const Model& model, const std::vector<char>& moves) const {
    return AdjustBundle(cameras_, segments_, model.free, changes_,
                        OptionsOf(model), moves);
  }

  // Fits a model to all views and determines the wrong ones. Camera models are
  // then usually fitted again with only these views free, so that correct
  // cameras keep their parameters.
  std::optional<Explanation> FitModel(const Model& model) const {
    Explanation one;
    one.model = model;
    one.fit = Fit(model, {});
    if (!one.fit.usable) return std::nullopt;
    for (size_t v = 0; v < cameras_.size(); ++v) {
      one.moves.push_back(set_up_.strangers.count(v) == 0);
    }
    return IsClock(model) ? Clock(std::move(one)) : Cameras(std::move(one));
  }

  // Unflags the views for which `holds` is false; returns whether any remain.
  template <typename Holds>
  static bool Keep(std::vector<char>* views, const Holds& holds) {
    for (size_t v = 0; v < views->size(); ++v) {
      (*views)[v] = (*views)[v] && holds(v);
    }
    return std::count(views->begin(), views->end(), 1) > 0;
  }

  // A clock counts as wrong only if it still deviates when cameras may rotate
  // freely: if people turn round, a wrongly oriented camera resembles a clock
  // error.
  std::optional<Explanation> Clock(Explanation one) const {
    const auto is_late = [&](const BundleResult& fit) {
      return [this, &fit](size_t v) {
        return IsLate(v, fit, kOffsetAt) || IsLate(v, fit, kDriftAt);
      };
    };
    if (!Keep(&one.moves, is_late(one.fit))) return std::nullopt;
    Model beside = one.model;
    beside.free.rotation = true;
    if (!Keep(&one.moves, is_late(Fit(beside, {})))) return std::nullopt;
    one.gain = Cross(Halving::kTime, one.model, {});
    // The fit of at least one deviating view must improve clearly, because a
    // person walking in one direction confounds a clock error and a bias.
    constexpr double kLeastOfLate = 0.1;
    std::vector<char> gaining = one.moves;
    const bool holds = one.gain.all.certain() &&
                       Cross(Halving::kJoints, one.model, {}).all.certain() &&
                       Keep(&gaining, [&](size_t v) {
                         return one.gain.views[v].certain() &&
                                one.gain.views[v].explained() > kLeastOfLate;
                       });
    if (!holds) return std::nullopt;
    return one;
  }

  std::optional<Explanation> Cameras(Explanation one) const {
    const auto moved = [&](size_t v) {
      return MovedM(v, one.fit) > kLeastBias * subject_m_;
    };
    if (!Keep(&one.moves, moved)) return std::nullopt;
    if (one.model.free.lens && BendAlike(one.fit)) {
      one.gain = Cross(Halving::kTime, one.model, one.moves);
      const bool holds = one.gain.all.certain() &&
                         Cross(OfBody(), one.model, one.moves).all.certain();
      if (holds) return one;
    }
    const bool all = std::count(one.moves.begin(), one.moves.end(), 0) == 0;
    if (!all) one.fit = Fit(one.model, one.moves);  // else the fit is unchanged
    if (!one.fit.usable) return std::nullopt;
    const auto fit_of = [&](const std::vector<CameraChange>& changes) {
      return MeasureFit(cameras_, segments_, changes, options_.segments);
    };
    const FitError before = fit_of(changes_);
    const FitError after = fit_of(one.fit.changes);
    // Cross-validation cannot gain more than the fit to all data, so views that
    // gain little here are not cross-validated.
    if (!Keep(&one.moves, [&](size_t v) {
          return after.LastingM(v) < (1.0 - kLeastRemoved) * before.LastingM(v);
        })) {
      return std::nullopt;
    }
    const std::vector<char> tried = one.moves;
    one.gain = Cross(Halving::kTime, one.model, tried);
    if (!Keep(&one.moves, [&](size_t v) {
          return one.gain.views[v].is_enough() && moved(v);
        })) {
      return std::nullopt;
    }
    const CrossedGain joints = Cross(OfBody(), one.model, tried);
    if (!Keep(&one.moves,
              [&](size_t v) { return joints.views[v].certain(); })) {
      return std::nullopt;
    }
    return BeatsBias(std::move(one), tried, joints);
  }

  // Whether the changes of k1 look like a distortion that the calibration omits
  // in all cameras. Cameras of one model have similar distortion, unlike biases
  // of a detector: the standard deviation is below a quarter of the mean. False
  // for fewer than three views.
  bool BendAlike(const BundleResult& fit) const {
    constexpr double kAlike = 0.25;
    const auto count = static_cast<Eigen::Index>(changes_.size());
    Eigen::ArrayXd k1(count);
    for (Eigen::Index v = 0; v < count; ++v) {
      k1[v] = fit.changes[v][kLensAt] - changes_[v][kLensAt];
    }
    const double variance =
        (k1 - k1.mean()).square().sum() / static_cast<double>(count - 1);
    return count >= 3 && std::sqrt(variance) < kAlike * std::abs(k1.mean());
  }

  Halving OfBody() const {
    return HasBoth() ? Halving::kBody : Halving::kJoints;
  }

  // Each joint has its own bias in each view throughout a recording
  // (docs/doctor.md): a change of a camera must explain more than that, at
  // joints, times and positions to which it was not fitted. Returns the
  // explanation for the views for which it does; if there are none, for all
  // candidates, with the doubt.
  Explanation BeatsBias(Explanation one, const std::vector<char>& tried,
                        const CrossedGain& joints) const {
    std::vector<CrossedGain> gains = {one.gain, joints};
    const bool people_walk =
        PlacesApart(segments_) > kWalkingSpread * subject_m_;
    if (people_walk) gains.push_back(Cross(Halving::kPlaces, one.model, tried));
    const bool bias_averages_out = people_walk && !OneClassDecides();
    std::vector<char> significant(tried.size(), 0);
    std::vector<double> needed_m(tried.size(), 0.0);
    std::string doubt;
    for (size_t v = 0; v < significant.size(); ++v) {
      if (!one.moves[v]) continue;
      double explained = 1.0;
      for (const CrossedGain& gain : gains) {
        explained = std::min(explained, gain.views[v].explained());
      }
      const double bias_m =
          std::max(kUsualBias * subject_m_, one.gain.views[v].lasting_after_m);
      needed_m[v] = bias_averages_out
                        ? kBiasSigmas * bias_m / std::sqrt(CellCount(v))
                        : kBeyondBias * subject_m_;
      const double moved_m = MovedM(v, one.fit);
      significant[v] = explained > kLeastExplained && moved_m > needed_m[v];
      if (!significant[v] && doubt.empty()) {
        doubt = moved_m > needed_m[v]
                    ? fmt::format(
                          "it explains only {:.0f} % of the persistent "
                          "residual at held-out joints, times and positions",
                          100.0 * std::max(0.0, explained))
                : !people_walk      ? "people stay in one place"
                : OneClassDecides() ? "the evidence comes from one group of "
                                      "joints only (legs or upper body)"
                                    : "detector bias alone could be as large";
      }
    }
    if (std::count(significant.begin(), significant.end(), 1) == 0) {
      one.doubt = doubt;
      return one;
    }
    // A camera that compensated for faults of other cameras needs no change
    // once these are corrected.
    do {
      one.moves = significant;
      const BundleResult again = Fit(one.model, significant);
      if (again.usable) one.fit = again;
      if (!Keep(&significant,
                [&](size_t v) { return MovedM(v, one.fit) > needed_m[v]; })) {
        one.doubt = "detector bias alone could be as large";
        break;
      }
    } while (significant != one.moves);
    return one;
  }

  // Fraction of the segments that belong to hips and legs.
  double LowerShare() const {
    const double all = static_cast<double>(segments_.segments.size());
    const SceneSegments lower = HalfOf(segments_, Halving::kBody, 0);
    return static_cast<double>(lower.segments.size()) / all;
  }
  bool HasBoth() const {
    constexpr double kLeast = 0.15;
    const double lower = LowerShare();
    return lower > kLeast && lower < 1.0 - kLeast;
  }
  // Whether hardly anything but legs, or hardly anything but the rest of the
  // body, is seen. False for skeletons without hip joints, which need not be
  // bodies with legs.
  bool OneClassDecides() const {
    const auto& classes = segments_.classes;
    return !HasBoth() &&
           std::any_of(classes.begin(), classes.end(),
                       [](JointClass one) { return one == JointClass::kHip; });
  }

  // Number of independent biases of a view: joint classes (each joint of no
  // class counts as one), times people (at most three are counted).
  double CellCount(size_t view) const {
    std::set<int> classes;
    std::map<int, int> people;
    for (const MotionSegment& segment : segments_.segments) {
      if (!Sees(segment, view)) continue;
      const auto joint = static_cast<size_t>(segment.joint);
      const JointClass of = segments_.classes[joint];
      classes.insert(of == JointClass::kOther ? 100 + segment.joint
                                              : static_cast<int>(of));
      ++people[segment.person];
    }
    constexpr int kMost = 3;  // people share part of a detector's bias
    return static_cast<double>(classes.size()) *
           std::min<double>(kMost, static_cast<double>(people.size()));
  }

  // RMS displacement of the view's observations by a fit's change, at their
  // depth [m].
  double MovedM(size_t view, const BundleResult& fit) const {
    const CameraChange change = fit.changes[view] - changes_[view];
    const Camera& camera = cameras_[view];
    double squares = 0.0;
    double scale = 0.0;
    double count = 0.0;
    for (const MotionSegment& segment : segments_.segments) {
      if (!Sees(segment, view)) continue;
      const Eigen::Vector3d point = PositionOf(segment);
      const auto before = camera.Project(point);
      const auto after = ProjectChanged(camera, change, point);
      if (!before.has_value() || !after.has_value()) continue;
      squares += (*after - *before).squaredNorm();
      scale += camera.focal_px() / camera.Depth(point);
      count += 1.0;
    }
    return count > 0.0 ? std::sqrt(squares / count) / (scale / count) : 0.0;
  }

  void AddExplanation(const Explanation& one, size_t alike) {
    for (size_t v = 0; v < cameras_.size(); ++v) {
      if (!one.moves[v]) continue;
      const CameraChange& change = one.fit.changes[v];
      Finding finding;
      finding.camera = set_up_.CameraName(v);
      finding.significant =
          one.doubt.empty() && !IsStated(v, change - changes_[v]);
      finding.confidence =
          finding.significant ? Shared(0.95, alike) : kInsignificantConfidence;
      finding.before_px = one.gain.views[v].before_px;
      finding.after_px = one.gain.views[v].after_px;
      if (!IsClock(one.model)) {
        finding.kind = one.model.kind;
        finding.fix = kUseCorrected;
        finding.evidence = Words(one.model.kind, change);
        if (!one.doubt.empty()) {
          finding.evidence +=
              "; this cannot be distinguished from the detector's bias: " +
              one.doubt;
          finding.fix =
              "record a person walking through the whole room, or a "
              "calibration board, and run `kinegraph doctor` again";
        } else if (!finding.significant) {
          finding.evidence += kWithinStated;
        }
        findings_.push_back(finding);
        continue;
      }
      finding.fix = kRefineClocks;
      for (const int place : {kOffsetAt, kDriftAt}) {
        if (!IsLate(v, one.fit, place)) continue;
        const double late = change[place] - UsualClock(one.fit.changes, place);
        finding.kind = place == kOffsetAt ? "clock_offset" : "clock_drift";
        finding.evidence =
            place == kOffsetAt
                ? fmt::format(
                      "its images were captured {:+.1f} ms from their "
                      "timestamps, relative to the median over all views",
                      1e3 * late)
                : fmt::format(
                      "its clock drifts by {:+.0f} ppm relative to the median "
                      "over all views, {:+.0f} ms over the recording",
                      1e6 * late, 1e3 * late * segments_.span_s);
        if (!finding.significant) finding.evidence += kWithinStated;
        findings_.push_back(finding);
      }
    }
  }

  // Whether a change is within the uncertainty that the calibration itself
  // reports; such a change is mentioned but not applied.
  bool IsStated(size_t view, const CameraChange& change) const {
    constexpr double kSigmas = 3.0;
    const std::vector<CameraChange>& stated = set_up_.input.stated_sigma;
    if (stated.empty() || stated[view].isZero()) return false;
    return (change.array().abs() <= kSigmas * stated[view].array()).all();
  }

  bool IsLate(size_t view, const BundleResult& fit, int place) const {
    return kinegraph::IsLate(fit, view, place,
                             1.0 / std::max(1.0, set_up_.rate_hz),
                             segments_.span_s);
  }

  static std::string Words(const std::string& kind,
                           const CameraChange& change) {
    if (kind == "shift") {
      return fmt::format(
          "the data fit better with its principal point shifted by ({:+.1f}, "
          "{:+.1f}) px",
          change[kShiftAt], change[kShiftAt + 1]);
    }
    if (kind == "rotation") {
      return fmt::format(
          "the data fit better with the camera rotated by {:.2f} degrees",
          kDegPerRad * change.segment<3>(kRotationAt).norm());
    }
    if (kind == "lens") {
      return fmt::format(
          "the data fit better with k1 changed by {:+.3f}: distortion "
          "coefficients may be missing or belong to another lens",
          change[kLensAt]);
    }
    return fmt::format(
        "the data fit better with its focal length multiplied by {:.4f}",
        std::exp(change[kFocalAt]));
  }

  const SetUp& set_up_;
  const CameraRig& cameras_;
  const SceneSegments& segments_;
  const BundleOptions& options_;
  std::vector<CameraChange> changes_;
  const double subject_m_;  // size of the subjects
  std::vector<Finding> findings_;
  bool clocks_done_ = false;
  bool cameras_done_ = false;
  bool mentioned_ = false;
};

}  // namespace

// Fits each kind of fault (a clock, a shifted image, a rotated camera, another
// focal length or lens) to each half of the recording, evaluates it on the
// other half, and applies the kind that explains most.
//
// With a single walking person, a clock offset is indistinguishable from a
// shifted image, so clocks and cameras compete: the fault that explains most is
// corrected first, and the other may explain the remaining residuals.
std::optional<Answer> AskResiduals(const SetUp& set_up) {
  Explainer explainer(set_up);
  for (int round = 0; round < 2; ++round) {
    if (!explainer.Explain()) break;
  }
  Answer answer;
  answer.findings = explainer.findings();
  answer.cameras = RefinedCameras(set_up.cameras, explainer.changes());
  answer.segments = set_up.segments;  // the last stage: no new matches needed
  return answer;
}

}  // namespace kinegraph
