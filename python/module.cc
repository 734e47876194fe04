// The Python module `_kinegraph`: converts between arrays and the library's
// types, and computes nothing. Users import the package kinegraph
// (python/kinegraph/__init__.py), which imports it.
#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/constants.h"
#include "core/base/stop_check.h"
#include "core/base/text.h"
#include "core/data/checks.h"
#include "core/evaluation/centres.h"
#include "core/evaluation/correspondence.h"
#include "core/evaluation/frame_pairing.h"
#include "core/evaluation/world_check.h"
#include "core/geometry/lens.h"
#include "core/io/adapters/adapter.h"
#include "core/io/calibration/format.h"
#include "core/io/configuration/config.h"
#include "core/io/conversion.h"
#include "core/io/detections/format.h"
#include "core/io/file_kind.h"
#include "core/io/text/joint_names.h"
#include "core/io/tracks/format.h"
#include "core/kinematics/ground.h"
#include "kinegraph/kinegraph.h"
#include "python/pickling.h"
#include "solvers/session/ready_recording.h"

namespace py = pybind11;
using namespace pybind11::literals;  // NOLINT: "name"_a of the bindings

namespace kinegraph {
namespace {

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

// (N,) array of `get` for each of N items.
template <typename Number, typename Items, typename Get>
py::array_t<Number> ArrayOver(const Items& items, const Get& get) {
  py::array_t<Number> numbers(static_cast<py::ssize_t>(items.size()));
  Number* out = numbers.mutable_data();
  for (const auto& item : items) *out++ = get(item);
  return numbers;
}

// Support for pickle, and thus for copy.copy and copy.deepcopy.
template <typename T>
auto Pickled() {
  return py::pickle([](const T& value) { return py::bytes(BytesOf(value)); },
                    [](const py::bytes& state) { return OfBytes<T>(state); });
}

[[noreturn]] void FailUnknown(const std::string& key, const std::string& found,
                              const std::vector<std::string>& known) {
  std::string names;
  for (const std::string& name : known) names += " " + name;
  throw InputError(key + ": found '" + Printable(found) + "', expected one of" +
                   names);
}

// ---- Skeletons and cameras --------------------------------------------------

Skeleton NamedSkeleton(const std::string& name) {
  return ResolveSkeleton(name, {});
}

Camera MakeCamera(const std::string& name, const Eigen::Matrix3d& K,
                  const Eigen::Matrix3d& R, const Eigen::Vector3d& t,
                  const std::vector<double>& distortion,
                  const std::string& model,
                  const std::pair<int, int>& image_size) {
  CameraParameters parameters;
  parameters.name = name;
  parameters.K = K;
  parameters.R = R;
  parameters.t = t;
  parameters.width_px = image_size.first;
  parameters.height_px = image_size.second;
  parameters.lens = MakeLens(model, distortion);
  return Camera(parameters);
}

std::string ModelOf(const Camera& camera) {
  return camera.lens() ? camera.lens()->model() : "pinhole";
}

std::vector<double> DistortionOf(const Camera& camera) {
  return camera.lens() ? camera.lens()->parameters() : std::vector<double>();
}

std::pair<int, int> ImageSizeOf(const Camera& camera) {
  return {camera.width_px(), camera.height_px()};
}

// (N, 3) points in the world [m] to (N, 2) raw pixels, NaN where a
// point cannot be projected.
Array ProjectPoints(const Camera& camera, const Array& points) {
  if (points.ndim() != 2 || points.shape(1) != 3) {
    throw InputError("points: expected an array of shape (N, 3) [m]");
  }
  const auto in = points.unchecked<2>();
  Array pixels({in.shape(0), py::ssize_t{2}});
  auto out = pixels.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < in.shape(0); ++i) {
    const std::optional<Eigen::Vector2d> px =
        camera.Project({in(i, 0), in(i, 1), in(i, 2)});
    for (int axis = 0; axis < 2; ++axis) {
      out(i, axis) = px.has_value() ? (*px)[axis] : kNan;
    }
  }
  return pixels;
}

// ---- Detections -------------------------------------------------------------

// (people, joints, 3) of x [px], y [px], confidence. A joint is not found if
// any of these is not finite, or at exactly (0, 0), which YOLO writes for
// joints it does not see.
std::vector<Detection> DetectionsOf(const Array& people, int joint_count) {
  if (people.size() == 0) return {};
  if (people.ndim() != 3 || people.shape(1) != joint_count ||
      people.shape(2) != 3) {
    throw InputError(
        "detections of a view: expected an array of shape (people, " +
        std::to_string(joint_count) + ", 3)");
  }
  const auto in = people.unchecked<3>();
  std::vector<Detection> detections(static_cast<size_t>(in.shape(0)));
  for (py::ssize_t p = 0; p < in.shape(0); ++p) {
    Detection& detection = detections[static_cast<size_t>(p)];
    detection.index_in_file = static_cast<int>(p);
    detection.joints.resize(static_cast<size_t>(joint_count));
    for (py::ssize_t j = 0; j < joint_count; ++j) {
      Keypoint& joint = detection.joints[static_cast<size_t>(j)];
      joint.px = {in(p, j, 0), in(p, j, 1)};
      joint.confidence = in(p, j, 2);
      joint.found = joint.px.allFinite() && !joint.px.isZero(0.0) &&
                    std::isfinite(joint.confidence);
    }
  }
  return detections;
}

Array ArrayOf(const std::vector<Detection>& detections, int joint_count) {
  Array people({static_cast<py::ssize_t>(detections.size()),
                static_cast<py::ssize_t>(joint_count), py::ssize_t{3}});
  auto out = people.mutable_unchecked<3>();
  for (size_t p = 0; p < detections.size(); ++p) {
    for (int j = 0; j < joint_count; ++j) {
      const Keypoint& joint = detections[p].joints[static_cast<size_t>(j)];
      const auto at = static_cast<py::ssize_t>(p);
      out(at, j, 0) = joint.found ? joint.px.x() : kNan;
      out(at, j, 1) = joint.found ? joint.px.y() : kNan;
      out(at, j, 2) = joint.found ? joint.confidence : kNan;
    }
  }
  return people;
}

// One frame from an array per view. `time_s`: default frame / rate.
DetectionFrame FrameOf(int64_t number, const std::vector<Array>& views,
                       std::optional<double> time_s,
                       const DetectionHeader& header) {
  if (views.size() != header.view_names.size()) {
    throw InputError("frame " + std::to_string(number) + ": found " +
                     std::to_string(views.size()) + " views, expected " +
                     std::to_string(header.view_names.size()));
  }
  if (!time_s.has_value() && !(header.frame_rate_hz > 0.0)) {
    throw InputError("frame " + std::to_string(number) +
                     ": expected a time, or detections with a frame rate");
  }
  DetectionFrame frame;
  frame.frame = number;
  frame.time = CheckedTime(
      time_s.value_or(static_cast<double>(number) / header.frame_rate_hz),
      "frame " + std::to_string(number) + ": time");
  for (const Array& view : views) {
    ViewDetections& one = frame.views.emplace_back();
    one.capture_time = frame.time;
    one.detections = DetectionsOf(view, header.skeleton.joint_count());
  }
  CheckDetectionFrame(header, frame);
  return frame;
}

DetectionHeader HeaderOf(const std::string& skeleton,
                         const std::vector<std::string>& views,
                         double frame_rate_hz) {
  DetectionHeader header;
  header.skeleton = NamedSkeleton(skeleton);
  header.view_names = views;
  header.frame_rate_hz = frame_rate_hz;
  CheckDetectionHeader(header);
  return header;
}

DetectionSequence SequenceOf(const std::vector<std::vector<Array>>& frames,
                             const std::string& skeleton,
                             const std::vector<std::string>& views,
                             double frame_rate_hz, int64_t first_frame) {
  DetectionSequence sequence;
  sequence.header = HeaderOf(skeleton, views, frame_rate_hz);
  for (size_t k = 0; k < frames.size(); ++k) {
    sequence.frames.push_back(FrameOf(first_frame + static_cast<int64_t>(k),
                                      frames[k], std::nullopt,
                                      sequence.header));
  }
  return sequence;
}

// ---- Tracks -----------------------------------------------------------------

// The index of each person along the axis P (people) of arrays, in the order of
// ascending ids.
std::map<int64_t, py::ssize_t> ColumnsOf(const TrackSequence& tracks) {
  std::map<int64_t, py::ssize_t> columns;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      columns.emplace(person.id.value(), 0);
    }
  }
  py::ssize_t next = 0;
  for (auto& [id, column] : columns) column = next++;
  return columns;
}

