#include "core/io/calibration/keys.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "core/base/error.h"

namespace kinegraph {
namespace {

// "dist_coeffs", "distCoeffs" and "Dist-Coeffs" are one name.
std::string Plain(const std::string& key) {
  std::string plain;
  for (const char c : key) {
    if (c == '_' || c == '-' || c == ' ') continue;
    plain += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return plain;
}

// Lists of coefficients in OpenCV's order. The letters are looked at as they
// are: "K" is the camera matrix and "k" the radial terms.
bool IsLensKey(const std::string& key) {
  static const std::set<std::string> kNames = {"dist",
                                               "kc",
                                               "distcoef",
                                               "distcoefs",
                                               "distcoeff",
                                               "distcoeffs",
                                               "distcoefficient",
                                               "distcoefficients",
                                               "distortion",
                                               "distortions",
                                               "distortioncoef",
                                               "distortioncoefs",
                                               "distortioncoeff",
                                               "distortioncoeffs",
                                               "distortioncoefficient",
                                               "distortioncoefficients",
                                               "distortionparameters",
                                               "distortionparams",
                                               "distortionvector",
                                               "lensdistortion"};
  return key == "D" || key == "d" || kNames.count(Plain(key)) > 0;
}

bool IsModelKey(const std::string& key) {
  static const std::set<std::string> kNames = {
      "model",       "distortionmodel", "lensmodel",
      "cameramodel", "cammodel",        "lenstype",
      "distmodel",   "projectionmodel", "distortiontype"};
  return kNames.count(Plain(key)) > 0;
}

bool IsFisheyeKey(const std::string& key) {
  static const std::set<std::string> kNames = {"fisheye", "fisheyemodel",
                                               "isfisheye", "omnidirectional"};
  return kNames.count(Plain(key)) > 0;
}

// Places of k1 k2 p1 p2 k3 k4 k5 k6 in OpenCV's vector, or of k1 k2 k3 k4.
const std::map<std::string, size_t>& NumberedTerms(bool is_fisheye) {
  static const std::map<std::string, size_t> kTerms = {
      {"k1", 0}, {"k2", 1}, {"p1", 2}, {"p2", 3},
      {"k3", 4}, {"k4", 5}, {"k5", 6}, {"k6", 7}};
  static const std::map<std::string, size_t> kOfFisheye = {
      {"k1", 0}, {"k2", 1}, {"k3", 2}, {"k4", 3}};
  return is_fisheye ? kOfFisheye : kTerms;
}

std::vector<double> WithoutZeros(std::vector<double> coefficients) {
  while (!coefficients.empty() && coefficients.back() == 0.0) {
    coefficients.pop_back();
  }
  return coefficients;
}

// Whether the model is OpenCV's fisheye one, by the names that ROS, Kalibr and
// others give it.
bool IsFisheyeModel(const JsonField& model) {
  if (model.value().is_null()) return false;
  const std::string name = Plain(model.Text());
  static const std::set<std::string> kFisheye = {
      "fisheye",           "opencvfisheye",  "kannalabrandt",
      "kannalabrandt4",    "kannalabrandt8", "kb4",
      "equidistant",       "equi",           "pinholeequi",
      "pinholeequidistant"};
  if (kFisheye.count(name) > 0) return true;
  static const std::set<std::string> kPolynomials = {"pinhole",
                                                     "opencv",
                                                     "opencv5",
                                                     "plumbbob",
                                                     "radtan",
                                                     "brown",
                                                     "brownconrady",
                                                     "perspective",
                                                     "pinholeradtan",
                                                     "fullopencv",
                                                     "standard",
                                                     "polynomial",
                                                     "none",
                                                     "regular",
                                                     "pinholecamera",
                                                     "rationalpolynomial",
                                                     "radialtangential"};
  if (kPolynomials.count(name) == 0) {
    model.FailExpected(
        "'pinhole', 'opencv' or another name of OpenCV's polynomial, or "
        "'fisheye'");
  }
  return false;
}

}  // namespace

bool IsHarmlessKey(const std::string& key) {
  static const std::set<std::string> kNames = {
      // Who and when.
      "name", "id", "index", "idx", "number", "label", "serial", "serialno",
      "serialnumber", "camera", "cameraname", "cameraid", "camid", "camname",
      "cameraserial", "type", "panel", "node", "vendor", "manufacturer", "make",
      "sensor", "date", "datetime", "time", "timestamp", "created", "createdat",
      "calibrationtime", "calibrationdate", "calibdate", "version", "author",
      "comment", "comments", "note", "notes", "description", "title", "info",
      "software", "program", "generator", "tool", "source", "calibdatasource",
      "path", "file", "filename", "image", "images", "imagelist", "imagefiles",
      "video", "videos", "metadata", "meta",
      // Sizes and rates.
      "size", "imgsize", "imagesize", "resolution", "width", "height", "w", "h",
      "imagewidth", "imageheight", "imgwidth", "imgheight", "fps", "framerate",
      "frames", "nframes", "nrofframes", "numframes", "ncameras", "numcameras",
      // How good the calibration was.
      "error", "errors", "rms", "rmse", "rmserror", "residual", "residuals",
      "reprojectionerror", "reprojerror", "meanerror", "meanreprojectionerror",
      "avgreprojectionerror", "averagereprojectionerror", "totalavgerr",
      "perviewerrors", "perviewreprojectionerrors", "stddeviations", "std",
      "adjusted", "converged", "iterations", "inliers",
      // What it was made from.
      "board", "boardtype", "boardsize", "boardwidth", "boardheight",
      "squaresize", "squarelength", "markersize", "markerlength", "pattern",
      "patternsize", "dictionary", "flags", "flagvalue", "fixaspectratio",
      "aspectratio", "imagepoints", "gridpoints", "objectpoints",
      // Poses of the board in the pictures (OpenCV), and what belongs to
      // rectified images (ROS) or to undistorting them (4D association).
      "extrinsicparameters", "rectificationmatrix", "projectionmatrix",
      "rectifyalpha", "newcameramatrix", "optimalcameramatrix", "roi",
      "binningx", "binningy"};
  return (!key.empty() && key.front() == '_') || kNames.count(Plain(key)) > 0;
}

bool IsNoCamera(const std::string& key, const JsonField& field) {
  if (field.value().is_object() || field.value().is_array()) return false;
  return IsHarmlessKey(key) || key == "unit" || key == "units";
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

std::optional<JsonField> KeyReader::FindAny(
    const std::vector<std::string>& keys) {
  for (const std::string& key : keys) {
    if (auto field = object_.Find(key)) {
      read_.insert(key);
      return field;
    }
  }
  return std::nullopt;
}

JsonField KeyReader::AtAny(const std::vector<std::string>& keys) {
  if (auto field = FindAny(keys)) return *std::move(field);
  std::string all;
  for (const std::string& key : keys) {
    all += (all.empty() ? "'" : " or '") + key + "'";
  }
  object_.Fail("has no key " + all);
}

void KeyReader::ReadCoefficients(bool is_fisheye,
                                 std::vector<std::vector<double>>* lenses) {
  std::vector<double> numbered;
  for (const auto& [key, place] : NumberedTerms(is_fisheye)) {
    const auto field = Find(key);
    if (!field.has_value()) continue;
    numbered.resize(std::max(numbered.size(), place + 1), 0.0);
    numbered[place] = field->Number();
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
      object_.Fail("states its lens twice, and not the same one");
    }
  }
  if (!lenses.empty()) record->distortion = lenses.front();
  if (is_fisheye) record->lens_model = kFisheyeModel;
}

void KeyReader::ReadUnit(CalibrationFile* file) {
  static const std::map<std::string, LengthUnit> kUnits = {
      {"m", LengthUnit::kMetre},
      {"metre", LengthUnit::kMetre},
      {"metres", LengthUnit::kMetre},
      {"meter", LengthUnit::kMetre},
      {"meters", LengthUnit::kMetre},
      {"cm", LengthUnit::kCentimetre},
      {"centimetre", LengthUnit::kCentimetre},
      {"centimeter", LengthUnit::kCentimetre},
      {"centimeters", LengthUnit::kCentimetre},
      {"mm", LengthUnit::kMillimetre},
      {"millimetre", LengthUnit::kMillimetre},
      {"millimeter", LengthUnit::kMillimetre},
      {"millimeters", LengthUnit::kMillimetre}};
  for (const char* key : {"unit", "units"}) {
    const auto field = Find(key);
    if (!field.has_value()) continue;
    const auto unit = kUnits.find(Plain(field->Text()));
    if (unit == kUnits.end()) field->FailExpected("'m', 'cm' or 'mm'");
    file->unit = unit->second;
    file->states_unit = true;
  }
}

void KeyReader::RejectUnread() const {
  for (const auto& [key, value] : object_.value().items()) {
    if (read_.count(key) > 0 || IsHarmlessKey(key)) continue;
    object_.Fail("has a key '" + Printable(key) +
                 "' that is not known in this format: it could carry lens or "
                 "pose, so it is not passed over");
  }
}

Eigen::Matrix3d ReadRotation(const JsonField& field) {
  const bool nested = field.value().is_array() && field.value().size() == 3 &&
                      field.value().front().is_array();
  if (nested && field.value().front().size() == 3) {
    return ToMatrix3(field.Matrix(3, 3));
  }
  return RotationOf(ToVector3(field.Matrix(3, 1)));
}

}  // namespace kinegraph
