#include "apps/markers/marker_study.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/common/app.h"
#include "apps/common/track_files.h"
#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/evaluation/correspondence.h"
#include "core/io/configuration/recording_files.h"
#include "core/io/text/joint_names.h"
#include "core/io/tracks/c3d.h"
#include "core/io/tracks/reading_notes.h"
#include "core/kinematics/ground.h"
#include "core/kinematics/kinematics.h"

namespace kinegraph {
namespace {

struct AlignName {
  Align align;
  const char* name;
};
constexpr AlignName kAlignNames[] = {{Align::kBoth, "both"},
                                     {Align::kClock, "clock"},
                                     {Align::kWorld, "world"},
                                     {Align::kNone, "none"}};

// Adds the file to errors of lower levels, which do not name it.
template <typename Work>
auto Named(const std::string& path, const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    throw InputError(path, "", error.what());
  }
}

std::string SomeLabels(const Skeleton& skeleton) {
  constexpr size_t kMost = 6;
  std::string text;
  for (size_t i = 0; i < skeleton.joints().size() && i < kMost; ++i) {
    text += (i > 0 ? ", " : "") + Printable(skeleton.joints()[i], 24);
  }
  return text + (skeleton.joints().size() > kMost ? ", ..." : "");
}

void RequireCommon(const MarkerInput& truth, const MarkerInput& tracks) {
  const Skeleton& a = truth.joints.tracks.header.skeleton;
  const Skeleton& b = tracks.joints.tracks.header.skeleton;
  if (!CommonJoints(a, b).empty()) return;
  throw InputError(truth.path, "",
                   "no joint in common: found " + SomeLabels(a) + " here; " +
                       Printable(tracks.path) + " has " + SomeLabels(b) +
                       "; --joints=F.toml defines joints by markers");
}

// Values of an angle in the rows of both tables, which have the same frames.
std::vector<PairedValue> PairedAngles(const KinematicsTable& truth,
                                      const KinematicsTable& found,
                                      const std::string& angle) {
  const auto value = [](const KinematicsTable& table, size_t row, int column) {
    return column < 0 ? kNan
                      : table.rows[row].values[static_cast<size_t>(column)];
  };
  const int of_truth = truth.IndexOf(angle + "_deg");
  const int of_found = found.IndexOf(angle + "_deg");
  const int low = found.IndexOf(angle + "_low_deg");
  const int high = found.IndexOf(angle + "_high_deg");
  std::vector<PairedValue> values;
  for (size_t row = 0; row < truth.rows.size(); ++row) {
    values.push_back({value(truth, row, of_truth), value(found, row, of_found),
                      value(found, row, low), value(found, row, high)});
  }
  return values;
}

void AddAngles(MarkerStudy* study) {
  constexpr double kTurnDeg = 360.0;
  KinematicsOptions options;
  options.up = study->up;
  const KinematicsTable truth = MeasureKinematics(study->motion.truth, options);
  const KinematicsTable found =
      MeasureKinematics(study->motion.tracks, options);
  for (const std::string& angle : truth.angles) {
    const ValueAgreement agreement =
        CompareValues(PairedAngles(truth, found, angle), kTurnDeg);
    if (agreement.count > 0) study->angles[angle] = agreement;
  }
}

void AddEvents(const MarkerRequest& request, MarkerStudy* study) {
  study->true_events = FindFootEvents(study->motion.truth, study->up);
  study->found_events = FindFootEvents(study->motion.tracks, study->up);
  const double stride_s = StrideTime(study->true_events);
  study->blocks_are_strides = std::isfinite(stride_s);
  if (study->blocks_are_strides) study->block_s = stride_s;
  if (!request.plates) return;
  const auto plates = ReadForcePlates(request.ground_truth);
  study->true_on_plates = CompareWithPlates(plates, study->true_events,
                                            study->motion.truth, study->up);
  study->found_on_plates = CompareWithPlates(plates, study->found_events,
                                             study->motion.truth, study->up);
}

// Frame rate [Hz], computed from the times if the file does not specify it.
double RateOf(const MarkerInput& input) {
  const TrackSequence& tracks = input.joints.tracks;
  double length_s = 0.0;
  if (!tracks.frames.empty()) {
    length_s =
        ToSeconds(tracks.frames.back().time - tracks.frames.front().time);
  }
  if (!(length_s > 0.0)) {
    throw InputError(input.path, "",
                     "has no times: a single frame, or no frame rate");
  }
  if (tracks.header.frame_rate_hz > 0.0) return tracks.header.frame_rate_hz;
  return static_cast<double>(tracks.frames.size() - 1) / length_s;
}

// Determines the joints of a file: by `rules`, else by the marker set to which
// its labels belong, else by the names of joints.
MarkerInput ReadMarkerInput(const std::string& path, const std::string& rules,
                            TrackSequence points) {
  MarkerInput input;
  input.path = path;
  input.points = std::move(points);
  const Skeleton& skeleton = input.points.header.skeleton;
  const MarkerSet* set = RecogniseMarkerSet(skeleton.joints());
  if (!rules.empty()) {
    input.set = rules;
    input.joints = Named(rules, [&] {
      return JointsOfMarkers(input.points, ReadJointRules(rules));
    });
  } else if (set != nullptr) {
    input.set = set->name;
    input.joints =
        Named(path, [&] { return JointsOfMarkers(input.points, *set); });
  } else {
    input.joints.tracks = input.points;
    input.joints.tracks.header.skeleton = WithOurNames(skeleton);
    input.joints.is_centre.assign(skeleton.joints().size(), true);
  }
  input.joints.tracks.header.frame_rate_hz = RateOf(input);
  return input;
}

}  // namespace