py::array_t<int64_t> IdsOf(const TrackSequence& tracks) {
  return ArrayOver<int64_t>(ColumnsOf(tracks),
                            [](const auto& column) { return column.first; });
}

// Array of the shape (F frames, P people, J joints, tail...): `put(person, j,
// out)` writes the joints of people who are present; `fill` elsewhere.
template <typename Number, typename Put>
py::array_t<Number> JointArray(const TrackSequence& tracks,
                               const std::vector<py::ssize_t>& tail,
                               Number fill, const Put& put) {
  const auto columns = ColumnsOf(tracks);
  const auto people = static_cast<py::ssize_t>(columns.size());
  const py::ssize_t joints = tracks.header.skeleton.joint_count();
  std::vector<py::ssize_t> shape = {
      static_cast<py::ssize_t>(tracks.frames.size()), people, joints};
  py::ssize_t size = 1;
  for (const py::ssize_t side : tail) {
    shape.push_back(side);
    size *= side;
  }
  py::array_t<Number> array(shape);
  Number* const out = array.mutable_data();
  std::fill_n(out, array.size(), fill);
  py::ssize_t row = 0;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      const py::ssize_t place = row * people + columns.at(person.id.value());
      for (py::ssize_t j = 0; j < joints; ++j) {
        put(person, static_cast<size_t>(j), out + (place * joints + j) * size);
      }
    }
    ++row;
  }
  return array;
}

Array PositionsOf(const TrackSequence& tracks) {
  return JointArray<double>(
      tracks, {3}, kNan, [](const PersonPose& person, size_t j, double* out) {
        if (!person.joints[j].present()) return;
        for (int i = 0; i < 3; ++i) out[i] = person.joints[j].position_m[i];
      });
}

py::array_t<uint8_t> StatusesOf(const TrackSequence& tracks) {
  return JointArray<uint8_t>(
      tracks, {}, 0, [](const PersonPose& person, size_t j, uint8_t* out) {
        *out = static_cast<uint8_t>(person.joints[j].status);
      });
}

