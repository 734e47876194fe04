#include "solvers/scene/readings.h"

#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

namespace kinegraph {
const char* Describe(PoseReading reading) {
  switch (reading) {
    case PoseReading::kAsRead:
      return "world to camera, as read";
    case PoseReading::kInverse:
      return "camera to world";
    case PoseReading::kCentre:
      return "the translation is the camera's place in the world";
    case PoseReading::kTranslation:
      return "the camera's place is a translation";
    case PoseReading::kTransposed:
      return "rows of the rotation are columns";
    case PoseReading::kTransposedCentre:
      return "rows of the rotation are columns, and the translation is the "
             "camera's place";
    case PoseReading::kAxesUp:
      return "the camera's y points up and its z backwards";
  }
  return "";
}

const char* Describe(ImageReading reading) {
  switch (reading) {
    case ImageReading::kAsRead:
      return "as taken";
    case ImageReading::kRotated90:
      return "turned by 90 degrees clockwise";
    case ImageReading::kRotated180:
      return "turned by 180 degrees";
    case ImageReading::kRotated270:
      return "turned by 90 degrees anticlockwise";
    case ImageReading::kMirrored:
      return "mirrored";
  }
  return "";
}

double ImageWidth(const Camera& camera) {
  return camera.width_px() > 0 ? camera.width_px() : 2.0 * camera.K()(0, 2);
}

double ImageHeight(const Camera& camera) {
  return camera.height_px() > 0 ? camera.height_px() : 2.0 * camera.K()(1, 2);
}

Camera WithPose(const Camera& camera, PoseReading reading) {
  CameraParameters parameters = camera.parameters();
  const Eigen::Matrix3d R = camera.R();
  const Eigen::Vector3d t = camera.t();
  switch (reading) {
    case PoseReading::kAsRead:
      return camera;
    case PoseReading::kInverse:
      parameters.R = R.transpose();
      parameters.t = -(R.transpose() * t);
      break;
    case PoseReading::kCentre:
      parameters.t = -(R * t);
      break;
    case PoseReading::kTranslation:
      parameters.t = -(R.transpose() * t);
      break;
    case PoseReading::kTransposed:
      parameters.R = R.transpose();
      break;
    case PoseReading::kTransposedCentre:
      parameters.R = R.transpose();
      parameters.t = R.transpose() * (R.transpose() * t);
      break;
    case PoseReading::kAxesUp: {
      const Eigen::Vector3d signs(1.0, -1.0, -1.0);
      parameters.R = signs.asDiagonal() * R;
      parameters.t = signs.asDiagonal() * t;
      break;
    }
  }
  return Camera(parameters);
}

ViewPeople Restored(const ViewPeople& view, ImageReading reading,
                    double width_px, double height_px) {
  ViewPeople restored = view;
  if (reading == ImageReading::kAsRead) return restored;
  for (auto& frame : restored.frames) {
    for (ViewPeople::Person& person : frame) {
      for (Eigen::Vector2d& px : person.px) {
        const Eigen::Vector2d shown = px;
        switch (reading) {
          case ImageReading::kAsRead:
            break;
          case ImageReading::kRotated90:  // (x, y) was shown at (h - 1 - y, x)
            px = Eigen::Vector2d(shown.y(), height_px - 1.0 - shown.x());
            break;
          case ImageReading::kRotated180:
            px = Eigen::Vector2d(width_px - 1.0 - shown.x(),
                                 height_px - 1.0 - shown.y());
            break;
          case ImageReading::kRotated270:  // (x, y) was shown at (y, w - 1 - x)
            px = Eigen::Vector2d(width_px - 1.0 - shown.y(), shown.x());
            break;
          case ImageReading::kMirrored:
            px.x() = width_px - 1.0 - shown.x();
            break;
        }
      }
    }
  }
  return restored;
}

std::optional<Camera> Seeing(const Camera& camera, ImageReading reading) {
  if (reading == ImageReading::kAsRead) return camera;
  if (reading == ImageReading::kMirrored) return std::nullopt;
  // (0, 0) is the middle of the first pixel.
  const double width = ImageWidth(camera);
  const double height = ImageHeight(camera);
  CameraParameters parameters = camera.parameters();
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  const double cx = camera.K()(0, 2);
  const double cy = camera.K()(1, 2);
  if (reading == ImageReading::kRotated180) {
    turn.topLeftCorner<2, 2>() = -Eigen::Matrix2d::Identity();
    parameters.K(0, 2) = width - 1.0 - cx;
    parameters.K(1, 2) = height - 1.0 - cy;
  } else {
    const bool clockwise = reading == ImageReading::kRotated90;
    turn << 0.0, clockwise ? -1.0 : 1.0, 0.0,  //
        clockwise ? 1.0 : -1.0, 0.0, 0.0,      //
        0.0, 0.0, 1.0;
    std::swap(parameters.K(0, 0), parameters.K(1, 1));
    parameters.K(0, 2) = clockwise ? height - 1.0 - cy : cy;
    parameters.K(1, 2) = clockwise ? cx : width - 1.0 - cx;
    std::swap(parameters.width_px, parameters.height_px);
  }
  parameters.R = turn * camera.R();
  parameters.t = turn * camera.t();
  parameters.lens = Turned(camera.lens(), reading == ImageReading::kRotated180
                                              ? ImageTurn::kHalf
                                          : reading == ImageReading::kRotated90
                                              ? ImageTurn::kClockwise
                                              : ImageTurn::kCounterClockwise);
  return Camera(parameters);
}

Reading Reading::AsRead(size_t views) {
  Reading reading;
  reading.images.assign(views, ImageReading::kAsRead);
  reading.camera_of_view.resize(views);
  std::iota(reading.camera_of_view.begin(), reading.camera_of_view.end(), 0);
  return reading;
}

bool Reading::operator==(const Reading& other) const {
  return pose == other.pose && image_scale == other.image_scale &&
         without_lens == other.without_lens && images == other.images &&
         camera_of_view == other.camera_of_view;
}

CameraRig CamerasOf(const CameraRig& cameras, const Reading& reading) {
  CameraRig rig;
  for (size_t v = 0; v < cameras.size(); ++v) {
    const Camera& source =
        cameras[static_cast<size_t>(reading.camera_of_view[v])];
    CameraParameters parameters = WithPose(source, reading.pose).parameters();
    parameters.K.topRows<2>() *= reading.image_scale;
    if (reading.without_lens) parameters.lens = nullptr;
    rig.emplace_back(parameters);
  }
  return rig;
}

std::vector<ViewPeople> PeopleOf(const CameraRig& cameras,
                                 const std::vector<ViewPeople>& raw,
                                 const Reading& reading) {
  const CameraRig rig = CamerasOf(cameras, reading);
  std::vector<ViewPeople> people;
  for (size_t v = 0; v < raw.size(); ++v) {
    people.push_back(
        Undistorted(Restored(raw[v], reading.images[v], ImageWidth(cameras[v]),
                             ImageHeight(cameras[v])),
                    rig[v]));
  }
  return people;
}

}  // namespace kinegraph
