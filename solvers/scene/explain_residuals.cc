#include "solvers/scene/explain_residuals.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "solvers/scene/doctor_words.h"
#include "solvers/scene/fit_terms.h"
#include "solvers/scene/late_clocks.h"
#include "solvers/scene/refine.h"

namespace kinegraph {
namespace {

constexpr double kDegreesPerRadian = 57.29577951308232;

class Explainer {
 public:
  Explainer(const ExplainedTake& take, const BundleOptions& options,
            std::vector<CameraChange> start, std::vector<Finding>* findings)
      : take_(take),
        options_(options),
        changes_(std::move(start)),
        findings_(findings) {}

  const std::vector<CameraChange>& changes() const { return changes_; }

  // Finds what explains the residuals best and takes it; false when nothing
  // does.
  bool Explain() {
    std::vector<Explanation> explanations;
    std::vector<char> moves(take_.cameras.size(), 0);
    for (const Model& model : Models()) {
      if (auto one = FitModel(model, {})) {
        for (size_t v = 0; v < moves.size() && model.kind != "clock"; ++v) {
          moves[v] = moves[v] || one->moves[v];
        }
        explanations.push_back(*std::move(one));
      }
    }
    // Cameras that are right keep their place: those alone may move that some
    // model finds to be off.
    for (Explanation& one : explanations) {
      if (one.model.kind == "clock") continue;
      if (auto again = FitModel(one.model, moves)) one = *std::move(again);
    }
    if (explanations.empty()) return false;
    std::stable_sort(explanations.begin(), explanations.end(),
                     [](const Explanation& a, const Explanation& b) {
                       return a.gain.all.after_px < b.gain.all.after_px;
                     });
    const FitGain& best = explanations.front().gain.all;
    // Within a tenth of what is gained they fit equally.
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
    (taken.model.kind == "clock" ? clocks_done_ : cameras_done_) = true;
    changes_ = taken.fit.changes;
    return true;
  }

 private:
  struct Model {
    std::string kind;
    FreeParameters free;
  };

  std::vector<Model> Models() const {
    const FreeParameters clock = ClockParametersOf(take_.segments.span_s);
    FreeParameters shift;
    shift.shift = true;
    FreeParameters rotation;
    rotation.rotation = true;
    FreeParameters focal;
    focal.focal = true;
    FreeParameters lens;
    lens.lens = true;
    std::vector<Model> models;
    if (!clocks_done_ && MoveEnough(take_.segments))
      models.push_back({"clock", clock});
    if (!cameras_done_) {
      models.push_back({"shift", shift});
      models.push_back({"rotation", rotation});
      models.push_back({"focal_length", focal});
      models.push_back({"lens", lens});
    }
    return models;
  }

  // Root mean square distance [px] by which a change moves the points that the
  // view sees, and the same of a length of 1 m at their depth.
  void MeasureChange(size_t view, const CameraChange& change, double* moved_px,
                     double* px_per_m) const {
    double squares = 0.0;
    double scale = 0.0;
    double count = 0.0;
    for (const Stretch& segment : take_.segments.segments) {
      const Eigen::Vector3d point = PositionOf(segment);
      const bool seen =
          std::any_of(segment.measurements.begin(), segment.measurements.end(),
                      [&](const SegmentMeasurement& m) {
                        return m.view_idx == static_cast<int>(view);
                      });
      if (!seen) continue;
      const auto before = ProjectChanged(
          take_.cameras[view], CameraChange::Zero(), point, nullptr, nullptr);
      const auto after =
          ProjectChanged(take_.cameras[view], change, point, nullptr, nullptr);
      if (!before.has_value() || !after.has_value()) continue;
      squares += (*after - *before).squaredNorm();
      scale +=
          take_.cameras[view].focal_px() / take_.cameras[view].Depth(point);
      count += 1.0;
    }
    *moved_px = count > 0.0 ? std::sqrt(squares / count) : 0.0;
    *px_per_m = count > 0.0 ? scale / count : 0.0;
  }

  struct Explanation {
    Model model;
    CrossedGain gain;          // on the other half of the take
    CrossedGain other_joints;  // on the other half of the joints
    BundleResult fit;
    std::vector<char> moves;  // the views that it finds to be off
  };

  CrossedGain Cross(Halving halving, const Model& model,
                    const std::vector<char>& moves) const {
    return CrossFit(take_.cameras, take_.segments, halving, model.free,
                    changes_, options_, moves);
  }

  // Fits a model with those views free that `moves` names (empty: all).
  std::optional<Explanation> FitModel(const Model& model,
                                      const std::vector<char>& moves) const {
    Explanation one;
    one.model = model;
    one.gain = Cross(Halving::kTime, model, moves);
    if (!one.gain.all.certain()) return std::nullopt;
    one.other_joints = Cross(Halving::kJoints, model, moves);
    if (!one.other_joints.all.certain()) return std::nullopt;
    one.fit = AdjustBundle(take_.cameras, take_.segments, model.free, changes_,
                           options_, moves);
    if (!one.fit.usable) return std::nullopt;
    one.moves.assign(take_.cameras.size(), 0);
    if (model.kind == "clock") {
      MarkLate(one.fit, &one.moves);
    } else {
      MarkMoved(one, &one.moves);
    }
    if (std::count(one.moves.begin(), one.moves.end(), 1) == 0) {
      return std::nullopt;
    }
    return one;
  }

