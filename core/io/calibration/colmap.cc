// COLMAP's text model: a folder with
//   cameras.txt  CAMERA_ID MODEL WIDTH HEIGHT PARAMS...
//   images.txt   IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of
//                the image's points, which may be empty
// points3D.txt does not describe cameras and is ignored. Lines that begin with
// # are comments. x_cam = R X + t in COLMAP's arbitrary scale (metres unless
// cameras.unit is given). The centre of the first pixel is (0.5, 0.5) there and
// (0, 0) here (https://colmap.github.io/format.html, as of 3.8).
//
// A static camera is one image. The camera's name is that of the image without
// the extension, or that of the image's folder if each image has its own
// folder.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/calibration/format.h"
#include "core/io/calibration/write_formats.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "core/io/text/words.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

constexpr double kPixelMiddle = 0.5;  // px
constexpr const char* kCameras = "cameras.txt";
constexpr const char* kImages = "images.txt";

std::vector<std::string> WordsOf(const std::string& line) {
  std::vector<std::string> words;
  Words rest(line);
  for (auto word = rest.Next(); !word.empty(); word = rest.Next()) {
    words.emplace_back(word);
  }
  return words;
}

// Lines of a file, split into words; errors name the line.
class ModelFile {
 public:
  explicit ModelFile(const std::string& path)
      : path_(path), text_(ReadTextFile(path, kMaxSmallFileBytes)) {}

  // The next line that is not a comment; skips empty ones unless `keep_empty`.
  bool Next(std::vector<std::string>* words, bool keep_empty = false) {
    while (at_ < text_.size()) {
      const size_t end = std::min(text_.find('\n', at_), text_.size());
      *words = WordsOf(text_.substr(at_, end - at_));
      at_ = end + 1;
      ++line_;
      if (words->empty() ? keep_empty : words->front()[0] != '#') return true;
    }
    return false;
  }

  [[noreturn]] void Fail(const std::string& message) const {
    throw InputError(path_, "line " + std::to_string(line_), message);
  }

  double Number(const std::string& word) const {
    const auto number = ParseNumber<double>(word);
    if (number.has_value() && std::isfinite(*number)) return *number;
    Fail("found '" + Printable(word) + "', expected a finite number");
  }

  int64_t Integer(const std::string& word) const {
    if (const auto number = ParseNumber<int64_t>(word)) return *number;
    Fail("found '" + Printable(word) + "', expected a whole number");
  }

 private:
  const std::string path_;
  const std::string text_;
  size_t at_ = 0;
  int64_t line_ = 0;
};

struct ColmapModel {
  const char* name;
  int focal_lengths;  // 1: one for both axes; 2: fx and fy
  // Number of coefficients, which are the first of k1 k2 p1 p2 k3 k4 k5 k6; of
  // k1 k2 k3 k4 for a fisheye model.
  int coefficients;
  bool is_fisheye = false;
};

// The model of this name; nullptr if neither OpenCV's polynomial nor its
// fisheye model can represent it.
const ColmapModel* FindModel(const std::string& name) {
  static const std::vector<ColmapModel> kModels = {
      {"SIMPLE_PINHOLE", 1, 0},
      {"PINHOLE", 2, 0},
      {"SIMPLE_RADIAL", 1, 1},
      {"RADIAL", 1, 2},
      {"OPENCV", 2, 4},
      {"FULL_OPENCV", 2, 8},
      {"SIMPLE_FISHEYE", 1, 0, true},
      {"FISHEYE", 2, 0, true},
      {"SIMPLE_RADIAL_FISHEYE", 1, 1, true},
      {"RADIAL_FISHEYE", 1, 2, true},
      {"OPENCV_FISHEYE", 2, 4, true}};
  for (const ColmapModel& model : kModels) {
    if (name == model.name) return &model;
  }
  return nullptr;
}

