#include "apps/compare/shift.h"

#include <algorithm>
#include <utility>

#include "core/evaluation/statistics.h"
#include "core/tracking/replay.h"

namespace kinegraph {
namespace {

constexpr int kMaxRounds = 50;
constexpr double kSettledPx = 0.01;
// Two views agree on almost any point: their residuals tell little.
constexpr int kMinViews = 3;

// Residuals of one view, by coordinate.
struct Residuals {
  std::vector<double> x, y;
};

std::vector<Residuals> ResidualsOf(const FrozenRun& run,
                                   const std::vector<ReplayedPerson>& people,
                                   const FrameRange& frames) {
  std::vector<Residuals> views(run.scene.view_names.size());
  for (const ReplayedPerson& person : people) {
    for (const EstimatorFrame& frame : person.frames) {
      if (!frame.has_initial || !frames.Contains(frame.frame)) continue;
      for (const FreshView& view : frame.views) {
        const Camera& camera = run.scene.model.cameras[view.view_idx];
        for (size_t j = 0; j < frame.initial.size(); ++j) {
          if (frame.inlier_views[j] < kMinViews ||
              frame.initial[j].status != JointStatus::kObserved ||
              view.verdicts[j] != FilterVerdict::kKept) {
            continue;
          }
          const auto pixel = camera.Project(frame.initial[j].position_m);
          if (!pixel.has_value()) continue;
          const Eigen::Vector2d residual = view.joints[j].px - *pixel;
          views[view.view_idx].x.push_back(residual.x());
          views[view.view_idx].y.push_back(residual.y());
        }
      }
    }
  }
  return views;
}

}  // namespace

std::vector<Eigen::Vector2d> FitShifts(const FrozenRun& run,
                                       const RunOptions& options,
                                       const FrameRange& frames, int threads) {
  std::vector<Eigen::Vector2d> shifts_px(run.scene.view_names.size(),
                                         Eigen::Vector2d::Zero());
  for (int round = 0; round < kMaxRounds; ++round) {
    const DetectionSequence shifted = Shifted(run.detections, shifts_px);
    const Replay replay(run.scene.model, shifted, run.matches,
                        run.scale.IntoRun(options).tracker,
                        FeedbackOf(options));
    double moved_px = 0.0;
    const std::vector<Residuals> residuals =
        ResidualsOf(run, replay.Prepare(-1, threads), frames);
    for (size_t view = 0; view < residuals.size(); ++view) {
      if (residuals[view].x.empty()) continue;
      const Eigen::Vector2d median(Quantile(residuals[view].x, 0.5),
                                   Quantile(residuals[view].y, 0.5));
      shifts_px[view] += median;
      moved_px = std::max(moved_px, median.norm());
    }
    if (moved_px < kSettledPx) break;
  }
  return shifts_px;
}

DetectionSequence Shifted(DetectionSequence detections,
                          const std::vector<Eigen::Vector2d>& shifts_px) {
  for (DetectionFrame& frame : detections.frames) {
    for (size_t view = 0; view < frame.views.size(); ++view) {
      for (Detection& detection : frame.views[view].detections) {
        for (Keypoint& joint : detection.joints) joint.px -= shifts_px[view];
      }
    }
  }
  return detections;
}

}  // namespace kinegraph