  void AddExplanation(const Explanation& one, size_t alike) {
    for (size_t v = 0; v < take_.cameras.size(); ++v) {
      if (!one.moves[v]) continue;
      const CameraChange& change = one.fit.changes[v];
      Finding finding;
      finding.camera = take_.names[v];
      finding.confidence = Shared(0.95, alike);
      finding.before_px = one.gain.views[v].before_px;
      finding.after_px = one.gain.views[v].after_px;
      if (one.model.kind != "clock") {
        finding.kind = one.model.kind;
        finding.fix = kUseCorrected;
        finding.evidence = Words(one.model.kind, change);
        findings_->push_back(finding);
        continue;
      }
      finding.fix = "--set=cameras.refine_clock=true";
      const double usual_s = UsualClock(one.fit.changes, kOffsetAt);
      if (IsLate(v, one.fit, kOffsetAt)) {
        finding.kind = "clock_offset";
        finding.evidence = Format(
            "its pictures were taken %+.1f ms from the time told, against the "
            "usual of all views",
            1e3 * (change[kOffsetAt] - usual_s));
        findings_->push_back(finding);
      }
      if (one.model.free.drift && IsLate(v, one.fit, kDriftAt)) {
        const double usual = UsualClock(one.fit.changes, kDriftAt);
        finding.kind = "clock_drift";
        finding.evidence = Format(
            "it runs %+.0f ppm against the usual of all views, %+.0f "
            "ms over the take",
            1e6 * (change[kDriftAt] - usual),
            1e3 * (change[kDriftAt] - usual) * take_.segments.span_s);
        findings_->push_back(finding);
      }
    }
  }

  bool IsLate(size_t view, const BundleResult& fit, int place) const {
    return kinegraph::IsLate(fit, view, place,
                             1.0 / std::max(1.0, take_.frame_rate_hz),
                             take_.segments.span_s);
  }

  void MarkLate(const BundleResult& fit, std::vector<char>* moves) const {
    for (size_t v = 0; v < take_.cameras.size(); ++v) {
      if (take_.strangers.count(v) > 0) continue;
      (*moves)[v] = IsLate(v, fit, kOffsetAt) || IsLate(v, fit, kDriftAt);
    }
  }

  void MarkMoved(const Explanation& one, std::vector<char>* moves) const {
    for (size_t v = 0; v < take_.cameras.size(); ++v) {
      if (take_.strangers.count(v) > 0) continue;
      CameraChange change = one.fit.changes[v] - changes_[v];
      change[kOffsetAt] = change[kDriftAt] = 0.0;
      double moved_px = 0.0;
      double px_per_m = 0.0;
      MeasureChange(v, change, &moved_px, &px_per_m);
      // A detector's joints sit this far from where they should, on average
      // over joints and directions of view: no fault of the camera.
      constexpr double kDetectorBiasM = 0.012;
      constexpr double kLeastShare = 0.05;
      const FitGain& of_view = one.gain.views[v];
      const bool worth = of_view.before_px - of_view.after_px >
                         kLeastShare * of_view.before_px;
      if (worth && of_view.certain() && one.other_joints.views[v].certain() &&
          moved_px > kDetectorBiasM * px_per_m) {
        (*moves)[v] = 1;
      }
    }
  }

  static std::string Words(const std::string& kind,
                           const CameraChange& change) {
    if (kind == "shift") {
      return Format("its image fits moved by (%+.1f, %+.1f) px",
                    change[kShiftAt], change[kShiftAt + 1]);
    }
    if (kind == "rotation") {
      return Format("it fits turned by %.2f degrees",
                    kDegreesPerRadian * change.segment<3>(kRotationAt).norm());
    }
    if (kind == "lens") {
      return Format(
          "its image fits with %+.3f more of the lens term k1: lens terms may "
          "be missing or another lens's",
          change[kLensAt]);
    }
    return Format("its focal length fits multiplied by %.4f",
                  std::exp(change[kFocalAt]));
  }

  const ExplainedTake& take_;
  const BundleOptions& options_;
  std::vector<CameraChange> changes_;
  std::vector<Finding>* findings_;
  bool clocks_done_ = false;
  bool cameras_done_ = false;
};

}  // namespace

std::vector<CameraChange> ExplainResiduals(const ExplainedTake& take,
                                           const BundleOptions& options,
                                           std::vector<CameraChange> start,
                                           std::vector<Finding>* findings) {
  Explainer explainer(take, options, std::move(start), findings);
  for (int round = 0; round < 2; ++round) {
    if (!explainer.Explain()) break;
  }
  return explainer.changes();
}

}  // namespace kinegraph
