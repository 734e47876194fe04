// TOML of Pose2Sim, Anipose, FreeMoCap and Caliscope, one table per camera:
// name, size [w, h], matrix 3x3 px, distortions [k1, k2, p1, p2(, k3)] or, with
// fisheye = true, [k1, k2, k3, k4], rotation (Rodrigues vector or 3x3,
// cam_from_world), translation. The table "metadata" is not a camera. Lengths
// are metres in Pose2Sim's and Caliscope's files; in Anipose's and FreeMoCap's
// they have the unit of the calibration board. Without cameras.unit they are
// read as millimetres if FreeMoCap's metadata, or a board.toml beside one of
// the session's files named below, specifies squares with sides above 1,
// otherwise as metres.
//
// Caliscope's camera_array.toml has the cameras in the table "cameras"; its
// config.toml has them at the top level, beside the tables of the board and of
// the stereo calibrations of pairs. Cameras without a pose ("null", or no key
// in newer versions) and cameras that Caliscope ignores are skipped.
//
// In a session's folder, the file with the cameras is read: camera_array.toml
// (Caliscope), calibration.toml (FreeMoCap, Anipose, sleap-anipose) or
// config.toml (old versions of Caliscope).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <set>

#include "core/base/error.h"
#include "core/io/calibration/format.h"
#include "core/io/calibration/write_formats.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "core/io/text/toml_file.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

bool IsText(const std::optional<JsonField>& field, const char* text) {
  return field.has_value() && field->value().is_string() &&
         field->Text() == text;
}

// Whether Caliscope ignores the camera or found no pose for it.
bool IsUnplaced(const JsonField& camera) {
  const auto ignore = camera.Find("ignore");
  if (ignore.has_value() && ignore->value().is_boolean() && ignore->Boolean()) {
    return true;
  }
  return IsText(camera.Find("rotation"), "null") &&
         IsText(camera.Find("translation"), "null");
}

// Newer versions of Caliscope omit unknown poses.
bool HasNoPose(const JsonField& camera) {
  return !camera.Find("rotation").has_value() &&
         !camera.Find("translation").has_value();
}

// Whether a table or value of Caliscope's and Anipose's files is not a camera.
// Cameras may have these names, too, but have a matrix and a pose.
bool IsBesideCameras(const std::string& key, const JsonField& field) {
  static const std::set<std::string> kKeys = {"metadata",
                                              "capture_volume",
                                              "charuco",
                                              "camera_count",
                                              "creation_date",
                                              "point_estimates",
                                              "fps_recording",
                                              "fps_sync_stream_processing",
                                              "save_tracked_points_video"};
  constexpr const char* kPair = "stereo_";
  const Json& table = field.value();
  if (table.is_object() && table.contains("matrix") &&
      table.contains("rotation") && table.contains("translation")) {
    return false;
  }
  return kKeys.count(key) > 0 || key.rfind(kPair, 0) == 0;
}

CameraRecord ReadPose2simCamera(const std::string& name,
                                const JsonField& field) {
  return ReadNamed(field, name, [](KeyReader* camera, CameraRecord* record) {
    camera->ReadImageSize("size", record);
    record->K = camera->Matrix3("matrix");
    camera->ReadLens(record);
    record->R = ReadRotation(camera->At("rotation"));
    record->t = camera->Vector3("translation");
    // Accepts, but does not use, Caliscope's display options and calibration
    // statistics, and the inverse pose that newer versions of FreeMoCap add.
    for (const char* key :
         {"port", "rotation_count", "exposure", "grid_count", "ignore",
          "verified_resolutions", "world_orientation", "world_position"}) {
      camera->Find(key);
    }
  });
}

// Whether FreeMoCap's lengths are millimetres: its metadata state the side of
// the board's squares, which users give in millimetres or leave at 1.
bool IsInMillimetres(const JsonField& root) {
  const auto metadata = root.Find("metadata");
  if (!metadata.has_value() || !metadata->value().is_object()) return false;
  const auto square = metadata->Find("charuco_square_size");
  return square.has_value() && square->value().is_number() &&
         square->Number() > 1.0;
}

constexpr const char* kConfig = "config.toml";
// Files with the cameras of a session, in order of preference.
constexpr std::array kSessionFiles = {"camera_array.toml", "calibration.toml",
                                      kConfig};