Array CovariancesOf(const TrackSequence& tracks) {
  return JointArray<double>(
      tracks, {3, 3}, kNan,
      [](const PersonPose& person, size_t j, double* out) {
        if (j >= person.covariances.size()) return;
        const auto& covariance = person.covariances[j];
        if (!covariance.has_value()) return;
        // The upper triangle, mirrored, as in files.
        for (int a = 0; a < 3; ++a) {
          for (int b = 0; b < 3; ++b) {
            *out++ = (*covariance)(std::min(a, b), std::max(a, b));
          }
        }
      });
}

// ---- Runs -------------------------------------------------------------------

RunOptions OptionsOf(const std::string& config, const std::string& set,
                     const std::string& mode) {
  return config.empty() ? ParseRunOptions("", set, mode)
                        : ReadRunOptions(config, set, mode);
}

RunRequest RequestOf(const std::vector<Camera>& cameras,
                     const std::vector<std::pair<int64_t, int64_t>>& frames,
                     const std::vector<std::string>& without_cameras,
                     int threads) {
  RunRequest request;
  request.cameras = cameras;
  request.without_cameras = without_cameras;
  request.threads = threads;
  for (const auto& [begin, end] : frames) {
    if (begin >= end) {
      throw InputError("frames: found (" + std::to_string(begin) + ", " +
                       std::to_string(end) + "), expected begin < end");
    }
    if (!request.frames.empty() && begin < request.frames.back().end) {
      throw InputError("frames: found (" + std::to_string(begin) + ", " +
                       std::to_string(end) +
                       "), expected it to begin after the previous range");
    }
    request.frames.push_back({begin, end});
  }
  return request;
}

// Checks for Ctrl-C while the library works, in the thread that called it:
// Python runs signal handlers on its main thread only. If a handler raises an
// exception there, the library's other threads stop, too.
class SignalCheck {
 public:
  void operator()() {
    if (stopped_) throw Stopped();
    if (std::this_thread::get_id() != owner_) return;
    const auto now = std::chrono::steady_clock::now();
    if (now < next_) return;
    next_ = now + kPause;
    const py::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() == 0) return;
    error_ = std::make_exception_ptr(py::error_already_set());
    stopped_ = true;
    throw Stopped();
  }
  // The exception of a handler, usually KeyboardInterrupt.
  const std::exception_ptr& error() const { return error_; }

 private:
  // Limits how often Python's lock is taken, which is costly.
  static constexpr std::chrono::milliseconds kPause{50};
  const std::thread::id owner_ = std::this_thread::get_id();
  std::chrono::steady_clock::time_point next_;
  std::exception_ptr error_;
  std::atomic<bool> stopped_{false};
};

// Runs `work` without Python's lock; Ctrl-C interrupts it.
template <typename Work>
auto Interruptible(const Work& work) {
  SignalCheck signals;
  const StopCheck check = [&signals] { signals(); };
  const py::gil_scoped_release unlocked;
  const StopScope scope(&check);
  try {
    return work();
  } catch (const Stopped&) {
    std::rethrow_exception(signals.error());
  }
}

TrackSequence Track(const std::vector<Camera>& cameras,
                    const DetectionSequence& given, const std::string& config,
                    const std::string& set, const std::string& mode,
                    const std::vector<std::pair<int64_t, int64_t>>& frames,
                    const std::vector<std::string>& without_cameras,
                    int threads, const py::object& progress) {
  const RunOptions options = OptionsOf(config, set, mode);
  const RunRequest request =
      RequestOf(cameras, frames, without_cameras, threads);
  const auto total =
      static_cast<int64_t>(given.frames.size()) * PassCount(options);
  // Reports progress, but not for every frame: waiting for the interpreter's
  // lock can take longer than processing a frame.
  const auto tell = [&progress, total](int64_t frames_read) {
    constexpr int64_t kStride = 16;  // frames
    CheckStop();
    if (progress.is_none()) return;
    if (frames_read % kStride != 0 && frames_read != total) return;
    const py::gil_scoped_acquire lock;
    progress(frames_read, total);
  };
  return Interruptible(
      [&] { return TrackSequenceOf(options, request, given, nullptr, tell); });
}

// The fixed matches of a run, to be smoothed by several strategies.
class Frozen {
 public:
  Frozen(const std::vector<Camera>& cameras,
         const DetectionSequence& detections, const std::string& config,
         const std::string& set)
      : options_(OptionsOf(config, set, "")) {
    const RunRequest request = RequestOf(cameras, {}, {}, 1);
    Interruptible([&] {
      run_ = FreezeTracking(options_, request, detections);
      replay_ = std::make_unique<Replay>(
          run_.scene.model, run_.detections, run_.matches,
          run_.scale.IntoRun(options_).tracker, FeedbackOf(options_));
      people_ = replay_->Prepare(-1, 1);
    });
  }

  const TrackSequence& tracks() const { return run_.tracks; }

  TrackSequence Smooth(const std::string& strategy) const {
    const std::vector<std::string>& names = OutputNames();
    size_t kind = 0;
    while (kind < names.size() && names[kind] != strategy) ++kind;
    if (kind == names.size()) FailUnknown("strategy", strategy, names);
    const EstimatorFactory estimator =
        MakeOutput(static_cast<OutputKind>(kind), options_.estimators);
    std::vector<ReplayOutcome> outcomes;
    const auto work = [&] {
      for (const ReplayedPerson& person : people_) {
        CheckStop();
        outcomes.push_back(RunEstimator(run_.scene.model, person, estimator));
      }
    };
    Interruptible(work);
    const py::gil_scoped_release unlocked;
    TrackSequence tracks;
    tracks.header = run_.tracks.header;
    tracks.frames = AssembleReplay(replay_->empty_frames(), people_,
                                   std::move(outcomes), run_.first_frame);
    for (TrackFrame& frame : tracks.frames) {
      frame = run_.scale.IntoWorld(std::move(frame));
    }
    return tracks;
  }

