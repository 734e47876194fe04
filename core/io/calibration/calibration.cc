#include "core/io/calibration/calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_set>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/io/adapters/adapter.h"
#include "core/io/calibration/format.h"

namespace kinegraph {
namespace {

CalibrationFile ReadFile(const std::string& path, const std::string& name) {
  if (name != "auto") {
    const CalibrationFormat* format = FindCalibrationFormat(name);
    if (format == nullptr) {
      throw OptionError(
          "cameras.format",
          "found '" + Printable(name) + "', which is no calibration format");
    }
    return format->read(LookAtCalibration(path, *format));
  }
  if (const auto given = GivenAdapterOf(path, AdapterKind::kCameras)) {
    return ReadByAdapter(*given, path);
  }
  const CalibrationHead head = LookAtCalibration(path);
  const CalibrationFormat* format = RecogniseCalibration(head);
  if (format != nullptr) return format->read(head);
  if (const auto adapter = AdapterOf(path, AdapterKind::kCameras)) {
    return ReadByAdapter(*adapter, path);
  }
  throw InputError(
      path, "",
      head.is_folder
          ? "is a folder without files of a known calibration format, such as "
            "calibration.toml, intri.yml or P0.txt"
          : "is not a calibration in a known format (specify the format by "
            "cameras.format)");
}

// ---- From records to cameras ----

struct ImageSize {
  int64_t width_px = 0;  // 0: unknown
  int64_t height_px = 0;
};

ImageSize SizeOf(const CameraReadOptions& options) {
  const std::vector<double>& size = options.image_size;
  if (size.empty()) return {};
  const auto whole = [](double side) {
    return side > 0.0 && side <= std::numeric_limits<int>::max() &&
           side == std::floor(side);
  };
  if (size.size() != 2 || !whole(size[0]) || !whole(size[1])) {
    throw OptionError("cameras.image_size",
                      "expected two whole numbers > 0: width and height in px");
  }
  return {static_cast<int64_t>(size[0]), static_cast<int64_t>(size[1])};
}

double PerMetre(const CalibrationFile& file, const std::string& path,
                LengthUnit option) {
  if (file.states_unit && option != LengthUnit::kAuto && option != file.unit) {
    throw InputError(path, "",
                     "specifies its unit, which cameras.unit cannot change");
  }
  switch (option == LengthUnit::kAuto ? file.unit : option) {
    case LengthUnit::kCentimetre:
      return kCentimetresPerMetre;
    case LengthUnit::kMillimetre:
      return kMillimetresPerMetre;
    default:
      return 1.0;
  }
}

std::string Text(const ImageSize& size) {
  return std::to_string(size.width_px) + " x " + std::to_string(size.height_px);
}

// Makes a camera of a record; every error names file and camera.
class CameraBuilder {
 public:
  CameraBuilder(const CameraRecord& record, double per_metre,
                const CameraReadOptions& options)
      : record_(record), per_metre_(per_metre), options_(options) {}

  Camera Build() const {
    const ImageSize size = ChooseSize();
    CameraParameters parameters;
    parameters.name = record_.name;
    parameters.width_px = static_cast<int>(size.width_px);
    parameters.height_px = static_cast<int>(size.height_px);
    parameters.K = ChooseK(size);
    try {
      parameters.lens = ChooseLens();
      parameters.R = record_.R;
      if (record_.centre.has_value()) {
        // Compute t from the orthonormalised rotation, so that the centre is
        // exact.
        parameters.R = Camera(parameters).R();
        parameters.t = -(parameters.R * (*record_.centre / per_metre_));
      } else {
        parameters.t = record_.t / per_metre_;
      }
      Camera camera(parameters);
      if (!camera.P().allFinite() || !camera.centre().allFinite()) {
        Fail("the numbers are too large for a projection");
      }
      return camera;
    } catch (const OptionError& error) {
      Fail(error.what());
    }
  }

 private:
  [[noreturn]] void Fail(const std::string& message) const {
    throw InputError(record_.file, "camera '" + Printable(record_.name) + "'",
                     message);
  }

  ImageSize ChooseSize() const {
    const ImageSize own = {record_.width_px, record_.height_px};
    constexpr int64_t kLargest = std::numeric_limits<int>::max();
    if (own.width_px < 0 || own.height_px < 0 || own.width_px > kLargest ||
        own.height_px > kLargest ||
        (own.width_px == 0) != (own.height_px == 0)) {
      Fail("found an image size of " + Text(own) + " px");
    }
    const ImageSize option = SizeOf(options_);
    if (own.width_px == 0 || IsScaled(own, option)) return option;
    if (option.width_px != 0 && (own.width_px != option.width_px ||
                                 own.height_px != option.height_px)) {
      Fail("the image size is " + Text(own) +
           " px, but cameras.image_size is " + Text(option));
    }
    return own;
  }

  // Whether an image of the size `picture` may show the whole sensor at another
  // resolution: the aspect ratios agree, up to rounding of the sides.
  bool IsScaled(const ImageSize& sensor, const ImageSize& picture) const {
    if (!record_.may_be_scaled || picture.width_px == 0) return false;
    const double high = static_cast<double>(picture.width_px) *
                        static_cast<double>(sensor.height_px) /
                        static_cast<double>(sensor.width_px);
    return std::abs(high - static_cast<double>(picture.height_px)) < 1.0;
  }

