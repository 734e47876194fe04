#include "core/io/tracks/reading_notes.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <utility>
#include <vector>

#include "core/base/median.h"
#include "core/io/files/text_file.h"
#include "core/io/text/joint_names.h"
#include "core/skeleton/body_joints.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;

// People count as standing along an axis within this angle: in a seated person
// the line from the ankles to the shoulders is inclined.
constexpr double kNear_deg = 40.0;

// Median diagonal of the bounding boxes of people [m]; 0 without people.
double MedianExtent(const TrackSequence& tracks) {
  std::vector<double> extents_m;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      if (CountPresent(person.joints) < 2) continue;
      Eigen::AlignedBox3d box;
      for (const Joint3d& joint : person.joints) {
        if (joint.present()) box.extend(joint.position_m);
      }
      extents_m.push_back(box.diagonal().norm());
    }
  }
  return Median(std::move(extents_m));
}

// Wide limits, which a newborn and a tall person with raised arms meet.
bool IsPlausible(double extent_m) { return extent_m > 0.3 && extent_m < 5.0; }

// The axis of the component with the largest magnitude.
int LargestAxis(const Vector3d& direction) {
  Eigen::Index axis = 0;
  direction.cwiseAbs().maxCoeff(&axis);
  return static_cast<int>(axis);
}

// Text such as "-y", or "(0.1, -0.7, 0.7)" if the direction is near no axis.
std::string DirectionText(const Vector3d& direction) {
  const auto axis = NearestAxis(direction, kNear_deg);
  if (!axis) {
    const Vector3d unit = direction.normalized();
    return fmt::format("({:.1f}, {:.1f}, {:.1f})", unit.x(), unit.y(),
                       unit.z());
  }
  const int index = LargestAxis(*axis);
  return std::string((*axis)[index] < 0.0 ? "-" : "") +
         static_cast<char>('x' + index);
}

}  // namespace

std::string UnitNote(const std::string& path, const TrackReadOptions& options,
                     const TrackSequence& tracks) {
  const TrackFormat& format = FormatOfTracks(path, options);
  if (!format.unit_m.has_value()) return "";
  if (!IsHuman(WithOurNames(tracks.header.skeleton))) return "";
  const double extent_m = MedianExtent(tracks);
  if (extent_m == 0.0 || IsPlausible(extent_m)) return "";
  const double unit_m = options.unit_m > 0.0 ? options.unit_m : *format.unit_m;
  std::string fitting;
  std::string used;
  for (const auto& [name, other_m] : kLengthUnits) {
    const double then_m = extent_m * other_m / unit_m;
    if (other_m == unit_m) used = name;
    if (!IsPlausible(then_m)) continue;
    fitting += fmt::format("{}--unit={} makes that {:.2g} m",
                           fitting.empty() ? ": " : ", ", name, then_m);
  }
  return fmt::format("people read from {} in {} have an extent of {:.3g} m{}",
                     format.name, used, extent_m, fitting);
}

Stance StanceOf(const TrackSequence& tracks) {
  const Skeleton named = WithOurNames(tracks.header.skeleton);
  if (!IsHuman(named)) return Stance(named);
  return StanceOf(named, tracks.frames);
}

std::optional<Vector3d> StatedUp(const TrackFormat& format) {
  // Readers map the upward axis to z.
  if (!format.axes.has_value()) return std::nullopt;
  return Vector3d(Vector3d::UnitZ());
}

std::optional<Vector3d> StatedUp(const std::string& path) {
  if (IsPipe(path)) return std::nullopt;
  return StatedUp(FormatOfTracks(path, {}));
}

std::optional<AxesNote> FindAxesNote(const Stance& stance,
                                     const CameraRig& cameras,
                                     const TrackFormat& format,
                                     const std::optional<AxisMap>& axes,
                                     const std::optional<Vector3d>& stated) {
  if (!format.axes.has_value()) return std::nullopt;
  const AxisMap used = axes.value_or(*format.axes);
  // The file's upward axis, to which the format maps the world's z.
  const size_t file_axis = format.axes->FileAxisOf(2);
  const Vector3d shown =
      used.sign[file_axis] * Vector3d::Unit(used.axis[file_axis]);
  const auto up = stance.UpUnlike(shown, {stated, UpOfCameras(cameras)});
  if (!up) return std::nullopt;
  AxesNote note;
  note.text = "people stand along " + DirectionText(*up) +
              " of the world, not along " + DirectionText(shown) + ", which " +
              format.name + " shows as up";
  if (const auto axis = NearestAxis(*up, kNear_deg)) {
    const int of_world = LargestAxis(*axis);
    note.axes = AxisMap::With(file_axis, of_world, (*axis)[of_world]).Text();
  }
  return note;
}

std::string AxesOfReading(const AxisMap& read, const Eigen::Vector3d& up) {
  const int axis = LargestAxis(up);
  const size_t of_file = read.FileAxisOf(axis);
  return AxisMap::With(of_file, 2, read.sign[of_file] * up[axis]).Text();
}

std::optional<AxesNote> FindReadingNote(const Stance& stance,
                                        const TrackFormat& format,
                                        const std::optional<AxisMap>& axes) {
  const auto up = stance.UpUnlike(Vector3d::UnitZ());
  if (!up) return std::nullopt;
  const auto axis = NearestAxis(*up, kNear_deg);
  if (!axis) return std::nullopt;
  return AxesNote{"people stand along " + DirectionText(*up) +
                      " of the world, not along z, as " + format.name +
                      " is read",
                  AxesOfReading(axes.value_or(*format.axes), *axis)};
}

}  // namespace kinegraph