 private:
  RunOptions options_;
  FrozenRun run_;
  std::unique_ptr<Replay> replay_;
  std::vector<ReplayedPerson> people_;
};

// Options for a session, which does not have the whole recording.
RunOptions LiveOptionsOf(const std::string& config, const std::string& set,
                         const std::string& mode) {
  const RunOptions options = OptionsOf(config, set, mode);
  if (ChangesCameras(options)) {
    throw OptionError(
        "cameras.refine",
        "needs the whole recording, which a Session does not have; this also "
        "applies to cameras.refine_clock and cameras.ground");
  }
  return options;
}

// A Session that takes arrays and returns the frames that became final. Calls
// from several threads are serialised.
class LiveSession {
 public:
  LiveSession(const std::vector<Camera>& cameras, const std::string& skeleton,
              const std::vector<std::string>& views, double frame_rate_hz,
              const std::string& config, const std::string& set,
              const std::string& mode)
      : header_(HeaderOf(skeleton, views, frame_rate_hz)),
        session_(LiveOptionsOf(config, set, mode),
                 RequestOf(cameras, {}, {}, 1), header_) {}

  TrackSequence Process(int64_t number, const std::vector<Array>& views,
                        std::optional<double> time_s) {
    DetectionFrame frame = FrameOf(number, views, time_s, header_);
    return Alone([&] { return session_.Process(std::move(frame)); });
  }
  TrackSequence Finish() {
    return Alone([&] { return session_.Finish(); });
  }

 private:
  template <typename Work>
  TrackSequence Alone(const Work& work) {
    const std::thread::id self = std::this_thread::get_id();
    if (owner_ == self) {  // called by a signal handler: would deadlock
      throw std::runtime_error(
          "this Session is already in use by a caller in the same thread");
    }
    std::vector<TrackFrame> frames = Interruptible([&] {
      const std::lock_guard<std::mutex> lock(mutex_);
      owner_ = self;
      const Released released{&owner_};
      return work();
    });
    return {session_.scene().header, std::move(frames)};
  }
  struct Released {
    std::atomic<std::thread::id>* owner;
    ~Released() { *owner = std::thread::id(); }
  };

  DetectionHeader header_;
  Session session_;
  std::mutex mutex_;
  std::atomic<std::thread::id> owner_{std::thread::id()};
};

// ---- Scores -----------------------------------------------------------------

// The tracks with kinegraph's joint names: `given`, or a copy in `own`.
const TrackSequence& UnderOurNames(const TrackSequence& given,
                                   TrackSequence* own) {
  const Skeleton ours = WithOurNames(given.header.skeleton);
  if (ours == given.header.skeleton) return given;
  *own = given;
  own->header.skeleton = ours;
  return *own;
}

// Tracks and truth as `evaluate` compares them: with kinegraph's joint names
// or, by kJointsOrCentres, reduced to centres (ReducedToCentres) where that
// applies. Pairs their frames and checks that they are in the same world; notes
// become Python warnings.
class Scored {
 public:
  enum class By { kJoints, kJointsOrCentres };
  Scored(const TrackSequence& tracks, const TrackSequence& truth, By by)
      : tracks_(&UnderOurNames(tracks, &own_tracks_)),
        truth_(&UnderOurNames(truth, &own_truth_)) {
    if (by == By::kJointsOrCentres) {
      if (auto centres = ReducedToCentres(*truth_, *tracks_)) {
        own_truth_ = std::move(centres->a);
        own_tracks_ = std::move(centres->b);
        truth_ = &own_truth_;
        tracks_ = &own_tracks_;
        Warn(centres->note);
      }
    }
    const Skeleton& found = tracks_->header.skeleton;
    const Skeleton& expected = truth_->header.skeleton;
    RequireCommonJoints(expected, "the truth", found, "the tracks");
    const FramePairing pairing = PairFrames(*truth_, *tracks_);
    const WorldCheck world = CheckWorld(pairing, CommonJoints(expected, found));
    if (world.other) {
      throw InputError("truth: " + world.Text() +
                       " (convert() has `axes` and `unit`)");
    }
    for (const std::string& note : pairing.notes) Warn(note);
    Warn(world.Text());
  }
  Scored(const Scored&) = delete;
  Scored& operator=(const Scored&) = delete;

  const TrackSequence& tracks() const { return *tracks_; }
  const TrackSequence& truth() const { return *truth_; }

 private:
  static void Warn(const std::string& note) {
    constexpr int kCallerOfEvaluate = 2;
    if (note.empty()) return;
    if (PyErr_WarnEx(PyExc_UserWarning, note.c_str(), kCallerOfEvaluate) != 0) {
      throw py::error_already_set();
    }
  }

  TrackSequence own_tracks_, own_truth_;
  const TrackSequence* tracks_;
  const TrackSequence* truth_;
};