// Whether a table contains cameras: other programs have a config.toml, too.
bool HasCameras(const Json& root) {
  const auto is_camera = [](const Json& table) {
    return table.is_object() && table.contains("matrix") &&
           table.contains("rotation");
  };
  return std::any_of(root.begin(), root.end(), is_camera);
}

// The file with the cameras in a session's folder; empty if there is none.
fs::path SessionFile(const CalibrationHead& head) {
  const fs::path folder = head.path;
  for (const char* name : kSessionFiles) {
    if (!head.HasFile(name)) continue;
    if (name == kConfig && !HasCameras(ReadToml((folder / name).string()))) {
      continue;
    }
    return folder / name;
  }
  return {};
}

// Whether the board beside a session's calibration has squares with sides above
// 1, too large for metres.
bool HasBoardInMillimetres(const fs::path& calibration) {
  const std::string name = calibration.filename().string();
  if (std::find(kSessionFiles.begin(), kSessionFiles.end(), name) ==
      kSessionFiles.end()) {
    return false;
  }
  const fs::path board = calibration.parent_path() / "board.toml";
  if (!IsFile(board.string())) return false;
  const Json json = ReadToml(board.string());
  const auto square = json.find("square_length");
  return square != json.end() && square->is_number() &&
         square->get<double>() > 1.0;
}

// `path`: the file that contains `root`.
CalibrationFile ReadTables(const fs::path& path, const JsonField& root) {
  CalibrationFile file;
  if (IsInMillimetres(root) || HasBoardInMillimetres(path)) {
    file.unit = LengthUnit::kMillimetre;
  }
  const auto inside = root.Find("cameras");
  const bool is_camera_array = inside.has_value() &&
                               inside->value().is_object() &&
                               !inside->value().contains("matrix");
  for (const auto& [table, field] :
       (is_camera_array ? *inside : root).Members("camera")) {
    if (IsBesideCameras(table, field) || table == "CreationDate") continue;
    const bool is_table = field.value().is_object();
    if (is_table &&
        (IsUnplaced(field) || (is_camera_array && HasNoPose(field)))) {
      continue;
    }
    const auto name = is_table ? field.Find("name") : std::nullopt;
    // Caliscope's videos are cam_0.mp4, cam_1.mp4, ...
    file.cameras.push_back(ReadPose2simCamera(
        name.has_value() ? name->Text()
                         : (is_camera_array ? "cam_" : "") + table,
        field));
  }
  return file;
}

}  // namespace

bool RecognisePose2sim(const CalibrationHead& head) {
  return head.is_folder ? !SessionFile(head).empty()
                        : head.Is(CalibrationSyntax::kToml);
}

CalibrationFile ReadPose2sim(const CalibrationHead& head) {
  if (!head.is_folder) return ReadTables(head.path, head.Root());
  const fs::path path = SessionFile(head);
  if (path.empty()) {
    throw InputError(head.path, "",
                     "has no camera_array.toml, calibration.toml or "
                     "config.toml with cameras");
  }
  const Json json = ReadToml(path.string());
  return ReadTables(path, JsonField(json, path.string()));
}

void WritePose2sim(const std::string& path, const CameraRig& cameras,
                   LostFields* lost_fields) {
  NoteUnknownSizes(cameras, lost_fields);
  std::string text;
  int number = 0;
  for (const Camera& camera : cameras) {
    const Eigen::Matrix3d& K = camera.K();
    text += fmt::format("[cam_{:02}]\n", ++number);
    // JSON's escapes are valid in TOML.
    text += "name = " + JsonText(camera.name()) + "\n";
    if (HasSize(camera)) {
      const Eigen::Vector2d size(camera.width_px(), camera.height_px());
      text += "size = " + DecimalList(size) + "\n";
    }
    text += "matrix = [" + DecimalList(K.row(0)) + ", " +
            DecimalList(K.row(1)) + ", " + DecimalList(K.row(2)) + "]\n";
    // k3 only if it is not zero, as in Pose2Sim's files.
    Eigen::RowVectorXd terms = LensTerms(camera);
    if (terms.size() == 5 && terms[4] == 0.0) terms.conservativeResize(4);
    text += "distortions = " + DecimalList(terms) + "\n";
    text += "rotation = " + DecimalList(RotationVector(camera.R())) + "\n";
    text += "translation = " + DecimalList(camera.t()) + "\n";
    text += IsFisheye(camera) ? "fisheye = true\n\n" : "fisheye = false\n\n";
  }
  WriteTextFile(path, text + "[metadata]\nadjusted = false\nerror = 0.0\n");
}

}  // namespace kinegraph