CameraRecord ReadIntrinsics(const ModelFile& file,
                            const std::vector<std::string>& words) {
  if (words.size() < 4) {
    file.Fail("expected CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS");
  }
  const ColmapModel* model = FindModel(words[1]);
  if (model == nullptr) {
    file.Fail(
        "the lens model '" + Printable(words[1]) +
        "' is not supported, expected SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, "
        "RADIAL, OPENCV, FULL_OPENCV, SIMPLE_FISHEYE, FISHEYE, "
        "SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE or OPENCV_FISHEYE "
        "(COLMAP's image_undistorter converts other models, and their images, "
        "to PINHOLE)");
  }
  const auto count =
      static_cast<size_t>(model->focal_lengths + 2 + model->coefficients);
  if (words.size() != 4 + count) {
    file.Fail("found " + std::to_string(words.size() - 4) +
              " parameters, expected the " + std::to_string(count) + " of " +
              words[1]);
  }
  std::vector<double> numbers;
  for (size_t i = 4; i < words.size(); ++i) {
    numbers.push_back(file.Number(words[i]));
  }
  CameraRecord record;
  record.width_px = file.Integer(words[2]);
  record.height_px = file.Integer(words[3]);
  const auto next = numbers.begin() + model->focal_lengths;
  record.K = CameraMatrix({numbers[0], *(next - 1), next[0] - kPixelMiddle,
                           next[1] - kPixelMiddle});
  record.distortion.assign(next + 2, numbers.end());
  if (model->is_fisheye) record.lens_model = kFisheyeModel;
  // MakeLens rejects a single coefficient of OpenCV's polynomial; a fisheye
  // lens with a further 0 is the same.
  if (record.distortion.size() == 1) record.distortion.push_back(0.0);
  return record;
}

std::map<int64_t, CameraRecord> ReadAllIntrinsics(const std::string& path) {
  std::map<int64_t, CameraRecord> cameras;
  ModelFile file(path);
  std::vector<std::string> words;
  while (file.Next(&words)) {
    const int64_t id = file.Integer(words[0]);
    if (!cameras.emplace(id, ReadIntrinsics(file, words)).second) {
      file.Fail("camera " + words[0] + " appears twice");
    }
  }
  return cameras;
}

CameraRecord ReadImage(const ModelFile& file,
                       const std::vector<std::string>& words,
                       const std::map<int64_t, CameraRecord>& intrinsics) {
  if (words.size() < 10) {
    file.Fail("found " + std::to_string(words.size()) +
              " words, expected IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, "
              "CAMERA_ID, NAME");
  }
  const auto at = intrinsics.find(file.Integer(words[8]));
  if (at == intrinsics.end()) {
    file.Fail("camera " + Printable(words[8]) + " is not in cameras.txt");
  }
  CameraRecord record = at->second;
  const auto number = [&](size_t i) { return file.Number(words[i]); };
  const auto R = RotationOf({number(1), number(2), number(3), number(4)});
  if (!R.has_value()) file.Fail("QW, QX, QY, QZ are not a unit quaternion");
  record.R = *R;
  record.t = {number(5), number(6), number(7)};
  record.name =
      fmt::format("{}", fmt::join(words.begin() + 9, words.end(), " "));
  return record;
}

// Checks the second line of an image: X, Y, POINT3D_ID of each point.
void CheckPoints(const ModelFile& file, const std::vector<std::string>& words) {
  if (words.size() % 3 == 0 &&
      std::all_of(words.begin(), words.end(), [](const std::string& word) {
        return ParseNumber<double>(word).has_value();
      })) {
    return;
  }
  file.Fail(
      "expected the points of the image (X, Y, POINT3D_ID, ...), or an empty "
      "line if it has none");
}

// Replaces the names of the images by those of the cameras: the image's path
// without the extension, or its folder if each image is in a folder of its own.
void NameByImages(std::vector<CameraRecord>* cameras) {
  std::set<std::string> folders;
  for (const CameraRecord& camera : *cameras) {
    folders.insert(fs::path(camera.name).parent_path().string());
  }
  const bool by_folder =
      folders.count("") == 0 && folders.size() == cameras->size();
  for (CameraRecord& camera : *cameras) {
    const fs::path image(camera.name);
    camera.name = by_folder ? image.parent_path().string()
                            : (image.parent_path() / image.stem()).string();
  }
}

bool IsModelName(const std::string& path) {
  const std::string name = fs::path(path).filename().string();
  return name == kCameras || name == kImages;
}