py::dict Mpjpe(const TrackSequence& tracks, const TrackSequence& truth) {
  const Scored scored(tracks, truth, Scored::By::kJoints);
  const MpjpeResult result = EvaluateMpjpe(scored.truth(), scored.tracks());
  py::dict joints;
  for (const JointError& joint : result.joints) {
    joints[py::str(joint.joint)] = joint.raw_m;
  }
  return py::dict("mpjpe_m"_a = result.raw_m,
                  "bias_removed_m"_a = result.bias_removed_m,
                  "found"_a = result.found.fraction(), "joints_m"_a = joints);
}

py::dict Identity(const TrackSequence& tracks, const TrackSequence& truth) {
  const Scored scored(tracks, truth, Scored::By::kJointsOrCentres);
  const IdentityResult result =
      EvaluateIdentity(scored.truth(), scored.tracks());
  return py::dict(
      "mota"_a = result.Mota(), "idf1"_a = result.Idf1(),
      "switches"_a = result.switches, "fragments"_a = result.fragments,
      "misses"_a = result.misses, "false_positives"_a = result.false_positives,
      "true_people"_a = result.true_people, "identities"_a = result.identities);
}

// ---- Kinematics -------------------------------------------------------------

KinematicsTable Kinematics(const TrackSequence& tracks, const std::string& up,
                           bool observed_only) {
  KinematicsOptions options;
  options.up = ParseUp(up, "up");
  options.observed_only = observed_only;
  const py::gil_scoped_release unlocked;
  TrackSequence renamed;
  return MeasureKinematics(UnderOurNames(tracks, &renamed), options);
}

Array ColumnOf(const KinematicsTable& table, const std::string& column) {
  const int at = table.IndexOf(column);
  if (at < 0) throw py::key_error("no column '" + column + "'");
  return ArrayOver<double>(table.rows, [at](const KinematicsRow& row) {
    return row.values[static_cast<size_t>(at)];
  });
}

// ---- Files ------------------------------------------------------------------

// str, bytes or os.PathLike, including names that are not UTF-8.
using Path = std::filesystem::path;

// Returns `found`, the format named `name`, if it can be written; otherwise
// throws InputError with the formats that can.
template <typename Format>
const Format& WrittenFormat(const Format* found, const std::string& name,
                            const std::vector<Format>& formats) {
  if (found != nullptr && found->write != nullptr) return *found;
  std::vector<std::string> known;
  for (const Format& one : formats) {
    if (one.write != nullptr) known.push_back(one.name);
  }
  FailUnknown("format", name, known);
}

template <typename Options>
Options ReadOptionsOf(const std::string& skeleton, double frame_rate_hz) {
  Options options;
  if (!skeleton.empty()) options.skeleton = NamedSkeleton(skeleton);
  options.frame_rate_hz = frame_rate_hz;
  return options;
}

LostFields WriteCamerasAs(const Path& path, const std::vector<Camera>& cameras,
                          const std::string& format) {
  const py::gil_scoped_release unlocked;
  LostFields lost_fields;
  WriteCalibration(path.string(), format, cameras, &lost_fields);
  return lost_fields;
}

bool HasMatches(const TrackSequence& tracks) {
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      if (!person.matches.empty()) return true;
    }
  }
  return false;
}

// `names_of`: the file with the names of people, usually the source of the
// tracks; empty: none.
LostFields WriteTracksAs(const Path& file, const TrackSequence& tracks,
                         const std::string& format, const Path& names_of) {
  const std::string path = file.string();
  const TrackFormat* named =
      format.empty() ? TrackFormatOfExtension(path) : FindTrackFormat(format);
  if (format.empty() && named == nullptr) named = FindTrackFormat("kinegraph");
  const TrackFormat& found = WrittenFormat(named, format, TrackFormats());
  const py::gil_scoped_release unlocked;
  TrackExportOptions options;
  if (!names_of.empty()) options.names = ReadPersonNames(names_of.string());
  LostFields lost_fields;
  if (!options.names.empty() && !found.keeps_names) {
    lost_fields.push_back("names of people are not kept");
  }
  if (found.name == "kinegraph") {
    // Matches and weights are written if the tracks have any.
    WriteTracks(path, tracks, {HasMatches(tracks), options.names});
  } else {
    found.write(path, tracks, options, &lost_fields);
  }
  return lost_fields;
}

LostFields WriteDetectionsAs(const Path& path,
                             const DetectionSequence& detections,
                             const std::string& format,
                             const std::pair<int, int>& image_size) {
  const DetectionFormat& found =
      WrittenFormat(FindDetectionFormat(format), format, DetectionFormats());
  const py::gil_scoped_release unlocked;
  DetectionWriteOptions options;
  options.image_size = {image_size.first, image_size.second};
  MemorySource source(detections);
  LostFields lost_fields;
  found.write(path.string(), options, &source, &lost_fields);
  return lost_fields;
}

LostFields ConvertFiles(const Path& source, const Path& target,
                        const std::string& to, const std::string& from,
                        const std::string& skeleton, double frame_rate_hz,
                        const std::string& image_size, const std::string& unit,
                        const std::string& axes, const std::string& markers,
                        const std::string& person, const std::string& set) {
  ConversionOptions options;
  options.in = source.string();
  options.out = target.string();
  options.from = from;
  options.to = to;
  options.skeleton = skeleton;
  options.frame_rate_hz = frame_rate_hz;
  options.unit = unit;
  options.image_size = image_size;
  options.axes = axes;
  options.markers = markers;
  options.person = person;
  options.set = set;
  return Interruptible([&] { return Convert(options).lost_fields; });
}

