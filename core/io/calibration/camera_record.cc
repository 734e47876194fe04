#include "core/io/calibration/camera_record.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/base/error.h"

namespace kinegraph {
namespace {

// The words of a text. In the lists below a word stands for all keys that Plain
// maps to it: "distcoeffs" for "dist_coeffs", "distCoeffs" and "Dist-Coeffs".
std::set<std::string> SetOf(const char* words) {
  std::istringstream stream(words);
  using Iterator = std::istream_iterator<std::string>;
  return {Iterator(stream), Iterator()};
}

std::string Plain(const std::string& key) {
  std::string plain;
  for (const char c : key) {
    if (c == '_' || c == '-' || c == ' ') continue;
    plain += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return plain;
}

// Whether the key is a list of coefficients in OpenCV's order.
bool IsLensKey(const std::string& key) {
  static const std::set<std::string> kNames = SetOf(
      "dist kc distcoef distcoefs distcoeff distcoeffs distcoefficient "
      "distcoefficients distortion distortions distortioncoef distortioncoefs "
      "distortioncoeff distortioncoeffs distortioncoefficient "
      "distortioncoefficients distortionparameters distortionparams "
      "distortionvector lensdistortion");
  return key == "D" || key == "d" || kNames.count(Plain(key)) > 0;
}

bool IsModelKey(const std::string& key) {
  static const std::set<std::string> kNames = SetOf(
      "model distortionmodel lensmodel cameramodel cammodel lenstype distmodel "
      "projectionmodel distortiontype");
  return kNames.count(Plain(key)) > 0;
}

bool IsFisheyeKey(const std::string& key) {
  static const std::set<std::string> kNames =
      SetOf("fisheye fisheyemodel isfisheye omnidirectional");
  return kNames.count(Plain(key)) > 0;
}

std::vector<double> WithoutZeros(std::vector<double> coefficients) {
  while (!coefficients.empty() && coefficients.back() == 0.0) {
    coefficients.pop_back();
  }
  return coefficients;
}

// Whether the model is OpenCV's fisheye model, by its names in ROS, Kalibr and
// elsewhere. Throws InputError unless it is this model, OpenCV's polynomial or
// a pinhole.
bool IsFisheyeModel(const JsonField& model) {
  if (model.value().is_null()) return false;
  const std::string name = Plain(model.Text());
  static const std::set<std::string> kFisheye = SetOf(
      "fisheye opencvfisheye kannalabrandt kannalabrandt4 kannalabrandt8 kb4 "
      "equidistant equi pinholeequi pinholeequidistant");
  if (kFisheye.count(name) > 0) return true;
  static const std::set<std::string> kPolynomials = SetOf(
      "pinhole opencv opencv5 plumbbob radtan brown brownconrady perspective "
      "pinholeradtan fullopencv standard polynomial none regular pinholecamera "
      "rationalpolynomial radialtangential");
  if (kPolynomials.count(name) == 0) {
    model.FailExpected(
        "'pinhole', 'opencv' or another name of OpenCV's polynomial, or "
        "'fisheye'");
  }
  return false;
}

}  // namespace

bool IsHarmlessKey(const std::string& key) {
  static const std::set<std::string> kNames = SetOf(
      // Identity and date.
      "name id index idx number label serial serialno serialnumber camera "
      "cameraname cameraid camid camname cameraserial type panel node vendor "
      "manufacturer make sensor date datetime time timestamp created createdat "
      "calibrationtime calibrationdate calibdate version author comment "
      "comments note notes description title info software program generator "
      "tool source calibdatasource path file filename image images imagelist "
      "imagefiles video videos metadata meta "
      // Sizes and rates.
      "size imgsize imagesize resolution width height w h imagewidth "
      "imageheight imgwidth imgheight fps framerate frames nframes nrofframes "
      "numframes ncameras numcameras "
      // Quality of the calibration.
      "error errors rms rmse rmserror residual residuals reprojectionerror "
      "reprojerror meanerror meanreprojectionerror avgreprojectionerror "
      "averagereprojectionerror totalavgerr perviewerrors "
      "perviewreprojectionerrors stddeviations std adjusted converged "
      "iterations inliers "
      // Data from which the calibration was computed.
      "board boardtype boardsize boardwidth boardheight squaresize "
      "squarelength markersize markerlength pattern patternsize dictionary "
      "flags flagvalue fixaspectratio aspectratio imagepoints gridpoints "
      "objectpoints "
      // Poses of the board in the images (OpenCV), and parameters of rectified
      // (ROS) or undistorted images (4D association).
      "extrinsicparameters rectificationmatrix projectionmatrix rectifyalpha "
      "newcameramatrix optimalcameramatrix roi binningx binningy");
  return (!key.empty() && key.front() == '_') || kNames.count(Plain(key)) > 0;
}

void FailUnread(const JsonField& object, const std::string& key) {
  object.Fail("has a key '" + Printable(key) +
              "' that is not known in this format; it is rejected because it "
              "may describe lens or pose");
}

bool IsNoCamera(const std::string& key, const JsonField& field) {
  if (field.value().is_object() || field.value().is_array()) return false;
  return IsHarmlessKey(key) || key == "unit" || key == "units";
}

Eigen::Matrix3d ToMatrix3(const std::vector<double>& row_major) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
      row_major.data());
}