void CheckImageName(const Camera& camera) {
  if (!camera.name().empty() &&
      camera.name().find_first_of(" \t\r\n/\\#") == std::string::npos) {
    return;
  }
  throw CannotWrite(
      camera,
      "the name cannot be the name of an image in COLMAP, expected "
      "no spaces, '/', '\\' or '#'");
}

std::string CameraLine(const Camera& camera, size_t id) {
  if (!HasSize(camera)) {
    throw CannotWrite(camera,
                      "COLMAP needs the image size, which the input does not "
                      "specify (--image_size=W,H)");
  }
  const Eigen::Matrix3d& K = camera.K();
  CheckSkew(camera);
  std::string model = "PINHOLE";
  std::string terms;
  const auto add = [&terms](double term) { terms += fmt::format(" {}", term); };
  if (IsFisheye(camera)) {
    model = "OPENCV_FISHEYE";
    for (const double term : camera.lens()->parameters()) add(term);
  } else if (camera.lens() != nullptr) {
    const auto lens = OpenCvCoefficients(camera);
    const bool is_full = lens[4] != 0.0;
    model = is_full ? "FULL_OPENCV" : "OPENCV";
    for (int k = 0; k < (is_full ? 5 : 4); ++k) add(lens[k]);
    if (is_full) terms += " 0 0 0";
  }
  return fmt::format("{} {} {} {} {} {} {} {}{}\n", id, model,
                     camera.width_px(), camera.height_px(), K(0, 0), K(1, 1),
                     K(0, 2) + kPixelMiddle, K(1, 2) + kPixelMiddle, terms);
}

std::string ImageLines(const Camera& camera, size_t id) {
  Eigen::Quaterniond turn(camera.R());
  if (turn.w() < 0.0) turn.coeffs() = -turn.coeffs();
  const Eigen::Vector3d& t = camera.t();
  // The second line, for the image's points, is empty.
  return fmt::format("{} {} {} {} {} {} {} {} {} {}.png\n\n", id, turn.w(),
                     turn.x(), turn.y(), turn.z(), t.x(), t.y(), t.z(), id,
                     camera.name());
}

}  // namespace

CalibrationFile ReadColmap(const CalibrationHead& head) {
  if (!head.is_folder && !IsModelName(head.path)) {
    throw InputError(head.path, "",
                     "expected cameras.txt, images.txt or their folder");
  }
  const fs::path path_given = head.path;
  const fs::path folder =
      head.is_folder ? path_given : path_given.parent_path();
  const auto intrinsics = ReadAllIntrinsics((folder / kCameras).string());
  const std::string path = (folder / kImages).string();
  CalibrationFile result;
  ModelFile file(path);
  std::vector<std::string> words;
  while (file.Next(&words)) {
    result.cameras.push_back(ReadImage(file, words, intrinsics));
    result.cameras.back().file = path;
    if (!file.Next(&words, /*keep_empty=*/true)) break;
    CheckPoints(file, words);
  }
  NameByImages(&result.cameras);
  return result;
}

bool RecogniseColmap(const CalibrationHead& head) {
  if (head.is_folder) {
    return head.HasFile(kCameras) && head.HasFile(kImages) &&
           !HasTumFiles(head.names);
  }
  return head.Is(CalibrationSyntax::kOther) && IsModelName(head.path);
}

void WriteColmap(const std::string& path, const CameraRig& cameras,
                 LostFields* lost_fields) {
  std::string intrinsics = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  std::string images =
      "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
      "# POINTS2D[] as (X, Y, POINT3D_ID)\n";
  for (size_t c = 0; c < cameras.size(); ++c) {
    CheckImageName(cameras[c]);
    intrinsics += CameraLine(cameras[c], c + 1);
    images += ImageLines(cameras[c], c + 1);
  }
  AtomicFolder folder(path);
  WriteTextFile(folder.PathOf(kCameras), intrinsics);
  WriteTextFile(folder.PathOf(kImages), images);
  WriteTextFile(folder.PathOf("points3D.txt"),
                "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, "
                "POINT2D_IDX)\n");
  folder.Commit();
  NoteSkew(cameras, lost_fields);
}

}  // namespace kinegraph
