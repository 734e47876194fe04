#include "apps/markers/marker_plots.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <set>

#include "apps/common/plot.h"
#include "apps/common/table.h"
#include "core/evaluation/mpjpe.h"

namespace kinegraph {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kPlotMm = 1000.0;
// More points of a cloud, or of a line, show nothing more.
constexpr size_t kMostPoints = 2000;

bool IsShown(const MarkerStudy& study, size_t joint) {
  const std::vector<bool>& centres = study.motion.is_centre;
  return centres[joint] ||
         std::count(centres.begin(), centres.end(), true) == 0;
}

size_t Stride(size_t count) {
  return std::max<size_t>(1, (count + kMostPoints - 1) / kMostPoints);
}

PlotSeries Level(double x_low, double x_high, double y, bool dashed) {
  PlotSeries line;
  line.x = {x_low, x_high};
  line.y = {y, y};
  line.dashed = dashed;
  line.colour = 0;
  return line;
}

// Difference against mean of each joint's place on one axis of the body,
// counted from the middle of the person's joints.
Plot BlandAltman(const MarkerStudy& study, int axis) {
  static const char* const kAxes[] = {"right", "forward", "up"};
  const PairedMotion& motion = study.motion;
  PlotSeries cloud;
  cloud.style = PlotStyle::kPoints;
  cloud.colour = 1;
  const size_t joints = motion.is_centre.size();
  const size_t stride = Stride(motion.truth.frames.size() * joints);
  for (size_t f = 0; f < motion.truth.frames.size(); f += stride) {
    const Pose3d& truth = motion.truth.frames[f].people.front().joints;
    const Pose3d& found = motion.tracks.frames[f].people.front().joints;
    const auto body = BodyFrame(truth, motion.truth.header.skeleton, study.up);
    const auto middle = MeanPosition(truth);
    if (!body || !middle) continue;
    for (size_t j = 0; j < joints; ++j) {
      if (!IsShown(study, j) || !truth[j].present() || !found[j].present()) {
        continue;
      }
      const Eigen::Vector3d a =
          body->transpose() * (truth[j].position_m - *middle);
      const Eigen::Vector3d b =
          body->transpose() * (found[j].position_m - *middle);
      cloud.x.push_back(kPlotMm * 0.5 * (a[axis] + b[axis]));
      cloud.y.push_back(kPlotMm * (b[axis] - a[axis]));
    }
  }
  Plot plot;
  plot.title = kAxes[axis];
  plot.x.label = "mean of both [mm]";
  plot.y.label = "tracks minus markers [mm]";
  plot.legend = PlotLegend::kNone;
  const JointAgreement& pooled = study.agreement.pooled;
  if (!cloud.x.empty()) {
    const auto ends = std::minmax_element(cloud.x.begin(), cloud.x.end());
    const double low = *ends.first, high = *ends.second;
    const double bias = kPlotMm * pooled.bias_m[axis];
    const double limit = kPlotMm * pooled.limits_m[axis];
    plot.title += ": bias " + Fixed(bias, 1) + " mm, limits " +
                  Fixed(bias - limit, 0) + " to " + Fixed(bias + limit, 0) +
                  " mm";
    plot.series = {std::move(cloud), Level(low, high, bias, false),
                   Level(low, high, bias - limit, true),
                   Level(low, high, bias + limit, true)};
  }
  return plot;
}

Plot ErrorsOverTime(const MarkerStudy& study) {
  const PairedMotion& motion = study.motion;
  const size_t stride = Stride(motion.truth.frames.size());
  Plot plot;
  plot.title = "Distance of tracks and markers";
  plot.x.label = "time of the markers [s]";
  plot.y.label = "distance [mm]";
  plot.y.low = 0.0;
  for (size_t j = 0; j < motion.is_centre.size(); ++j) {
    if (!IsShown(study, j)) continue;
    PlotSeries line;
    line.name = motion.truth.header.skeleton.joints()[j];
    for (size_t f = 0; f < motion.truth.frames.size(); f += stride) {
      const Joint3d& a = motion.truth.frames[f].people.front().joints[j];
      const Joint3d& b = motion.tracks.frames[f].people.front().joints[j];
      line.x.push_back(ToSeconds(motion.truth.frames[f].time));
      line.y.push_back(a.present() && b.present()
                           ? kPlotMm * (a.position_m - b.position_m).norm()
                           : kNaN);
    }
    plot.series.push_back(std::move(line));
  }
  return plot;
}

Plot CalibrationCurve(const MotionAgreement& agreement) {
  constexpr int kLevels = 20;
  Plot plot;
  plot.title = "Calibration of the ellipsoids";
  plot.x.label = "promised [%]";
  plot.y.label = "covered [%]";
  plot.x.low = plot.y.low = 0.0;
  plot.x.high = plot.y.high = 100.0;
  PlotSeries right;
  right.name = "as promised";
  right.x = right.y = {0.0, 100.0};
  right.dashed = true;
  plot.series.push_back(right);
  const struct {
    const char* name;
    const Calibration& calibration;
  } curves[] = {{"observed", agreement.observed},
                {"inferred", agreement.inferred},
                {"offset off", agreement.pooled.after_offset}};
  for (const auto& curve : curves) {
    if (curve.calibration.count() == 0) continue;
    PlotSeries line;
    line.name =
        curve.name + (", n " + std::to_string(curve.calibration.count()));
    line.style = PlotStyle::kLinePoints;
    for (int level = 1; level < kLevels; ++level) {
      const double promised = level / static_cast<double>(kLevels);
      line.x.push_back(100.0 * promised);
      line.y.push_back(100.0 * curve.calibration.Covered(promised));
    }
    plot.series.push_back(std::move(line));
  }
  return plot;
}

}  // namespace

std::vector<std::string> WriteMarkerPlots(const MarkerStudy& study,
                                          const std::string& folder) {
  std::vector<std::string> names = {"bland_altman.svg", "errors.svg"};
  WritePlot(
      {BlandAltman(study, 0), BlandAltman(study, 1), BlandAltman(study, 2)},
      folder + names[0], {1350, 420, 3});
  WritePlot({ErrorsOverTime(study)}, folder + names[1]);
  if (study.agreement.pooled.calibration.count() > 0) {
    names.emplace_back("calibration.svg");
    WritePlot({CalibrationCurve(study.agreement)}, folder + names.back());
  }
  return names;
}

TrackSequence WithMarkers(const MarkerStudy& study) {
  TrackSequence shown = study.motion.truth;
  if (study.truth.set.empty()) return shown;
  const Skeleton& skeleton = shown.header.skeleton;
  std::vector<std::string> names = skeleton.joints();
  std::set<std::string> taken(names.begin(), names.end());
  std::vector<int> markers;
  const TrackSequence& points = study.truth.points;
  for (int m = 0; m < points.header.skeleton.joint_count(); ++m) {
    const std::string& label =
        points.header.skeleton.joints()[static_cast<size_t>(m)];
    if (!taken.insert(label).second) continue;
    names.push_back(label);
    markers.push_back(m);
  }
  const JointPaths paths(points, OnlyPerson(points), markers);
  for (TrackFrame& frame : shown.frames) {
    for (size_t m = 0; m < markers.size(); ++m) {
      const auto at_m = paths.At(ToSeconds(frame.time), m);
      frame.people.front().joints.push_back(
          at_m ? Joint3d{*at_m, JointStatus::kObserved} : Joint3d{});
    }
  }
  shown.header.skeleton = Skeleton("markers", names, skeleton.bones());
  return shown;
}

}  // namespace kinegraph