Align ParseAlign(const std::string& text) {
  for (const AlignName& one : kAlignNames) {
    if (text == one.name) return one.align;
  }
  FailFlag("align", text, "both, clock, world or none");
}

const char* ToString(Align align) {
  for (const AlignName& one : kAlignNames) {
    if (align == one.align) return one.name;
  }
  return "";
}

MarkerStudy RunMarkerStudy(const MarkerRequest& request) {
  const TrackInput input("evaluate", request.unit,
                         {request.ground_truth, request.tracks});
  MarkerStudy study;
  study.align = request.align.align;
  study.truth = ReadMarkerInput(request.ground_truth, request.joints,
                                input.Read(request.ground_truth));
  study.tracks =
      ReadMarkerInput(request.tracks, "", input.Read(request.tracks));
  RequireCommon(study.truth, study.tracks);
  TrackSequence& truth = study.truth.joints.tracks;
  TrackSequence& tracks = study.tracks.joints.tracks;
  Named(request.ground_truth, [&] { return OnlyPerson(truth); });
  tracks.frames.erase(std::remove_if(tracks.frames.begin(), tracks.frames.end(),
                                     [&](const TrackFrame& frame) {
                                       return !ContainsFrame(request.frames,
                                                             frame.frame);
                                     }),
                      tracks.frames.end());
  study.alignment = Named(request.tracks, [&] {
    return AlignRecordings(truth, study.truth.joints.is_centre, tracks,
                           request.align);
  });
  const Alignment& alignment = study.alignment;
  study.motion = PairMotion(truth, TruthPaths(truth, alignment.joints), tracks,
                            alignment.person, request.align.person.has_value(),
                            alignment.joints, alignment.clock, alignment.world);
  for (const JointPair& pair : alignment.joints) {
    study.motion.is_centre.push_back(
        study.truth.joints.is_centre[static_cast<size_t>(pair.a)] &&
        study.tracks.joints.is_centre[static_cast<size_t>(pair.b)]);
  }
  if (study.motion.truth.frames.empty()) {
    throw InputError(
        request.tracks, "",
        "has no frame at a time at which the ground truth has markers");
  }
  study.up = UpDirection(truth, {StatedUp(request.ground_truth)})
                 .value_or(Eigen::Vector3d::UnitZ());
  AddEvents(request, &study);
  study.agreement = CompareMotion(study.motion, study.up, study.block_s);
  AddAngles(&study);
  return study;
}

TrackSequence MarkersAsTruth(const std::string& path, const std::string& rules,
                             const TrackSequence& tracks) {
  MarkerInput input = ReadMarkerInput(path, rules, ReadTracks(path));
  const TrackSequence& truth = input.joints.tracks;
  const Alignment alignment = Named(path, [&] {
    return AlignRecordings(truth, input.joints.is_centre, tracks, {});
  });
  const JointPaths paths = TruthPaths(truth, alignment.joints);
  const Eigen::Isometry3d tracks_from_truth =
      alignment.world.truth_from_tracks.inverse();
  PairedMotion motion =
      PairMotion(truth, paths, tracks, alignment.person, false,
                 alignment.joints, alignment.clock, alignment.world);
  // PairMotion returns the frame numbers of the tracks with the times of the
  // markers.
  std::map<int64_t, TimeNs> times;
  for (const TrackFrame& frame : tracks.frames) {
    times[frame.frame] = frame.time;
  }
  motion.truth.header.frame_rate_hz = tracks.header.frame_rate_hz;
  for (TrackFrame& frame : motion.truth.frames) {
    frame.time = times.at(frame.frame);
    for (Joint3d& joint : frame.people.front().joints) {
      joint.position_m = tracks_from_truth * joint.position_m;
    }
  }
  return std::move(motion.truth);
}

}  // namespace kinegraph
