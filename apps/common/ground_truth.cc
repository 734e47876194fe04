#include "apps/common/ground_truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/evaluation/correspondence.h"
#include "core/evaluation/frame_pairing.h"
#include "core/evaluation/world_check.h"
#include "core/io/tracks/axis_map.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/reading_notes.h"

namespace kinegraph {
namespace {

using Eigen::Matrix3d;

Matrix3d MatrixOf(const AxisMap& map) {
  Matrix3d matrix;
  for (int i = 0; i < 3; ++i)
    matrix.col(i) = map.Apply(Matrix3d::Identity().col(i));
  return matrix;
}

AxisMap MapOf(const Matrix3d& matrix) {
  AxisMap map;
  for (int i = 0; i < 3; ++i) {
    Eigen::Index axis = 0;
    matrix.row(i).cwiseAbs().maxCoeff(&axis);
    map.axis[static_cast<size_t>(i)] = static_cast<int>(axis);
    map.sign[static_cast<size_t>(i)] = matrix(i, axis);
  }
  return map;
}

// The --axes that transform the recording into the other world.
std::string AxesInto(const ReadRecording& recording,
                     const Matrix3d& other_from_recording) {
  const TrackFormat& format = FormatOfTracks(recording.path, recording.options);
  Matrix3d file_from_world = Matrix3d::Identity();
  if (format.axes) {
    file_from_world = MatrixOf(recording.options.axes.value_or(*format.axes));
  }
  return MapOf(file_from_world * other_from_recording.transpose()).Text();
}

bool IsUpright(const TrackSequence& tracks) {
  return !StanceOf(tracks).UpUnlike(Eigen::Vector3d::UnitZ()).has_value();
}

// Advice on wrong axes: the command that corrects the truth, or the tracks if
// only the people of the tracks are not upright along z (for a run's own
// tracks: the key that makes them upright); for a mirror image, that --axes
// cannot correct it.
std::string AxesAdvice(const ReadRecording& truth, const ReadRecording& tracks,
                       const OtherWorld& other) {
  if (other.is_mirrored()) return "a mirror image, which --axes cannot correct";
  const bool of_tracks = IsUpright(*truth.tracks) && !IsUpright(*tracks.tracks);
  if (of_tracks && tracks.path.empty()) {
    return "--set=cameras.ground=feet aligns the world of the tracks with the "
           "floor";
  }
  const std::string axes = of_tracks ? AxesInto(tracks, other.axes.transpose())
                                     : AxesInto(truth, other.axes);
  return fmt::format("`kinegraph convert --in={} --axes={} --out=NAME.jsonl`",
                     Printable(of_tracks ? tracks.path : truth.path, 200),
                     axes);
}

// Advice on a wrong unit. Suggests `convert` for the file whose format has no
// unit, because --unit would apply to both files.
std::string UnitAdvice(const ReadRecording& truth, const ReadRecording& tracks,
                       const OtherWorld& other) {
  for (const auto& [recording, factor] :
       {std::pair{&truth, other.scale}, {&tracks, 1.0 / other.scale}}) {
    if (recording->path.empty()) continue;
    const TrackFormat& format =
        FormatOfTracks(recording->path, recording->options);
    if (!format.unit_m) continue;
    const double used_m = recording->options.unit_m > 0.0
                              ? recording->options.unit_m
                              : *format.unit_m;
    for (const auto& [name, unit_m] : kLengthUnits) {
      if (std::abs(unit_m / (used_m * factor) - 1.0) > 1e-6) continue;
      return fmt::format(
          "`kinegraph convert --in={} --unit={} --to=kinegraph "
          "--out=NAME.jsonl`",
          Printable(recording->path, 200), name);
    }
  }
  return "the unit that one of the two files states is wrong";
}

}  // namespace

std::vector<std::string> CheckGroundTruth(
    const ReadRecording& truth, const ReadRecording& tracks,
    const std::vector<FrameRange>& frames) {
  const FramePairing pairing =
      PairFrames(*truth.tracks, *tracks.tracks, frames);
  if (std::none_of(pairing.pairs.begin(), pairing.pairs.end(),
                   [](const FramePair& pair) {
                     return pair.truth != nullptr &&
                            !pair.truth->people.empty();
                   })) {
    throw InputError(truth.path, "",
                     "no person is annotated in the requested frames");
  }
  const WorldCheck check =
      CheckWorld(pairing, CommonJoints(truth.tracks->header.skeleton,
                                       tracks.tracks->header.skeleton));
  if (check.other) {
    const OtherWorld& other = *check.other;
    std::string advice;
    if (other.scale != 1.0) advice = UnitAdvice(truth, tracks, other);
    if (other.axes != Matrix3d::Identity()) {
      advice += (advice.empty() ? "" : "; ") + AxesAdvice(truth, tracks, other);
    }
    throw InputError(truth.path, "", check.Text() + ": " + advice);
  }
  std::vector<std::string> notes = pairing.notes;
  if (const std::string text = check.Text(); !text.empty()) {
    notes.push_back(text);
  }
  if (const std::string text = check.GateText(); !text.empty()) {
    notes.push_back(text);
  }
  return notes;
}

}  // namespace kinegraph