void BindSkeleton(py::module_& m) {
  py::class_<Skeleton>(m, "Skeleton", "Joints and bones of a body model.")
      .def(py::init(&NamedSkeleton), "name"_a,
           "The built-in skeleton of this name (see skeleton_names()).")
      .def(Pickled<Skeleton>())
      .def_property_readonly("name", &Skeleton::name, "Its name, as in files.")
      .def_property_readonly("joints", &Skeleton::joints,
                             "Names of the J joints, in the order of arrays.")
      .def_property_readonly(
          "bones",
          [](const Skeleton& skeleton) {
            std::vector<std::pair<int, int>> bones;
            for (const Bone& bone : skeleton.bones()) {
              bones.emplace_back(bone.a, bone.b);
            }
            return bones;
          },
          "Pairs of joint indices.")
      .def("__repr__", [](const Skeleton& skeleton) {
        return "<kinegraph.Skeleton '" + skeleton.name() + "', " +
               std::to_string(skeleton.joint_count()) + " joints>";
      });
  m.def("skeleton_names", &SkeletonNames, "Names of the built-in skeletons.");
}

void BindCamera(py::module_& m) {
  py::class_<Camera>(m, "Camera", "A calibrated camera; lengths in metres.")
      .def(py::init(&MakeCamera), "name"_a, "K"_a, "R"_a, "t"_a,
           "distortion"_a = std::vector<double>(), "model"_a = "opencv5",
           "image_size"_a = std::pair<int, int>(0, 0),
           "K (3, 3) [px]; R (3, 3), t (3,) [m]: x_camera = R x_world + t;\n"
           "model: opencv5 (k1 k2 p1 p2 k3), opencv_fisheye (k1 k2 k3 k4) or\n"
           "pinhole;\n"
           "distortion: coefficients of the lens model, empty for none;\n"
           "image_size: (width, height) [px], (0, 0) if unknown.")
      .def(py::pickle(
          [](const Camera& camera) {
            return py::make_tuple(camera.name(), camera.K(), camera.R(),
                                  camera.t(), DistortionOf(camera),
                                  ModelOf(camera), ImageSizeOf(camera));
          },
          [](const py::tuple& state) {
            return MakeCamera(state[0].cast<std::string>(),
                              state[1].cast<Eigen::Matrix3d>(),
                              state[2].cast<Eigen::Matrix3d>(),
                              state[3].cast<Eigen::Vector3d>(),
                              state[4].cast<std::vector<double>>(),
                              state[5].cast<std::string>(),
                              state[6].cast<std::pair<int, int>>());
          }))
      .def_property_readonly("name", &Camera::name, "Its name, as in views.")
      .def_property_readonly("K", &Camera::K, "(3, 3) [px].")
      .def_property_readonly("R", &Camera::R, "(3, 3), world to camera.")
      .def_property_readonly("t", &Camera::t, "(3,) [m], world to camera.")
      .def_property_readonly("model", &ModelOf, "Lens model.")
      .def_property_readonly("distortion", &DistortionOf,
                             "Coefficients of the lens model; empty for none.")
      .def_property_readonly("centre", &Camera::centre,
                             "(3,) in the world [m].")
      .def_property_readonly("image_size", &ImageSizeOf,
                             "(width, height) [px]; (0, 0) if unknown.")
      .def("project", &ProjectPoints, "points"_a,
           "(N, 3) points in the world [m] to (N, 2) raw pixels; NaN where a\n"
           "point cannot be projected (behind the camera, for example).")
      .def("__repr__", [](const Camera& camera) {
        return "<kinegraph.Camera '" + camera.name() + "'>";
      });
}

void BindDetections(py::module_& m) {
  py::class_<DetectionSequence>(m, "Detections", "2D poses of a recording.")
      .def(py::init(&SequenceOf), "frames"_a, "skeleton"_a, "views"_a,
           "frame_rate_hz"_a, "first_frame"_a = 0,
           "frames[k][v]: array (people, joints, 3) of x [px], y [px] and\n"
           "confidence; not finite or exactly (0, 0): not found. views: for "
           "each view\n"
           "the name of its camera.")
      .def(Pickled<DetectionSequence>())
      .def(
          "__len__", [](const DetectionSequence& d) { return d.frames.size(); },
          "Number of frames.")
      .def_property_readonly(
          "views",
          [](const DetectionSequence& d) { return d.header.view_names; },
          "Names of the V views.")
      .def_property_readonly(
          "skeleton",
          [](const DetectionSequence& d) { return d.header.skeleton; },
          "Skeleton of the detections.")
      .def_property_readonly(
          "frame_rate_hz",
          [](const DetectionSequence& d) { return d.header.frame_rate_hz; },
          "[Hz]; 0 if unknown.")
      .def(
          "frame_numbers",
          [](const DetectionSequence& d) {
            std::vector<int64_t> numbers;
            for (const DetectionFrame& f : d.frames) numbers.push_back(f.frame);
            return numbers;
          },
          "Numbers of the frames, ascending.")
      .def(
          "view",
          [](const DetectionSequence& d, size_t frame_idx, size_t view_idx) {
            if (frame_idx >= d.frames.size() ||
                view_idx >= d.frames[frame_idx].views.size()) {
              throw py::index_error("no such frame or view");
            }
            return ArrayOf(d.frames[frame_idx].views[view_idx].detections,
                           d.header.skeleton.joint_count());
          },
          "frame_idx"_a, "view_idx"_a,
          "(people, joints, 3) of one view of one frame: x [px], y [px],\n"
          "confidence; NaN: not found.")
      .def("__repr__", [](const DetectionSequence& d) {
        return "<kinegraph.Detections of " + std::to_string(d.frames.size()) +
               " frames, " + std::to_string(d.header.view_names.size()) +
               " views>";
      });
}

