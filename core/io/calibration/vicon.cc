// Vicon's .xcp of Nexus, Shogun and Tracker: XML with an element <Camera> each:
//   DEVICEID, TYPE, DISPLAY_TYPE, SENSOR_SIZE "width height" px,
//   PIXEL_ASPECT_RATIO, and in KeyFrames/KeyFrame
//   FOCAL_LENGTH px; PRINCIPAL_POINT px; ORIENTATION, a quaternion x y z w that
//   turns the world into the camera; POSITION of the camera, mm; and
//   VICON_RADIAL2 "ViconRadial2 cx cy k1 k2 k3" or VICON_RADIAL "k1 k2".
// Vicon's radial terms free a raw point of distortion: it moves from the
// principal point by the factor 1 + k1 r^2 + k2 r^4 + k3 r^6, r in px. Terms
// that are far too large for that are without unit, OpenCV's, as other
// programs write and read them.
//
// The last key frame counts, as it is the newest. Cameras that only see markers
// are left out where others have video.
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/io/calibration/format.h"

namespace kinegraph {
namespace {

bool RecogniseVicon(const CalibrationHead& head) {
  return head.Is(CalibrationSyntax::kXml) && head.xml.has_value() &&
         head.xml->name() == "Cameras" && head.xml->Find("Camera").has_value();
}

// "Vue" is Vicon's own video camera, "VideoInputDevice:..." are others'.
bool HasViconVideo(const XmlElement& camera) {
  for (const char* attribute : {"TYPE", "DISPLAY_TYPE"}) {
    std::string type = camera.FindText(attribute).value_or("");
    std::transform(type.begin(), type.end(), type.begin(), [](char c) {
      return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    });
    if (type.find("video") != std::string::npos ||
        type.find("vue") != std::string::npos) {
      return true;
    }
  }
  return false;
}

// nullopt where the camera was never calibrated.
std::optional<XmlElement> KeyFrameOf(const XmlElement& camera) {
  const auto frames = camera.Find("KeyFrames");
  if (!frames.has_value()) return std::nullopt;
  std::vector<XmlElement> all = frames->All("KeyFrame");
  if (all.empty()) return std::nullopt;
  return all.back();
}

// k1 k2 k3 as the file has them.
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

// OpenCV's k1 k2 p1 p2 k3 of the lens that Vicon's terms undo, by least squares
// over the radii of the image. Both are polynomials of a few terms; where they
// are further apart than kLargestGap the file's lens cannot be said.
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
  // No lens moves a corner by its whole distance.
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
    frame.Fail("the radial terms cannot be said by OpenCV's: " +
               std::to_string(gap_px) + " px apart");
  }
  return {k[0], k[1], 0.0, 0.0, k[2]};
}

CameraRecord ReadViconCamera(const XmlElement& camera,
                             const XmlElement& frame) {
  CameraRecord record;
  record.file = camera.file();
  record.name = camera.Text("DEVICEID");
  const std::vector<double> size = camera.Numbers("SENSOR_SIZE", 2);
  if (!(size[0] >= 1.0 && size[0] <= 1e6 && size[1] >= 1.0 && size[1] <= 1e6)) {
    camera.Fail("SENSOR_SIZE: expected a width and a height in px");
  }
  record.width_px = static_cast<int64_t>(size[0]);
  record.height_px = static_cast<int64_t>(size[1]);
  record.may_be_scaled = true;
  const std::vector<double> centre_px = frame.Numbers("PRINCIPAL_POINT", 2);
  record.K(0, 0) = frame.Number("FOCAL_LENGTH");
  record.K(1, 1) = record.K(0, 0) / camera.NumberOr("PIXEL_ASPECT_RATIO", 1.0);
  record.K(0, 2) = centre_px[0];
  record.K(1, 2) = centre_px[1];
  record.distortion = LensOf(frame, record);
  const std::vector<double> turn = frame.Numbers("ORIENTATION", 4);
  const Eigen::Quaterniond rotation(turn[3], turn[0], turn[1], turn[2]);
  // Files have a dozen digits.
  if (!(std::abs(rotation.norm() - 1.0) < 1e-3)) {
    frame.Fail("ORIENTATION is no unit quaternion");
  }
  record.R = rotation.normalized().toRotationMatrix();
  record.centre = ToVector3(frame.Numbers("POSITION", 3));
  return record;
}

CalibrationFile ReadVicon(const CalibrationHead& head) {
  const XmlElement& root = head.XmlRoot();
  CalibrationFile file;
  file.unit = LengthUnit::kMillimetre;
  file.states_unit = true;
  std::vector<XmlElement> cameras = root.All("Camera");
  const auto is_unplaced = [](const XmlElement& camera) {
    return !KeyFrameOf(camera).has_value();
  };
  cameras.erase(std::remove_if(cameras.begin(), cameras.end(), is_unplaced),
                cameras.end());
  const bool any_video =
      std::any_of(cameras.begin(), cameras.end(), HasViconVideo);
  for (const XmlElement& camera : cameras) {
    if (any_video && !HasViconVideo(camera)) continue;
    file.cameras.push_back(ReadViconCamera(camera, *KeyFrameOf(camera)));
  }
  if (file.cameras.empty()) root.Fail("has no camera with a KeyFrame");
  return file;
}

}  // namespace

CalibrationFormat ViconCalibrationFormat() {
  CalibrationFormat format;
  format.name = "vicon";
  format.layout = "XML: .xcp of Nexus, Shogun or Tracker";
  format.syntax = CalibrationSyntax::kXml;
  format.recognise = RecogniseVicon;
  format.read = ReadVicon;
  return format;
}

}  // namespace kinegraph