  Eigen::Matrix3d ChooseK(const ImageSize& size) const {
    Eigen::Matrix3d K = record_.K;
    if (record_.normalised_K) {
      if (size.width_px == 0) {
        Fail(
            "K refers to coordinates divided by the image size, which "
            "cameras.image_size must specify");
      }
      K.row(0) *= static_cast<double>(size.width_px);
      K.row(1) *= static_cast<double>(size.height_px);
    }
    if (record_.width_px == 0 || size.width_px == record_.width_px) return K;
    const Eigen::Vector2d scale(static_cast<double>(size.width_px) /
                                    static_cast<double>(record_.width_px),
                                static_cast<double>(size.height_px) /
                                    static_cast<double>(record_.height_px));
    // The centre of the first pixel is (0, 0) at both resolutions.
    for (int i = 0; i < 2; ++i) {
      K.row(i) *= scale[i];
      K(i, 2) += 0.5 * scale[i] - 0.5;
    }
    return K;
  }

  std::shared_ptr<const Lens> ChooseLens() const {
    if (options_.ignore_distortion) return nullptr;
    std::vector<double> coefficients = record_.distortion;
    // A longer OpenCV model whose additional terms are zero is equivalent.
    const size_t count = record_.lens_model == kFisheyeModel ? 4 : 5;
    while (coefficients.size() > count && coefficients.back() == 0.0) {
      coefficients.pop_back();
    }
    return MakeLens(record_.lens_model, coefficients);
  }

  const CameraRecord& record_;
  double per_metre_;
  const CameraReadOptions& options_;
};

// The records named by `use`, in its order; if `use` is empty, all records in
// the order of the file.
std::vector<const CameraRecord*> Choose(const CalibrationFile& file,
                                        const std::string& path,
                                        const std::vector<std::string>& use) {
  if (file.cameras.empty()) throw InputError(path, "", "has no cameras");
  std::map<std::string, const CameraRecord*> by_name;
  std::vector<const CameraRecord*> all;
  for (const CameraRecord& record : file.cameras) {
    if (record.name.empty()) {
      throw InputError(record.file, "", "a camera has an empty name");
    }
    if (!by_name.emplace(record.name, &record).second) {
      throw InputError(path, "camera '" + Printable(record.name) + "'",
                       "appears twice");
    }
    all.push_back(&record);
  }
  if (use.empty()) return all;
  std::vector<const CameraRecord*> chosen;
  std::unordered_set<std::string> seen;
  for (const std::string& name : use) {
    const auto at = by_name.find(name);
    if (at == by_name.end()) {
      throw InputError(path, "",
                       "has no camera '" + Printable(name) +
                           "', which cameras.use lists; its first camera is '" +
                           Printable(file.cameras.front().name) + "' of " +
                           std::to_string(file.cameras.size()));
    }
    if (!seen.insert(name).second) {
      throw OptionError("cameras.use",
                        "lists camera '" + Printable(name) + "' twice");
    }
    chosen.push_back(at->second);
  }
  return chosen;
}

}  // namespace

std::vector<std::string> CalibrationFormatNames() {
  std::vector<std::string> names = {"auto"};
  for (const CalibrationFormat& format : CalibrationFormats()) {
    names.push_back(format.name);
  }
  return names;
}

void CameraReadOptions::Describe(OptionVisitor& visitor) {
  const std::vector<std::string> names = CalibrationFormatNames();
  const auto at = std::find(names.begin(), names.end(), format);
  int index = at == names.end() ? 0 : static_cast<int>(at - names.begin());
  visitor.ChoiceIndex(
      "format", &index, names,
      "format of the calibration; auto recognises it by content");
  format = names[static_cast<size_t>(index)];
  visitor.Choice("unit", &unit, {"auto", "m", "cm", "mm"},
                 "unit of the calibration's lengths; auto is the one of the "
                 "file or its format");
  visitor.NumberList(
      "image_size", &image_size, Positive(), "px",
      "width and height, if the calibration does not specify them");
  visitor.Boolean("ignore_distortion", &ignore_distortion,
                  "treat every camera as an ideal pinhole camera");
  visitor.TextList("use", &use, "names of the cameras to use; empty: all");
  visitor.TextMap("map", &map, "camera of each view, if names do not match");
}

CameraRig ReadCameras(const std::string& path,
                      const CameraReadOptions& options) {
  SizeOf(options);  // report a wrong option before reading files
  const CalibrationFile file = ReadFile(path, options.format);
  const double per_metre = PerMetre(file, path, options.unit);
  CameraRig cameras;
  for (const CameraRecord* record : Choose(file, path, options.use)) {
    cameras.push_back(CameraBuilder(*record, per_metre, options).Build());
  }
  return cameras;
}

CalibrationUnit UnitOfCalibration(const std::string& path,
                                  const CameraReadOptions& options) {
  const CalibrationFile file = ReadFile(path, options.format);
  return {PerMetre(file, path, options.unit), !file.states_unit};
}

}  // namespace kinegraph