// F frames, P people, J joints.
void BindTracks(py::module_& m) {
  py::class_<TrackSequence>(m, "Tracks", "3D poses of a recording, as arrays.")
      .def(Pickled<TrackSequence>())
      .def(
          "__len__", [](const TrackSequence& t) { return t.frames.size(); },
          "Number of frames, F.")
      .def_property_readonly(
          "skeleton", [](const TrackSequence& t) { return t.header.skeleton; },
          "Skeleton of the J joints.")
      .def_property_readonly(
          "frame_rate_hz",
          [](const TrackSequence& t) { return t.header.frame_rate_hz; },
          "[Hz]; 0 if unknown.")
      .def_property_readonly(
          "mode", [](const TrackSequence& t) { return t.header.mode; },
          "\"paper\", \"graph\", \"truth\", or the format that was read.")
      .def_property_readonly(
          "config_json",
          [](const TrackSequence& t) { return t.header.config_json; },
          "The effective configuration.")
      .def("__repr__",
           [](const TrackSequence& t) {
             return "<kinegraph.Tracks of " +
                    Counted(static_cast<int64_t>(t.frames.size()), "frame",
                            "frames") +
                    ", " +
                    Counted(static_cast<int64_t>(ColumnsOf(t).size()), "person",
                            "people") +
                    ">";
           })
      .def_property_readonly(
          "frames",
          [](const TrackSequence& t) {
            return ArrayOver<int64_t>(
                t.frames, [](const TrackFrame& frame) { return frame.frame; });
          },
          "Frame numbers, (F,) int64.")
      .def_property_readonly(
          "times_s",
          [](const TrackSequence& t) {
            return ArrayOver<double>(t.frames, [](const TrackFrame& frame) {
              return ToSeconds(frame.time);
            });
          },
          "Times of the frames, (F,) [s].")
      .def_property_readonly("ids", &IdsOf,
                             "Identities, ascending, (P,) int64.")
      .def_property_readonly(
          "positions_m", &PositionsOf,
          "(F, P, J, 3) in the world [m]; NaN where a joint is missing. Each\n"
          "access creates a new array.")
      .def_property_readonly("status", &StatusesOf,
                             "(F, P, J) uint8: MISSING, INFERRED or OBSERVED.")
      .def_property_readonly("covariance_m2", &CovariancesOf,
                             "(F, P, J, 3, 3) [m^2]; NaN where there is none.");
}

void BindKinematics(py::module_& m) {
  py::class_<KinematicsTable>(
      m, "Kinematics",
      "Joint angles, speeds and path lengths: one row per person and frame\n"
      "(R rows); table[column] is an array (R,). docs/kinematics.md defines\n"
      "the columns.")
      .def(Pickled<KinematicsTable>())
      .def(
          "__len__", [](const KinematicsTable& t) { return t.rows.size(); },
          "Number of rows, R.")
      .def("__getitem__", &ColumnOf, "column"_a,
           "(R,) of one column; NaN where there is no value.")
      .def_readonly("columns", &KinematicsTable::columns,
                    "Names with their unit: l_knee_flexion_deg.")
      .def_readonly("angles", &KinematicsTable::angles,
                    "Names of the angles, without unit.")
      .def_readonly("notes", &KinematicsTable::notes,
                    "Quantities that are omitted, with the reason.")
      .def_readonly("up", &KinematicsTable::up,
                    "(3,) unit vector upwards in the world, as used; None if "
                    "unknown.")
      .def_property_readonly(
          "frames",
          [](const KinematicsTable& t) {
            return ArrayOver<int64_t>(
                t.rows, [](const KinematicsRow& row) { return row.frame; });
          },
          "Frame numbers, (R,) int64.")
      .def_property_readonly(
          "times_s",
          [](const KinematicsTable& t) {
            return ArrayOver<double>(t.rows, [&t](const KinematicsRow& row) {
              return t.has_times ? ToSeconds(row.time) : kNan;
            });
          },
          "Times, (R,) [s]; NaN if unknown.")
      .def_property_readonly(
          "ids",
          [](const KinematicsTable& t) {
            return ArrayOver<int64_t>(t.rows, [](const KinematicsRow& row) {
              return row.id.value();
            });
          },
          "Identities, (R,) int64.");
}

