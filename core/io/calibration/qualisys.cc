// Qualisys: NAME.qca.txt of QTM's project folder, and cal.txt as QTM exports it
// for Theia; the same XML, an element <camera> each:
//   fov_video left, top, right, bottom   the video on the sensor, whole pixels
//   intrinsic focalLengthU, -V, centerPointU, -V   in 1/64 px of the sensor;
//             skew; radialDistortion1..3, tangentalDistortion1..2
//   transform x, y, z   the camera's position, mm; r11 .. r33, whose rows are
//             the camera's axes in the world: x right, y up, z backwards
// Cameras that only see markers are left out where others have video; so are
// those that are not active or not calibrated. QTM's `viewrotation` says how
// its window shows a picture: the numbers, and the video's file, are as the
// sensor lies.
//
// The lens terms are OpenCV's, without unit. Pose2Sim, which divides them by
// 64, multiplies by it where it writes such a file (qtm-version="none"), so
// there they are read as it reads them.
#include <algorithm>
#include <cctype>

#include "core/io/calibration/format.h"

namespace kinegraph {
namespace {

constexpr double kPerPixel = 64.0;

bool RecogniseQualisys(const CalibrationHead& head) {
  if (!head.Is(CalibrationSyntax::kXml) || !head.xml.has_value()) return false;
  const auto cameras = head.xml->Find("cameras");
  return head.xml->name() == "calibration" && cameras.has_value() &&
         cameras->Find("camera").has_value();
}

bool IsOff(const XmlElement& camera) {
  const auto says = [&](const char* attribute, const char* text) {
    return camera.FindText(attribute) == std::string(text);
  };
  return says("active", "0") || says("active", "false") ||
         says("calibrated", "false") || says("calibrated", "0");
}

// Models are "Miqus Video", "Miqus Video Plus", ...; files that other programs
// wrote say "none" or nothing.
bool HasQualisysVideo(const XmlElement& camera) {
  std::string model = camera.FindText("model").value_or("none");
  std::transform(model.begin(), model.end(), model.begin(), [](char c) {
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  });
  return model == "none" || model.empty() ||
         model.find("video") != std::string::npos;
}

Eigen::Matrix3d RotationOf(const XmlElement& transform) {
  Eigen::Matrix3d axes;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      axes(row, column) = transform.Number("r" + std::to_string(row + 1) +
                                           std::to_string(column + 1));
    }
  }
  return Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal() * axes;
}

CameraRecord ReadQualisysCamera(const XmlElement& camera, double lens_divisor) {
  CameraRecord record;
  record.file = camera.file();
  record.name = camera.Text("serial");
  const XmlElement intrinsic = camera.At("intrinsic");
  // No sensor has so few of the smaller units, nor so many pixels.
  constexpr double kFewest = 20000.0;
  if (intrinsic.NumberOr("sensorMaxU", kFewest) < kFewest) {
    intrinsic.Fail("sensorMaxU: found " + intrinsic.Text("sensorMaxU") +
                   ", expected 1/64 px as QTM writes them (Theia's own "
                   "calibrations, in px, are not read)");
  }
  double left_px = 0.0;
  double top_px = 0.0;
  if (const auto video = camera.Find("fov_video")) {
    left_px = video->Number("left");
    top_px = video->Number("top");
    const auto side = [&](double from, double to) {
      const double px = to - from + 1.0;
      if (!(px >= 1.0 && px <= 1e6))
        video->Fail("found an empty field of view");
      return static_cast<int64_t>(px);
    };
    record.width_px = side(left_px, video->Number("right"));
    record.height_px = side(top_px, video->Number("bottom"));
    record.may_be_scaled = true;
  }
  record.K(0, 0) = intrinsic.Number("focalLengthU") / kPerPixel;
  record.K(1, 1) = intrinsic.Number("focalLengthV") / kPerPixel;
  record.K(0, 1) = intrinsic.NumberOr("skew", 0.0) / kPerPixel;
  record.K(0, 2) = intrinsic.Number("centerPointU") / kPerPixel - left_px;
  record.K(1, 2) = intrinsic.Number("centerPointV") / kPerPixel - top_px;
  for (const char* term :
       {"radialDistortion1", "radialDistortion2", "tangentalDistortion1",
        "tangentalDistortion2", "radialDistortion3"}) {
    record.distortion.push_back(intrinsic.NumberOr(term, 0.0) / lens_divisor);
  }
  const XmlElement transform = camera.At("transform");
  record.R = RotationOf(transform);
  record.centre = Eigen::Vector3d(transform.Number("x"), transform.Number("y"),
                                  transform.Number("z"));
  return record;
}

CalibrationFile ReadQualisys(const CalibrationHead& head) {
  const XmlElement& root = head.XmlRoot();
  CalibrationFile file;
  file.unit = LengthUnit::kMillimetre;
  file.states_unit = true;
  std::vector<XmlElement> cameras = root.At("cameras").All("camera");
  cameras.erase(std::remove_if(cameras.begin(), cameras.end(), IsOff),
                cameras.end());
  const bool any_video =
      std::any_of(cameras.begin(), cameras.end(), HasQualisysVideo);
  const bool from_pose2sim = root.FindText("qtm-version") == "none";
  for (const XmlElement& camera : cameras) {
    if (any_video && !HasQualisysVideo(camera)) continue;
    file.cameras.push_back(
        ReadQualisysCamera(camera, from_pose2sim ? kPerPixel : 1.0));
  }
  if (file.cameras.empty()) root.Fail("has no camera that is calibrated");
  return file;
}

}  // namespace

CalibrationFormat QualisysCalibrationFormat() {
  CalibrationFormat format;
  format.name = "qualisys";
  format.layout = "XML: QTM's .qca.txt, and cal.txt as exported for Theia";
  format.syntax = CalibrationSyntax::kXml;
  format.recognise = RecogniseQualisys;
  format.read = ReadQualisys;
  return format;
}

}  // namespace kinegraph