Eigen::Vector3d ToVector3(const std::vector<double>& numbers) {
  return Eigen::Map<const Eigen::Vector3d>(numbers.data());
}

Eigen::Matrix3d CameraMatrix(const std::vector<double>& numbers) {
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  K.diagonal().head<2>() << numbers[0], numbers[1];
  K.col(2).head<2>() << numbers[2], numbers[3];
  return K;
}

std::optional<Eigen::Matrix3d> RotationOf(const Eigen::Quaterniond& turn) {
  constexpr double kRounding = 1e-3;
  if (!(std::abs(turn.norm() - 1.0) < kRounding)) return std::nullopt;
  return turn.normalized().toRotationMatrix();
}

Eigen::Matrix3d ReadRotation(const JsonField& field) {
  const bool nested = field.value().is_array() && field.value().size() == 3 &&
                      field.value().front().is_array();
  if (nested && field.value().front().size() == 3) {
    return ToMatrix3(field.Matrix(3, 3));
  }
  const Eigen::Vector3d vector = ToVector3(field.Matrix(3, 1));
  const double angle = vector.stableNorm();
  if (!(angle > 0.0)) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

KeyReader::KeyReader(const JsonField& object) : object_(object) {
  if (!object.value().is_object()) object.FailExpected("an object");
}

std::optional<JsonField> KeyReader::Find(const std::string& key) {
  read_.insert(key);
  return object_.Find(key);
}

JsonField KeyReader::At(const std::string& key) {
  read_.insert(key);
  return object_.At(key);
}

JsonField KeyReader::AtAny(const std::vector<std::string>& keys) {
  std::string all;
  for (const std::string& key : keys) {
    if (object_.Find(key).has_value()) return At(key);
    all += (all.empty() ? "'" : " or '") + key + "'";
  }
  object_.Fail("has no key " + all);
}

void KeyReader::ReadImageSize(const std::string& key, CameraRecord* record) {
  const auto field = Find(key);
  if (!field.has_value() || field->value().is_null()) return;
  const std::vector<int64_t> size = field->Integers(2);
  record->width_px = size[0];
  record->height_px = size[1];
}

void KeyReader::ReadImageSize(const std::string& width,
                              const std::string& height, CameraRecord* record) {
  const auto width_px = Find(width);
  const auto height_px = Find(height);
  if (!width_px.has_value() || !height_px.has_value()) return;
  record->width_px = width_px->Integer();
  record->height_px = height_px->Integer();
}

void KeyReader::ReadCoefficients(bool is_fisheye,
                                 std::vector<std::vector<double>>* lenses) {
  // In the order of OpenCV's vectors of coefficients.
  static const std::vector<const char*> kPolynomial = {"k1", "k2", "p1", "p2",
                                                       "k3", "k4", "k5", "k6"};
  static const std::vector<const char*> kFisheye = {"k1", "k2", "k3", "k4"};
  const auto& terms = is_fisheye ? kFisheye : kPolynomial;
  // The vector has at least this length. A file may omit terms that are 0, such
  // as all but k1.
  const size_t fewest = is_fisheye ? 4 : 5;
  std::vector<double> numbered;
  for (size_t i = 0; i < terms.size(); ++i) {
    const auto field = Find(terms[i]);
    if (!field.has_value()) continue;
    numbered.resize(std::max(i + 1, fewest), 0.0);
    numbered[i] = field->Number();
  }
  if (!numbered.empty()) lenses->push_back(numbered);
  const auto radial = Find("k");
  const auto tangential = Find("p");
  if (!radial.has_value() && !tangential.has_value()) return;
  const std::vector<double> k = At("k").Matrix(3, 1);
  const std::vector<double> p = At("p").Matrix(2, 1);
  lenses->push_back({k[0], k[1], p[0], p[1], k[2]});
}

void KeyReader::ReadLens(CameraRecord* record) {
  std::vector<std::vector<double>> lenses;
  bool is_fisheye = false;
  for (const auto& [key, value] : object_.value().items()) {
    const JsonField field = *object_.Find(key);
    if (IsModelKey(key)) {
      read_.insert(key);
      is_fisheye = IsFisheyeModel(field) || is_fisheye;
    } else if (IsFisheyeKey(key)) {
      read_.insert(key);
      const bool is_true = value.is_number()
                               ? field.Number() != 0.0
                               : !value.is_null() && field.Boolean();
      if (is_true && Plain(key) == "omnidirectional") {
        field.Fail("found true: omnidirectional lenses are not supported");
      }
      is_fisheye = is_true || is_fisheye;
    } else if (IsLensKey(key)) {
      read_.insert(key);
      if (!value.is_null()) lenses.push_back(field.Numbers());
    }
  }
  ReadCoefficients(is_fisheye, &lenses);
  for (const std::vector<double>& lens : lenses) {
    if (WithoutZeros(lens) != WithoutZeros(lenses.front())) {
      object_.Fail("specifies its lens twice, with different coefficients");
    }
  }
  if (!lenses.empty()) record->distortion = lenses.front();
  if (is_fisheye) record->lens_model = kFisheyeModel;
}

void KeyReader::ReadUnit(CalibrationFile* file) {
  static const std::pair<LengthUnit, std::set<std::string>> kUnits[] = {
      {LengthUnit::kMetre, SetOf("m metre metres meter meters")},
      {LengthUnit::kCentimetre,
       SetOf("cm centimetre centimetres centimeter centimeters")},
      {LengthUnit::kMillimetre,
       SetOf("mm millimetre millimetres millimeter millimeters")}};
  for (const char* key : {"unit", "units"}) {
    const auto field = Find(key);
    if (!field.has_value()) continue;
    const std::string name = Plain(field->Text());
    const auto* const unit = std::find_if(
        std::begin(kUnits), std::end(kUnits),
        [&](const auto& one) { return one.second.count(name) > 0; });
    if (unit == std::end(kUnits)) field->FailExpected("'m', 'cm' or 'mm'");
    file->unit = unit->first;
    file->states_unit = true;
  }
}

void KeyReader::RejectUnread() const {
  for (const auto& [key, value] : object_.value().items()) {
    if (read_.count(key) == 0 && !IsHarmlessKey(key)) FailUnread(object_, key);
  }
}

}  // namespace kinegraph
