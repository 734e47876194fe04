// OptiTrack's .mcal of Motive 3: XML, often UTF-16, with an element <Camera>
// each, in Calibration/Cameras:
//   Serial; Attributes ImagerPixelWidth, ImagerPixelHeight
//   IntrinsicStandardCameraModel HorizontalFocalLength, VerticalFocalLength,
//     LensCenterX, LensCenterY [px], k1, k2, k3, TangentialX, TangentialY
//     (OpenCV's; the element Intrinsic has Motive's own model, which is not
//     read)
//   Extrinsic X, Y, Z, the camera's position, m; OrientMatrix0 .. 8, by rows,
//     whose columns are the camera's axes in the world: x right, y up, z
//     backwards.
#include "core/io/calibration/format.h"

namespace kinegraph {
namespace {

std::optional<XmlElement> CamerasOf(const XmlElement& root) {
  const auto calibration = root.Find("Calibration");
  const XmlElement& parent = calibration.has_value() ? *calibration : root;
  return parent.Find("Cameras");
}

bool RecogniseOptitrack(const CalibrationHead& head) {
  if (!head.Is(CalibrationSyntax::kXml) || !head.xml.has_value()) return false;
  const auto cameras = CamerasOf(*head.xml);
  if (!cameras.has_value()) return false;
  const auto camera = cameras->Find("Camera");
  return camera.has_value() && camera->Find("Extrinsic").has_value();
}

CameraRecord ReadOptitrackCamera(const XmlElement& camera) {
  CameraRecord record;
  record.file = camera.file();
  record.name = camera.Text("Serial");
  const XmlElement attributes = camera.At("Attributes");
  const auto side = [&](const char* attribute) {
    const double px = attributes.Number(attribute);
    if (!(px >= 1.0 && px <= 1e6)) {
      attributes.Fail(std::string(attribute) + ": expected a side in px");
    }
    return static_cast<int64_t>(px);
  };
  record.width_px = side("ImagerPixelWidth");
  record.height_px = side("ImagerPixelHeight");
  record.may_be_scaled = true;
  const auto lens = camera.Find("IntrinsicStandardCameraModel");
  if (!lens.has_value()) {
    camera.Fail(
        "camera '" + record.name +
        "' has no <IntrinsicStandardCameraModel>: Motive's own lens model is "
        "not read, expected a file of Motive 3 or later");
  }
  record.K(0, 0) = lens->Number("HorizontalFocalLength");
  record.K(1, 1) = lens->Number("VerticalFocalLength");
  record.K(0, 2) = lens->Number("LensCenterX");
  record.K(1, 2) = lens->Number("LensCenterY");
  for (const char* term : {"k1", "k2", "TangentialX", "TangentialY", "k3"}) {
    record.distortion.push_back(lens->NumberOr(term, 0.0));
  }
  const XmlElement pose = camera.At("Extrinsic");
  std::vector<double> axes;
  for (int i = 0; i < 9; ++i) {
    axes.push_back(pose.Number("OrientMatrix" + std::to_string(i)));
  }
  record.R = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal() *
             ToMatrix3(axes).transpose();
  record.centre =
      Eigen::Vector3d(pose.Number("X"), pose.Number("Y"), pose.Number("Z"));
  return record;
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

}  // namespace

CalibrationFormat OptitrackCalibrationFormat() {
  CalibrationFormat format;
  format.name = "optitrack";
  format.layout = "XML: .mcal of Motive 3";
  format.syntax = CalibrationSyntax::kXml;
  format.recognise = RecogniseOptitrack;
  format.read = ReadOptitrack;
  return format;
}

}  // namespace kinegraph