void BindRuns(py::module_& m) {
  m.def("track", &Track, "cameras"_a, "detections"_a, "config"_a = "",
        "set"_a = "", "mode"_a = "",
        "frames"_a = std::vector<std::pair<int64_t, int64_t>>(),
        "without_cameras"_a = std::vector<std::string>(), "threads"_a = 1,
        "progress"_a = py::none(), "See kinegraph.track.");
  m.def(
      "kinematics", &Kinematics, "tracks"_a, "up"_a = "auto",
      "observed_only"_a = false,
      "Joint angles with 95 % intervals, speeds and path lengths; returns\n"
      "Kinematics. up: axis of the world that points upwards (\"z\", \"-y\"),\n"
      "or \"auto\": estimated from the people. observed_only: joints\n"
      "that fewer than two views support in a frame count as missing.");
  py::class_<Frozen>(m, "Frozen", "A tracked recording with fixed matches.")
      .def(py::init<const std::vector<Camera>&, const DetectionSequence&,
                    const std::string&, const std::string&>(),
           "cameras"_a, "detections"_a, "config"_a = "", "set"_a = "")
      .def_property_readonly("tracks", &Frozen::tracks,
                             "The result of the run itself.")
      .def("smooth", &Frozen::Smooth, "strategy"_a,
           "The same matches, smoothed by another strategy (strategies()).");
  m.def("strategies", &OutputNames, "Names of the smoothing strategies.");
  py::class_<LiveSession>(
      m, "Session",
      "Tracks people in frames as they arrive. Calls from several threads\n"
      "are serialised; Sessions are independent of each other.")
      .def(py::init<const std::vector<Camera>&, const std::string&,
                    const std::vector<std::string>&, double, const std::string&,
                    const std::string&, const std::string&>(),
           "cameras"_a, "skeleton"_a, "views"_a, "frame_rate_hz"_a,
           "config"_a = "", "set"_a = "", "mode"_a = "")
      .def(
          "process", &LiveSession::Process, "frame"_a, "views"_a,
          "time_s"_a = py::none(),
          "Processes one frame; frame numbers must ascend. views: per view an\n"
          "array (people, joints, 3) of x [px], y [px], confidence; time_s: of "
          "the\n"
          "frame, default frame / frame_rate_hz. Returns Tracks of the frames\n"
          "that became final.")
      .def("finish", &LiveSession::Finish,
           "Returns Tracks of the remaining frames.");
}

void BindFiles(py::module_& m) {
  using Unlocked = py::call_guard<py::gil_scoped_release>;
  m.def(
      "read_cameras",
      [](const Path& path) { return ReadCameras(path.string()); }, "path"_a,
      Unlocked(),
      "Reads a calibration in any known format; lengths become metres.");
  m.def(
      "read_detections",
      [](const Path& path, const std::string& skeleton, double frame_rate_hz) {
        return ReadDetections(
            path.string(),
            ReadOptionsOf<DetectionReadOptions>(skeleton, frame_rate_hz));
      },
      "path"_a, "skeleton"_a = "", "frame_rate_hz"_a = 0.0, Unlocked(),
      "Reads 2D detections in any known format. skeleton and frame_rate_hz\n"
      "[Hz] override the file's.");
  m.def(
      "read_tracks",
      [](const Path& path, const std::string& skeleton, double frame_rate_hz) {
        return ReadTracks(path.string(), ReadOptionsOf<TrackReadOptions>(
                                             skeleton, frame_rate_hz));
      },
      "path"_a, "skeleton"_a = "", "frame_rate_hz"_a = 0.0, Unlocked(),
      "Reads 3D results or a ground truth in any known format. skeleton: for\n"
      "files that do not specify it; frame_rate_hz [Hz]: overrides the\n"
      "file's.");
  m.def("write_tracks", &WriteTracksAs, "path"_a, "tracks"_a, "format"_a = "",
        "names_of"_a = "",
        "Writes 3D poses. format: by default chosen by the path's extension,\n"
        "else kinegraph's own. names_of: file with the names of people.\n"
        "Returns a list of what the format cannot store.");
  m.def("_set_adapters", &SetOwnAdapters, "command"_a,
        "Sets the command of kinegraph-adapters.");
  m.def("_convert", &ConvertFiles, "source"_a, "target"_a, "to"_a, "from_"_a,
        "skeleton"_a, "frame_rate_hz"_a, "image_size"_a, "unit"_a, "axes"_a,
        "markers"_a, "person"_a, "set"_a, "Called by convert().");
  m.def(
      "write_cameras", &WriteCamerasAs, "path"_a, "cameras"_a,
      "format"_a = "kinegraph",
      "Writes a calibration; returns a list of what the format cannot store.");
  m.def(
      "write_detections", &WriteDetectionsAs, "path"_a, "detections"_a,
      "format"_a = "kinegraph", "image_size"_a = std::pair<int, int>(0, 0),
      "Writes 2D detections; returns a list of what the format cannot store.\n"
      "image_size: (width, height) [px], for formats that contain it.");
  m.def(
      "file_kind",
      [](const Path& path) {
        return std::string(ToString(RecogniseKind(path.string())));
      },
      "path"_a,
      "The kind of a file or folder, by content: \"calibrations\",\n"
      "\"detections\" or \"tracks\".");
}

}  // namespace
}  // namespace kinegraph

PYBIND11_MODULE(_kinegraph, m) {
  using namespace kinegraph;  // NOLINT: the binding's own scope
  m.doc() = "Native part of kinegraph.";
  py::register_exception<InputError>(m, "InputError", PyExc_ValueError);
  py::register_exception<OptionError>(m, "OptionError", PyExc_ValueError);
  m.attr("MISSING") = static_cast<int>(JointStatus::kMissing);
  m.attr("INFERRED") = static_cast<int>(JointStatus::kInferred);
  m.attr("OBSERVED") = static_cast<int>(JointStatus::kObserved);
  BindSkeleton(m);
  BindCamera(m);
  BindDetections(m);
  BindTracks(m);
  BindKinematics(m);
  BindRuns(m);
  BindFiles(m);
  m.def("_mpjpe", &Mpjpe, "tracks"_a, "truth"_a);
  m.def("_identity", &Identity, "tracks"_a, "truth"_a);
}
