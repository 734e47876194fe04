#include "core/data/checks.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <unordered_set>

#include "core/base/error.h"
#include "core/data/limits.h"

namespace kinegraph {
namespace {

constexpr double kLongestLagS = 10.0;

void CheckCount(const std::string& of, const char* what, size_t found,
                size_t expected) {
  if (found == expected) return;
  throw InputError(of + ": found " + std::to_string(found) + " " + what +
                   ", expected " + std::to_string(expected));
}

// Throws if `name` occurs a second time. `of`: the kind of names, such as
// "views".
void CheckName(const std::string& of, const std::string& name,
               std::unordered_set<std::string>* seen) {
  if (seen->insert(name).second) return;
  throw InputError(of + ": '" + Printable(name) + "' appears twice");
}

}  // namespace

void CheckFrameRate(double rate_hz, std::string_view key) {
  if (rate_hz >= 0.0 && rate_hz <= kMaxFrameRate_hz) return;
  throw InputError(
      std::string(key) +
      ": is out of range, expected a rate above 0 and at most 1e6 Hz");
}

TimeNs CheckedTime(double seconds, std::string_view key) {
  if (!(std::abs(seconds) <= kMaxTime_s)) {
    throw InputError(std::string(key) +
                     ": is out of range, expected seconds, at most 4.6e9 (not "
                     "milliseconds)");
  }
  return FromSeconds(seconds);
}

void CheckDetectionHeader(const DetectionHeader& header) {
  if (header.view_names.empty()) throw InputError("views: is empty");
  std::unordered_set<std::string> seen;
  for (const std::string& name : header.view_names) {
    CheckName("views", name, &seen);
  }
  CheckFrameRate(header.frame_rate_hz, "frame_rate");
}

void CheckCameraNames(const CameraRig& cameras) {
  std::unordered_set<std::string> seen;
  for (const Camera& camera : cameras) {
    if (camera.name().empty()) throw InputError("a camera has an empty name");
    CheckName("cameras", camera.name(), &seen);
  }
}

void CheckCaptureTime(const std::string& view, TimeNs capture_time,
                      TimeNs frame_time) {
  // In doubles: the difference of two arbitrary times may not fit a TimeNs.
  const double lag_s = ToSeconds(capture_time) - ToSeconds(frame_time);
  if (std::abs(lag_s) <= kLongestLagS) return;
  throw InputError("view_times: '" + Printable(view) + "' has " +
                   std::to_string(ToSeconds(capture_time)) +
                   " s in a frame of " + std::to_string(ToSeconds(frame_time)) +
                   " s, expected clocks within 10 s of each other");
}

void CheckDetectionFrame(const DetectionHeader& header,
                         const DetectionFrame& frame) {
  const std::string name = "frame " + std::to_string(frame.frame);
  CheckCount(name, "views", frame.views.size(), header.view_names.size());
  if (frame.frame < 0 || frame.frame > kMaxFrame) {
    throw InputError(name + ": is out of range, expected 0 .. 2^50");
  }
  CheckedTime(ToSeconds(frame.time), name + ": time");
  const auto joints = static_cast<size_t>(header.skeleton.joint_count());
  for (size_t v = 0; v < frame.views.size(); ++v) {
    const ViewDetections& view = frame.views[v];
    const std::string& view_name = header.view_names[v];
    CheckCaptureTime(view_name, view.capture_time, frame.time);
    for (const Detection& detection : view.detections) {
      const auto of = [&] {
        return name + ", view '" + Printable(view_name) + "'";
      };
      if (detection.joints.size() != joints) {
        CheckCount(of(), "joints", detection.joints.size(), joints);
      }
      for (const Keypoint& joint : detection.joints) {
        if (!joint.found ||
            (joint.px.allFinite() && std::isfinite(joint.confidence))) {
          continue;
        }
        throw InputError(of() + ": a joint that was found is not finite");
      }
    }
  }
}

namespace {

// Positions beyond a billion times the extent are overflows.
constexpr double kFarthest = 1e9;  // times the extent of the cameras
// Relative to the largest entry: rounding of sums and products.
constexpr double kRounding = 1e-9;

bool IsCovariance(const Eigen::Matrix3d& covariance) {
  if (!covariance.allFinite()) return false;
  const double slack = kRounding * covariance.cwiseAbs().maxCoeff();
  if (!((covariance - covariance.transpose()).cwiseAbs().maxCoeff() <= slack)) {
    return false;
  }
  // The cheap test first; the eigenvalues accept a covariance of lower rank.
  if (Eigen::LLT<Eigen::Matrix3d>(covariance).info() == Eigen::Success) {
    return true;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
      covariance, Eigen::EigenvaluesOnly);
  return covariance.trace() > 0.0 && solver.eigenvalues().minCoeff() >= -slack;
}

}  // namespace

PoseCheck::PoseCheck(const CameraRig& cameras) {
  for (const Camera& camera : cameras) {
    centre_m_ += camera.centre() / static_cast<double>(cameras.size());
  }
  for (const Camera& camera : cameras) {
    farthest_m_ =
        std::max(farthest_m_, kFarthest * (camera.centre() - centre_m_).norm());
  }
  // Coincident cameras have no extent.
  if (farthest_m_ == 0.0) farthest_m_ = std::numeric_limits<double>::max();
}

void PoseCheck::Require(const TrackHeader& header,
                        const TrackFrame& frame) const {
  for (const PersonPose& person : frame.people) {
    const auto fail = [&](size_t j, const char* what) {
      throw std::logic_error("frame " + std::to_string(frame.frame) +
                             ", person " + std::to_string(person.id.value()) +
                             ", " + header.skeleton.joints()[j] + ": " + what +
                             "; this is a bug in kinegraph, please report "
                             "it with the recording");
    };
    for (size_t j = 0; j < person.joints.size(); ++j) {
      const Joint3d& joint = person.joints[j];
      if (!joint.present()) continue;
      // Written so that NaN fails.
      if (!((joint.position_m - centre_m_).norm() <= farthest_m_)) {
        fail(j, "the position is far outside the scene");
      }
    }
    for (size_t j = 0; j < person.covariances.size(); ++j) {
      if (!person.covariances[j].has_value()) continue;
      if (!IsCovariance(*person.covariances[j])) {
        fail(j, "the covariance is not positive semidefinite");
      }
    }
  }
}

}  // namespace kinegraph
