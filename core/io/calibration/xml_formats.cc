// Calibrations in XML, as written by marker-based motion capture systems.
#include <Eigen/QR>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>

#include "core/io/calibration/format.h"

namespace kinegraph {
namespace {

// The text of an attribute in lower case, or `otherwise` if it is absent.
std::string LowerText(const XmlElement& element, const char* attribute,
                      const char* otherwise) {
  std::string text = element.FindText(attribute).value_or(otherwise);
  std::transform(text.begin(), text.end(), text.begin(), [](char c) {
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  });
  return text;
}

// A side of an image, truncated to a whole number. Fails with `message` if it
// is not within 1 .. 1e6 px.
int64_t SidePx(double px, const XmlElement& element,
               const std::string& message) {
  if (!(px >= 1.0 && px <= 1e6)) element.Fail(message);
  return static_cast<int64_t>(px);
}

std::vector<double> NumbersOf(const XmlElement& element,
                              const std::vector<std::string>& attributes) {
  std::vector<double> numbers;
  for (const std::string& attribute : attributes) {
    numbers.push_back(element.Number(attribute));
  }
  return numbers;
}

// Removes the cameras for which `is_off` is true and, if any of the remaining
// cameras has video, also those without video.
template <typename IsOff, typename HasVideo>
std::vector<XmlElement> FilmingCameras(std::vector<XmlElement> cameras,
                                       const IsOff& is_off,
                                       const HasVideo& has_video) {
  cameras.erase(std::remove_if(cameras.begin(), cameras.end(), is_off),
                cameras.end());
  if (std::any_of(cameras.begin(), cameras.end(), has_video)) {
    cameras.erase(
        std::remove_if(cameras.begin(), cameras.end(), std::not_fn(has_video)),
        cameras.end());
  }
  return cameras;
}

// cam_from_world. The rows of `axes` are the camera's axes in the world: right,
// up and backwards.
Eigen::Matrix3d RotationOfAxes(const Eigen::Matrix3d& axes) {
  return Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal() * axes;
}

// ---- Qualisys ----
// Qualisys: NAME.qca.txt of QTM's project folder, and cal.txt as QTM exports it
// for Theia; the same XML, with one element <camera> per camera:
//   fov_video left, top, right, bottom   the video on the sensor, whole pixels
//   intrinsic focalLengthU, -V, centerPointU, -V, skew   in 1/64 px of the
//             sensor; radialDistortion1..3, tangentalDistortion1..2
//   transform x, y, z   the camera's position, mm; r11 .. r33, whose rows are
//             the camera's axes in the world: x right, y up, z backwards
// Cameras that are not active or not calibrated are skipped, and marker cameras
// if others have video. QTM's `viewrotation` only concerns the display in its
// window: the numbers and the video file are in the sensor's orientation.
//
// The lens terms are OpenCV's, without unit. Pose2Sim multiplies them by 64
// when it writes such a file (qtm-version="none") and divides them when it
// reads one; in its files they are divided here, too.

constexpr double kPerPixel = 64.0;

bool IsOff(const XmlElement& camera) {
  const auto says = [&](const char* attribute, const char* text) {
    return camera.FindText(attribute) == std::string(text);
  };
  return says("active", "0") || says("active", "false") ||
         says("calibrated", "false") || says("calibrated", "0");
}

// QTM writes models such as "Miqus Video" or "Miqus Video Plus"; other programs
// write "none" or nothing.
bool HasQualisysVideo(const XmlElement& camera) {
  const std::string model = LowerText(camera, "model", "none");
  return model == "none" || model.empty() ||
         model.find("video") != std::string::npos;
}

CameraRecord ReadQualisysCamera(const XmlElement& camera, double lens_divisor) {
  CameraRecord record;
  record.file = camera.file();
  record.name = camera.Text("serial");
  const XmlElement intrinsic = camera.At("intrinsic");
  // Widths below 20,000 are in px, since they would be less than 313 px if they
  // were in 1/64 px; larger ones are in 1/64 px.
  constexpr double kFewest = 20000.0;
  if (intrinsic.NumberOr("sensorMaxU", kFewest) < kFewest) {
    intrinsic.Fail("sensorMaxU: found " + intrinsic.Text("sensorMaxU") +
                   ", expected 1/64 px as QTM writes them (Theia's own "
                   "calibrations, in px, are not supported)");
  }
  double left_px = 0.0;
  double top_px = 0.0;
  if (const auto video = camera.Find("fov_video")) {
    left_px = video->Number("left");
    top_px = video->Number("top");
    constexpr const char* kEmpty = "found an empty field of view";
    record.width_px =
        SidePx(video->Number("right") - left_px + 1.0, *video, kEmpty);
    record.height_px =
        SidePx(video->Number("bottom") - top_px + 1.0, *video, kEmpty);
    record.may_be_scaled = true;
  }
  const double fx = intrinsic.Number("focalLengthU") / kPerPixel;
  const double fy = intrinsic.Number("focalLengthV") / kPerPixel;
  const double skew = intrinsic.NumberOr("skew", 0.0) / kPerPixel;
  record.K = CameraMatrix(
      {fx, fy, intrinsic.Number("centerPointU") / kPerPixel - left_px,
       intrinsic.Number("centerPointV") / kPerPixel - top_px});
  record.K(0, 1) = skew;
  for (const char* term :
       {"radialDistortion1", "radialDistortion2", "tangentalDistortion1",
        "tangentalDistortion2", "radialDistortion3"}) {
    record.distortion.push_back(intrinsic.NumberOr(term, 0.0) / lens_divisor);
  }
  const XmlElement transform = camera.At("transform");
  record.R = RotationOfAxes(
      ToMatrix3(NumbersOf(transform, {"r11", "r12", "r13", "r21", "r22", "r23",
                                      "r31", "r32", "r33"})));
  record.centre = ToVector3(NumbersOf(transform, {"x", "y", "z"}));
  return record;
}

}  // namespace

bool RecogniseQualisys(const CalibrationHead& head) {
  if (!head.Is(CalibrationSyntax::kXml)) return false;
  const auto cameras = head.xml->Find("cameras");
  return head.xml->name() == "calibration" && cameras.has_value() &&
         cameras->Find("camera").has_value();
}

CalibrationFile ReadQualisys(const CalibrationHead& head) {
  const XmlElement& root = head.XmlRoot();
  CalibrationFile file = {{}, LengthUnit::kMillimetre, /*states_unit=*/true};
  const bool from_pose2sim = root.FindText("qtm-version") == "none";
  for (const XmlElement& camera : FilmingCameras(
           root.At("cameras").All("camera"), IsOff, HasQualisysVideo)) {
    file.cameras.push_back(
        ReadQualisysCamera(camera, from_pose2sim ? kPerPixel : 1.0));
  }
  if (file.cameras.empty())
    root.Fail("has no camera that is active and calibrated");
  return file;
}

// ---- Vicon ----
// Vicon's .xcp of Nexus, Shogun and Tracker: XML with one element <Camera> per
// camera:
//   DEVICEID, TYPE, DISPLAY_TYPE, SENSOR_SIZE "width height" px,
//   PIXEL_ASPECT_RATIO, and in KeyFrames/KeyFrame
//   FOCAL_LENGTH px; PRINCIPAL_POINT px; ORIENTATION, a quaternion x y z w that
//   rotates the world into the camera frame; POSITION of the camera, mm; and
//   VICON_RADIAL2 "ViconRadial2 cx cy k1 k2 k3" or VICON_RADIAL "k1 k2".
// Vicon's radial terms undistort a raw point: its distance from the principal
// point is multiplied by 1 + k1 r^2 + k2 r^4 + k3 r^6, r in px. Terms that are
// far too large for this are OpenCV's, without unit: other programs write and
// read such files.
//
// The last key frame is used, as it is the newest. Cameras without a key frame
// are skipped, and marker cameras if others have video.

namespace {

// "Vue" is Vicon's own video camera; "VideoInputDevice:..." are those of other
// manufacturers.
bool HasViconVideo(const XmlElement& camera) {
  for (const char* attribute : {"TYPE", "DISPLAY_TYPE"}) {
    const std::string type = LowerText(camera, attribute, "");
    if (type.find("video") != std::string::npos ||
        type.find("vue") != std::string::npos) {
      return true;
    }
  }
  return false;
}

// nullopt if the camera was never calibrated.
std::optional<XmlElement> KeyFrameOf(const XmlElement& camera) {
  const auto frames = camera.Find("KeyFrames");
  if (!frames.has_value()) return std::nullopt;
  std::vector<XmlElement> all = frames->All("KeyFrame");
  if (all.empty()) return std::nullopt;
  return all.back();
}

// k1 k2 k3 as in the file.
Eigen::Vector3d RadialTerms(const XmlElement& frame) {
  if (frame.FindText("VICON_RADIAL2").has_value()) {
    const std::vector<double> all = frame.Numbers("VICON_RADIAL2", 5);
    return {all[2], all[3], all[4]};
  }
  if (!frame.FindText("VICON_RADIAL").has_value()) {
    return Eigen::Vector3d::Zero();
  }
  const std::vector<double> terms = frame.Numbers("VICON_RADIAL", 2);
  return {terms[0], terms[1], 0.0};
}

// OpenCV's k1 k2 p1 p2 k3 of the lens whose distortion Vicon's terms remove,
// fitted by least squares over the radii of the image. Both are polynomials of
// a few terms; if the fit differs by more than kLargestGapPx, OpenCV's
// polynomial cannot represent the lens.
std::vector<double> LensOf(const XmlElement& frame,
                           const CameraRecord& record) {
  const Eigen::Vector3d terms = RadialTerms(frame);
  const double focal_px = record.K(0, 0);
  const auto furthest = [](double centre, double side) {
    return std::max(std::abs(centre), std::abs(side - centre));
  };
  const double corner_px = std::hypot(
      furthest(record.K(0, 2), static_cast<double>(record.width_px)),
      furthest(record.K(1, 2), static_cast<double>(record.height_px)));
  const auto powers = [](double r) {
    const double s = r * r;
    return Eigen::Vector3d(s, s * s, s * s * s);
  };
  // No lens displaces a corner by its whole radius: these terms are OpenCV's.
  if (powers(corner_px).cwiseProduct(terms).cwiseAbs().maxCoeff() >= 1.0) {
    return {terms[0], terms[1], 0.0, 0.0, terms[2]};
  }
  constexpr int kRadii = 200;
  Eigen::Matrix<double, kRadii, 3> ideal;
  Eigen::Matrix<double, kRadii, 1> displaced;
  for (int i = 0; i < kRadii; ++i) {
    const double raw_px = corner_px * (i + 1) / kRadii;
    const double radius = raw_px / focal_px * (1.0 + powers(raw_px).dot(terms));
    ideal.row(i) = radius * powers(radius).transpose();
    displaced[i] = raw_px / focal_px - radius;
  }
  const Eigen::Vector3d k = ideal.colPivHouseholderQr().solve(displaced);
  constexpr double kLargestGapPx = 0.1;
  const double gap_px =
      focal_px * (ideal * k - displaced).cwiseAbs().maxCoeff();
  if (!(gap_px <= kLargestGapPx)) {
    frame.Fail(
        "the radial terms cannot be expressed by OpenCV's: they differ by " +
        std::to_string(gap_px) + " px");
  }
  return {k[0], k[1], 0.0, 0.0, k[2]};
}

CameraRecord ReadViconCamera(const XmlElement& camera,
                             const XmlElement& frame) {
  CameraRecord record;
  record.file = camera.file();
  record.name = camera.Text("DEVICEID");
  const std::vector<double> size = camera.Numbers("SENSOR_SIZE", 2);
  constexpr const char* kNoSize =
      "SENSOR_SIZE: expected a width and a height in px";
  record.width_px = SidePx(size[0], camera, kNoSize);
  record.height_px = SidePx(size[1], camera, kNoSize);
  record.may_be_scaled = true;
  const std::vector<double> centre_px = frame.Numbers("PRINCIPAL_POINT", 2);
  const double fx = frame.Number("FOCAL_LENGTH");
  record.K = CameraMatrix({fx, fx / camera.NumberOr("PIXEL_ASPECT_RATIO", 1.0),
                           centre_px[0], centre_px[1]});
  record.distortion = LensOf(frame, record);
  const std::vector<double> turn = frame.Numbers("ORIENTATION", 4);
  const auto R = RotationOf({turn[3], turn[0], turn[1], turn[2]});
  if (!R.has_value()) frame.Fail("ORIENTATION is not a unit quaternion");
  record.R = *R;
  record.centre = ToVector3(frame.Numbers("POSITION", 3));
  return record;
}

}  // namespace

bool RecogniseVicon(const CalibrationHead& head) {
  return head.Is(CalibrationSyntax::kXml) && head.xml->name() == "Cameras" &&
         head.xml->Find("Camera").has_value();
}

CalibrationFile ReadVicon(const CalibrationHead& head) {
  const XmlElement& root = head.XmlRoot();
  CalibrationFile file = {{}, LengthUnit::kMillimetre, /*states_unit=*/true};
  const auto is_unplaced = [](const XmlElement& camera) {
    return !KeyFrameOf(camera).has_value();
  };
  for (const XmlElement& camera :
       FilmingCameras(root.All("Camera"), is_unplaced, HasViconVideo)) {
    file.cameras.push_back(ReadViconCamera(camera, *KeyFrameOf(camera)));
  }
  if (file.cameras.empty()) root.Fail("has no camera with a KeyFrame");
  return file;
}

// ---- OptiTrack ----
// OptiTrack's .mcal of Motive 3: XML, often UTF-16, with one element <Camera>
// per camera in Calibration/Cameras:
//   Serial; Attributes ImagerPixelWidth, ImagerPixelHeight
//   IntrinsicStandardCameraModel HorizontalFocalLength, VerticalFocalLength,
//     LensCenterX, LensCenterY [px], k1, k2, k3, TangentialX, TangentialY
//     (OpenCV's; the element Intrinsic has Motive's own model, which is
//     ignored)
//   Extrinsic X, Y, Z, the camera's position, m; OrientMatrix0 .. 8, by rows,
//     whose columns are the camera's axes in the world: x right, y up, z
//     backwards.

namespace {

std::optional<XmlElement> CamerasOf(const XmlElement& root) {
  const auto calibration = root.Find("Calibration");
  const XmlElement& parent = calibration.has_value() ? *calibration : root;
  return parent.Find("Cameras");
}

CameraRecord ReadOptitrackCamera(const XmlElement& camera) {
  CameraRecord record;
  record.file = camera.file();
  record.name = camera.Text("Serial");
  const XmlElement attributes = camera.At("Attributes");
  const auto side_px = [&](const char* name) {
    return SidePx(attributes.Number(name), attributes,
                  name + std::string(": expected a side in px"));
  };
  record.width_px = side_px("ImagerPixelWidth");
  record.height_px = side_px("ImagerPixelHeight");
  record.may_be_scaled = true;
  const auto lens = camera.Find("IntrinsicStandardCameraModel");
  if (!lens.has_value()) {
    camera.Fail(
        "camera '" + record.name +
        "' has no <IntrinsicStandardCameraModel>: Motive's own lens model is "
        "not supported, expected a file of Motive 3 or later");
  }
  record.K = CameraMatrix(
      NumbersOf(*lens, {"HorizontalFocalLength", "VerticalFocalLength",
                        "LensCenterX", "LensCenterY"}));
  for (const char* term : {"k1", "k2", "TangentialX", "TangentialY", "k3"}) {
    record.distortion.push_back(lens->NumberOr(term, 0.0));
  }
  const XmlElement pose = camera.At("Extrinsic");
  std::vector<std::string> axes;
  for (int i = 0; i < 9; ++i) {
    axes.push_back("OrientMatrix" + std::to_string(i));
  }
  record.R = RotationOfAxes(ToMatrix3(NumbersOf(pose, axes)).transpose());
  record.centre = ToVector3(NumbersOf(pose, {"X", "Y", "Z"}));
  return record;
}

}  // namespace

bool RecogniseOptitrack(const CalibrationHead& head) {
  if (!head.Is(CalibrationSyntax::kXml)) return false;
  const auto cameras = CamerasOf(*head.xml);
  if (!cameras.has_value()) return false;
  const auto camera = cameras->Find("Camera");
  return camera.has_value() && camera->Find("Extrinsic").has_value();
}

CalibrationFile ReadOptitrack(const CalibrationHead& head) {
  const XmlElement& root = head.XmlRoot();
  const auto cameras = CamerasOf(root);
  if (!cameras.has_value()) root.Fail("has no element <Cameras>");
  CalibrationFile file;
  file.states_unit = true;
  for (const XmlElement& camera : cameras->All("Camera")) {
    file.cameras.push_back(ReadOptitrackCamera(camera));
  }
  return file;
}

}  // namespace kinegraph
