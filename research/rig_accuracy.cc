// Accuracy of cameras estimated from people alone (`calibrate`), in simulated
// rooms with random parameters.
//
//   rig_accuracy FIRST_SEED COUNT [track|lenses|size|clips]
//
// Prints one line per room: its parameters, verdict and stated accuracy,
// largest errors of rotation [deg] and position [% of the room's size] after a
// similarity, number of errors within the stated 95 % regions, NEES, rms error
// of the clocks [ms], processor time [s]; then a summary. `size`: also the
// errors of the lenses. `track`: also, if all cameras are calibrated, the mean
// error of the people's joints [mm] with the estimated and with the true
// cameras and clocks, after aligning the cameras and after aligning the tracks
// by a similarity. `lenses`, `size`: rooms of four cameras with realistic
// lenses and one to four people, simulated or recorded (odd seeds), for 40 to
// 60 s; `lenses` specifies the lenses, `size` only the image size. `clips`:
// like `lenses`, with one or two people for the length of a clip (12 s if
// simulated).
//
//   rig_accuracy compare TRUTH FOUND [ALIGNED]
//
// Prints the errors of rotation, position and focal length of each camera of
// FOUND, and the normalised squared errors if FOUND has a covariance of
// rotations and positions. ALIGNED: writes the found calibration in the world
// of the true one, for scoring tracks against the truth.
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "apps/common/config_folder.h"
#include "core/base/median.h"
#include "core/base/random.h"
#include "core/evaluation/correspondence.h"
#include "core/evaluation/mpjpe.h"
#include "core/geometry/lens.h"
#include "core/io/calibration/calibration.h"
#include "core/io/configuration/refinement_record.h"
#include "core/io/tracks/tracks.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/recorded_people.h"
#include "core/synthetic/scene.h"
#include "research/arguments.h"
#include "solvers/cameras/refine.h"
#include "solvers/session/calibrate_recording.h"
#include "solvers/session/run.h"
#include "tests/support/test_data.h"

namespace kinegraph::testing {
namespace {

constexpr double kDegrees = 180.0 / M_PI;

struct CameraError {
  Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // in the found world
  double room_share = 0.0;
};

// The similarity from the mean rotation and the camera centres: a point x of
// the true world is middle_f + scale Q (x - middle_t) in the found world.
struct Alignment {
  Eigen::Matrix3d Q;
  Eigen::Vector3d middle_t = Eigen::Vector3d::Zero();
  Eigen::Vector3d middle_f = Eigen::Vector3d::Zero();
  double scale = 1.0;
  double room = 0.0;  // twice the rms distance of the centres from their middle
};

Alignment Align(const CameraRig& truth, const CameraRig& found) {
  Alignment align;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  const auto count = static_cast<double>(truth.size());
  for (size_t v = 0; v < truth.size(); ++v) {
    sum += found[v].R().transpose() * truth[v].R();
    align.middle_t += truth[v].centre() / count;
    align.middle_f += found[v].centre() / count;
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(
      sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  align.Q = svd.matrixU() * svd.matrixV().transpose();
  double cross = 0.0;
  double square = 0.0;
  for (size_t v = 0; v < truth.size(); ++v) {
    const Eigen::Vector3d t = align.Q * (truth[v].centre() - align.middle_t);
    cross += t.dot(found[v].centre() - align.middle_f);
    square += t.squaredNorm();
  }
  align.scale = cross / square;
  align.room = 2.0 * align.scale * std::sqrt(square / count);
  return align;
}

// Errors of `found` relative to `truth`, after the similarity.
std::vector<CameraError> ErrorsOf(const CameraRig& truth,
                                  const CameraRig& found) {
  const Alignment align = Align(truth, found);
  std::vector<CameraError> errors;
  for (size_t v = 0; v < truth.size(); ++v) {
    CameraError error;
    const Eigen::AngleAxisd turn(
        Eigen::Matrix3d(found[v].R() * align.Q * truth[v].R().transpose()));
    error.rotation_rad = turn.angle() * turn.axis();
    error.centre =
        found[v].centre() - align.middle_f -
        align.scale * (align.Q * (truth[v].centre() - align.middle_t));
    error.room_share = error.centre.norm() / align.room;
    errors.push_back(error);
  }
  return errors;
}

// The found cameras, in the true world.
CameraRig Aligned(const CameraRig& truth, const CameraRig& found) {
  const Alignment align = Align(truth, found);
  CameraRig aligned;
  for (const Camera& camera : found) {
    CameraParameters p = camera.parameters();
    const Eigen::Vector3d centre =
        align.middle_t +
        align.Q.transpose() * (camera.centre() - align.middle_f) / align.scale;
    p.R = camera.R() * align.Q;
    p.t = -p.R * centre;
    aligned.emplace_back(p);
  }
  return aligned;
}

constexpr double kChiSquare95 = 7.815;  // 95 %, three degrees of freedom

// Squared error, normalised by the stated covariance. `floor`: standard
// deviation added for rounding and for what the similarity absorbs.
double Squared(const Eigen::Vector3d& error, Eigen::Matrix3d covariance,
               double floor) {
  covariance.diagonal().array() += floor * floor;
  return error.dot(covariance.ldlt().solve(error));
}
double SquaredRotation(const CameraError& error,
                       const Eigen::MatrixXd& covariance, Eigen::Index at) {
  return Squared(error.rotation_rad, covariance.block<3, 3>(at, at), 2e-4);
}
double SquaredCentre(const CameraError& error, double metres_per_unit,
                     const Eigen::MatrixXd& covariance, Eigen::Index at) {
  return Squared(metres_per_unit * error.centre,
                 covariance.block<3, 3>(at + 3, at + 3), 1e-3);
}

// Normalised squared error of all rotations and centres together, divided by
// the degrees of freedom, the directions that the gauge does not fix. The
// errors are in units of the found world, the covariance is in metres. `begin`:
// the first parameter of each camera; rotation and centre are the first six.
double NeesOf(const std::vector<CameraError>& errors, double metres_per_unit,
              const Eigen::MatrixXd& covariance,
              const std::vector<Eigen::Index>& begin) {
  std::vector<Eigen::Index> poses;
  Eigen::VectorXd error(6 * static_cast<Eigen::Index>(errors.size()));
  for (size_t v = 0; v < errors.size(); ++v) {
    for (Eigen::Index i = 0; i < 6; ++i) poses.push_back(begin[v] + i);
    error.segment<3>(6 * static_cast<Eigen::Index>(v)) = errors[v].rotation_rad;
    error.segment<3>(6 * static_cast<Eigen::Index>(v) + 3) =
        metres_per_unit * errors[v].centre;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      Eigen::MatrixXd(covariance(poses, poses)));
  // The gauge fixes seven directions, those of the least variance.
  constexpr Eigen::Index kHeld = 7;
  double squares = 0.0;
  for (Eigen::Index i = kHeld; i < error.size(); ++i) {
    squares += std::pow(solver.eigenvectors().col(i).dot(error), 2) /
               solver.eigenvalues()[i];
  }
  return squares / static_cast<double>(error.size() - kHeld);
}

template <typename Places>
std::vector<Eigen::Index> BeginsOf(const Places& places) {
  std::vector<Eigen::Index> begin = {0};
  for (const std::vector<int>& one : places) {
    begin.push_back(begin.back() + static_cast<Eigen::Index>(one.size()));
  }
  return begin;
}

// Prints the normalised squared errors, if the found calibration has the
// covariance of all rotations and centres.
void PrintSquares(const std::string& found,
                  const std::vector<CameraError>& errors) {
  const auto record = ReadRefinementRecord(found);
  if (!record.has_value() || record->cameras.size() != errors.size()) return;
  std::vector<std::vector<int>> places;
  for (const RefinementRecord::Camera& camera : record->cameras) {
    if (camera.places.size() < 6 || camera.places[5] != 5) return;
    places.push_back(camera.places);
  }
  const std::vector<Eigen::Index> begin = BeginsOf(places);
  for (size_t v = 0; v < errors.size(); ++v) {
    std::printf("%-8s rotation %5.1f, centre %5.1f (95 %%: %.1f)\n",
                record->cameras[v].name.c_str(),
                SquaredRotation(errors[v], record->covariance, begin[v]),
                SquaredCentre(errors[v], 1.0, record->covariance, begin[v]),
                kChiSquare95);
  }
  std::printf("NEES per degree of freedom %.2f\n",
              NeesOf(errors, 1.0, record->covariance, begin));
}

void Compare(const std::string& truth, const std::string& found,
             const std::string& out) {
  const CameraRig all = ReadCameras(truth);
  CameraRig one;
  const CameraRig other = ReadCameras(found);
  for (size_t v = 0; v < other.size(); ++v) {
    for (const Camera& camera : all) {
      if (camera.name() == other[v].name()) one.push_back(camera);
    }
  }
  if (!out.empty()) WriteCameras(out, Aligned(one, other));
  const auto errors = ErrorsOf(one, other);
  for (size_t v = 0; v < errors.size(); ++v) {
    std::printf("%-8s %6.3f deg %7.2f cm %6.2f %% focal %6.2f %%\n",
                one[v].name().c_str(), kDegrees * errors[v].rotation_rad.norm(),
                100.0 * errors[v].centre.norm(), 100.0 * errors[v].room_share,
                100.0 * (other[v].focal_px() / one[v].focal_px() - 1.0));
  }
  PrintSquares(found, errors);
}

struct Room {
  Scene scene;
  DetectionSequence recording;
  CalibrationInput input;
  std::vector<double> late_s;
  std::string words;
};

enum class Focal { kKnown, kRough, kUnknown };

std::vector<std::shared_ptr<const Actor>> Recorded(Random* random, int people,
                                                   double seconds) {
  static const std::vector<std::string> kClips = {"walk_30hz", "hop_30hz",
                                                  "dance_30hz"};
  RecordedPeopleOptions options;
  std::vector<kinegraph::MotionClip> clips;
  std::vector<kinegraph::MotionClip> known;
  for (const std::string& name : kClips) {
    const std::string file =
        FindData("motion/" + name + ".jsonl").value().string();
    known.push_back({name, ReadTracks(file)});
  }
  for (int person = 0; person < people; ++person) {
    for (double at = random->Uniform(0.0, 1.0); at < seconds;) {
      const auto& clip = known[static_cast<size_t>(random->Index(3))];
      clips.push_back(clip);
      options.start_s.push_back(at);
      const auto& frames = clip.tracks.frames;
      at += ToSeconds(frames.back().time - frames.front().time) + 0.5;
    }
  }
  ClipRoom room;
  room.seed = random->Fork();
  return MakeRecordedPeople(options, clips, Coco17(), room);
}

CameraRig Cameras(Random* random, int count, Scene* scene) {
  const double focal = random->Uniform(650.0, 1400.0);
  const double radius = random->Uniform(4.5, 7.0);
  const double arc =
      random->Chance(0.6) ? 2.0 * M_PI : random->Uniform(1.6, 3.6);
  CameraRig cameras;
  for (int v = 0; v < count; ++v) {
    CameraParameters p;
    p.name = "cam" + std::to_string(v);
    p.width_px = 1280;
    p.height_px = 720;
    const double f = focal * random->Uniform(0.95, 1.05);
    p.K << f, 0.0, 640.0, 0.0, f, 360.0, 0.0, 0.0, 1.0;
    const double angle = arc * (v + random->Uniform(-0.25, 0.25)) / count;
    const double r = radius * random->Uniform(0.85, 1.15);
    const Eigen::Vector3d centre(r * std::cos(angle), r * std::sin(angle),
                                 random->Uniform(1.0, 3.0));
    const Eigen::Vector3d target(random->Uniform(-0.5, 0.5),
                                 random->Uniform(-0.5, 0.5),
                                 random->Uniform(0.7, 1.1));
    const Eigen::Vector3d z = (target - centre).normalized();
    const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
    Eigen::Matrix3d R;
    R << x.transpose(), z.cross(x).transpose(), z.transpose();
    p.R =
        Eigen::AngleAxisd(random->Normal(0.0, 0.03), Eigen::Vector3d::UnitZ()) *
        R;
    p.t = -p.R * centre;
    cameras.emplace_back(p);
  }
  scene->cameras = cameras;
  return cameras;
}

NoiseOptions Noise(Random* random, int cameras, double focal, double* sigma,
                   std::vector<double>* late_s) {
  NoiseOptions noise;
  noise.seed = static_cast<int64_t>(random->Index(1000000));
  *sigma = random->Uniform(2.0, 6.0);
  // According to the noise model of detectors: a constant offset of 9 mm per
  // axis, 14 mm at the hips.
  const auto joint = [&](double lasting_mm) {
    JointNoise one;
    one.reference_depth_m = 5.0;
    const double lasting = 1e-3 * lasting_mm * focal / 5.0;
    one.sigma_px = std::hypot(*sigma, lasting);
    one.static_share = std::pow(lasting / one.sigma_px, 2);
    one.white_share = 0.2 * (1.0 - one.static_share);
    one.correlation_time_s = 0.15;
    one.student_dof = 4.0;
    one.outlier_rate = 0.02;
    one.outlier_burst_s = 0.12;
    one.missing_rate = 0.05;
    one.missing_burst_s = 0.2;
    one.hidden_missing_rate = 0.4;
    one.hidden_noise_factor = 2.0;
    return one;
  };
  noise.joints = joint(9.0);
  for (int i = 0; i < kJointClassCount; ++i) {
    const auto joint_class = static_cast<JointClass>(i);
    noise.by_class[joint_class] =
        joint(joint_class == JointClass::kHip ? 14.0 : 9.0);
  }
  noise.confidence = 0.8;
  noise.confidence_sigma = 0.1;
  noise.missed_rate = 0.02;
  noise.missed_burst_s = 0.2;
  noise.hidden_missed_rate = 0.6;
  noise.min_joints = 4;
  noise.false_people = 0.1;
  noise.swap_whole_rate = 0.003;
  noise.swap_leg_rate = 0.003;
  noise.swap_burst_s = 0.1;
  noise.fragment_rate = 0.005;
  noise.double_rate = 0.005;
  noise.tell_times = false;
  const bool apart = random->Chance(0.6);
  for (int v = 0; v < cameras; ++v) {
    late_s->push_back(apart ? random->Uniform(-1.0, 1.0) : 0.0);
  }
  noise.clock_offset_s = *late_s;
  return noise;
}

Room MakeRoom(int seed) {
  Random random(static_cast<uint64_t>(seed) * 7919 + 17);
  Room room;
  const int cameras = 2 + static_cast<int>(random.Index(7));
  const int people = 1 + static_cast<int>(random.Index(6));
  const double seconds = random.Uniform(10.0, 60.0);
  const bool recorded = random.Chance(0.5);
  SceneOptions options;
  options.seed = static_cast<int64_t>(random.Index(1000000));
  options.people = people;
  options.duration_s = seconds;
  options.trunk_flexibility = 1.0;
  options.motion.area_radius_m = random.Uniform(1.5, 3.0);
  options.cameras.count = cameras;
  room.scene = recorded ? MakeScene(options, Coco17(),
                                    Recorded(&random, people, seconds))
                        : MakeScene(options);
  Cameras(&random, cameras, &room.scene);
  double sigma = 0.0;
  const NoiseOptions noise = Noise(
      &random, cameras, room.scene.cameras[0].focal_px(), &sigma, &room.late_s);
  room.recording = Observe(room.scene, noise, nullptr);
  const auto focal = static_cast<Focal>(random.Index(3));
  room.input.focal_sigma = focal == Focal::kKnown   ? 0.0
                           : focal == Focal::kRough ? 0.1
                                                    : 0.3;
  for (const Camera& camera : room.scene.cameras) {
    CameraParameters p = camera.parameters();
    double f = camera.focal_px();
    if (focal == Focal::kRough) f *= std::exp(random.Normal(0.0, 0.1));
    if (focal == Focal::kUnknown) f = 0.87 * 1280.0;
    p.K(0, 0) = p.K(1, 1) = f;
    p.R.setIdentity();
    p.t.setZero();
    room.input.cameras.emplace_back(p);
  }
  const char* kFocals[] = {"known", "rough", "unknown"};
  char words[160];
  std::snprintf(words, sizeof(words),
                "%d cameras %d people %2.0f s %s %.1f px clocks %s focal %s",
                cameras, people, seconds, recorded ? "recorded " : "simulated",
                sigma, room.late_s[0] != 0.0 ? "apart" : "same ",
                kFocals[static_cast<int>(focal)]);
  room.words = words;
  return room;
}

// Gives a camera a lens like a measured one: barrel distortion, which k2
// reduces towards the corners, and a principal point off by 1 % of the width.
Camera WithRealLens(const Camera& camera, Random* random) {
  CameraParameters p = camera.parameters();
  const double k1 = -random->Uniform(0.05, 0.3);
  const double k2 = -random->Uniform(0.3, 0.9) * k1;
  p.lens = MakeLens("opencv5", {k1, k2, random->Normal(0.0, 5e-4),
                                random->Normal(0.0, 5e-4), 0.0});
  const double angle = random->Uniform(0.0, 2.0 * M_PI);
  p.K(0, 2) += 0.01 * p.width_px * std::cos(angle);
  p.K(1, 2) += 0.01 * p.width_px * std::sin(angle);
  return Camera(p);
}

// Moves the images of a view to later (or earlier) frames, because the noise
// model limits clock errors to a second.
void ShowLater(size_t view, int frames, DetectionSequence* recording) {
  const std::vector<DetectionFrame> shown = recording->frames;
  const int count = static_cast<int>(shown.size());
  for (int k = 0; k < count; ++k) {
    auto& detections = recording->frames[k].views[view].detections;
    detections.clear();
    const int from = k - frames;
    if (from < 0 || from >= count) continue;
    detections = shown[from].views[view].detections;
  }
}

// One clip per person; all clips begin at time 0.
std::vector<std::shared_ptr<const Actor>> OneClipEach(Random* random,
                                                      int people) {
  static const std::vector<std::string> kClips = {
      "dance_30hz", "start_walk_stop_120hz", "start_hop_stop_120hz"};
  RecordedPeopleOptions options;
  std::vector<kinegraph::MotionClip> clips;
  const size_t first = random->Index(kClips.size());
  for (int person = 0; person < people; ++person) {
    // A different clip for each person: two people with the same clip could not
    // be distinguished.
    const std::string& name =
        kClips[(first + static_cast<size_t>(person)) % kClips.size()];
    clips.push_back(
        {name,
         ReadTracks(FindData("motion/" + name + ".jsonl").value().string())});
  }
  ClipRoom room;
  room.seed = random->Fork();
  return MakeRecordedPeople(options, clips, Coco17(), room);
}

// The room of `lenses`, `size` and `clips`.
Room MakeLensRoom(int seed, const std::string& kind) {
  const bool size_alone = kind == "size";
  const bool are_clips = kind == "clips";
  Random random(static_cast<uint64_t>(seed) * 6007 + 29);
  Room room;
  constexpr int kCameras = 4;
  const int people = 1 + static_cast<int>(random.Index(are_clips ? 2 : 4));
  const bool recorded = seed % 2 != 0;
  const auto clips = are_clips && recorded
                         ? OneClipEach(&random, people)
                         : std::vector<std::shared_ptr<const Actor>>();
  const double seconds =
      are_clips ? (recorded ? EndOf(clips) : 12.0) : random.Uniform(40.0, 60.0);
  SceneOptions options;
  options.seed = static_cast<int64_t>(random.Index(1000000));
  options.people = people;
  options.duration_s = seconds;
  options.trunk_flexibility = 1.0;
  options.motion.area_radius_m = random.Uniform(2.0, 3.0);
  options.cameras.count = kCameras;
  room.scene =
      recorded
          ? MakeScene(options, Coco17(),
                      are_clips ? clips : Recorded(&random, people, seconds))
          : MakeScene(options);
  Cameras(&random, kCameras, &room.scene);
  for (Camera& camera : room.scene.cameras) {
    camera = WithRealLens(camera, &random);
  }
  double sigma = 0.0;
  NoiseOptions noise =
      Noise(&random, kCameras, room.scene.cameras[0].focal_px(), &sigma,
            &room.late_s);
  for (double& late_s : room.late_s) late_s = random.Uniform(-1.0, 1.0);
  noise.clock_offset_s = room.late_s;
  room.recording = Observe(room.scene, noise, nullptr);
  for (size_t v = 0; v < kCameras; ++v) {
    const int frames = are_clips ? 0 : static_cast<int>(random.Index(76)) - 38;
    ShowLater(v, frames, &room.recording);
    room.late_s[v] -= frames / options.frame_rate_hz;
  }
  room.input.lenses_known = !size_alone;
  room.input.focal_sigma = size_alone ? 0.3 : 0.0;
  for (const Camera& camera : room.scene.cameras) {
    CameraParameters p = camera.parameters();
    if (size_alone) {
      p.lens = nullptr;
      p.K << 0.87 * p.width_px, 0.0, 0.5 * p.width_px, 0.0, 0.87 * p.width_px,
          0.5 * p.height_px, 0.0, 0.0, 1.0;
    }
    p.R.setIdentity();
    p.t.setZero();
    room.input.cameras.emplace_back(p);
  }
  char words[160];
  std::snprintf(words, sizeof(words), "%d people %2.0f s %s %.1f px f %4.0f %s",
                people, seconds, recorded ? "recorded " : "simulated", sigma,
                room.scene.cameras[0].focal_px(),
                size_alone ? "size" : "lenses");
  room.words = words;
  return room;
}

struct RoomScore {
  RigVerdict verdict = RigVerdict::kRefused;
  int cameras = 0;
  double rotation_deg = 0.0;  // the largest
  double place = 0.0;  // the largest error of a centre / size of the room
  int covered = 0;     // rotations and centres within their 95 % regions
  int counted = 0;     // rotations and centres
  double clock_ms = 0.0;
  double nees = 0.0;  // of all rotations and centres, over degrees of freedom
};

RoomScore ScoreOf(const Room& room, const RecordingCalibration& found) {
  RoomScore score;
  score.verdict = found.rig.verdict;
  score.cameras = static_cast<int>(room.scene.cameras.size());
  if (found.cameras.empty()) return score;
  CameraRig truth;
  for (const int v : found.rig.used) {
    truth.push_back(room.scene.cameras[static_cast<size_t>(v)]);
  }
  const auto errors = ErrorsOf(truth, found.rig.cameras);
  const double metres = found.metres_per_unit;
  const Eigen::MatrixXd& covariance = found.rig.covariance;
  const std::vector<Eigen::Index> begin = BeginsOf(found.rig.places);
  score.nees = NeesOf(errors, metres, covariance, begin);
  double squares = 0.0;
  double mean = 0.0;
  std::vector<double> clocks;
  for (size_t v = 0; v < errors.size(); ++v) {
    score.rotation_deg =
        std::max(score.rotation_deg, kDegrees * errors[v].rotation_rad.norm());
    score.place = std::max(score.place, errors[v].room_share);
    score.covered +=
        (SquaredRotation(errors[v], covariance, begin[v]) < kChiSquare95) +
        (SquaredCentre(errors[v], metres, covariance, begin[v]) < kChiSquare95);
    score.counted += 2;
    const auto view = static_cast<size_t>(found.rig.used[v]);
    // The correction of a view's clock should equal the delay of its images.
    clocks.push_back(found.rig.views[view].clock_s - room.late_s[view]);
    mean += clocks.back() / static_cast<double>(errors.size());
  }
  for (const double clock : clocks) squares += std::pow(clock - mean, 2);
  score.clock_ms =
      1e3 * std::sqrt(squares / static_cast<double>(clocks.size()));
  return score;
}

// `tracks` after the similarity that best aligns all of their joints with the
// true ones.
TrackSequence Nearest(const TrackSequence& truth, TrackSequence tracks) {
  const JointPairs joints =
      CommonJoints(truth.header.skeleton, tracks.header.skeleton);
  std::vector<Eigen::Vector3d> from;
  std::vector<Eigen::Vector3d> to;
  for (const PersonPair& pair :
       PairPeople(truth, tracks, joints, kPersonGateM, {})) {
    if (pair.found == nullptr) continue;
    for (const JointPair& joint : joints) {
      const Joint3d& expected = pair.truth->joints[joint.a];
      const Joint3d& found = pair.found->joints[joint.b];
      if (!expected.present() || !found.present()) continue;
      from.push_back(found.position_m);
      to.push_back(expected.position_m);
    }
  }
  if (from.empty()) return tracks;
  const auto count = static_cast<Eigen::Index>(from.size());
  const Eigen::Affine3d similarity(Eigen::umeyama(
      Eigen::Map<const Eigen::Matrix3Xd>(from[0].data(), 3, count),
      Eigen::Map<const Eigen::Matrix3Xd>(to[0].data(), 3, count)));
  for (TrackFrame& frame : tracks.frames) {
    for (PersonPose& person : frame.people) {
      for (Joint3d& joint : person.joints) {
        joint.position_m = similarity * joint.position_m;
      }
    }
  }
  return tracks;
}

// Mean error of the joints with given cameras and clocks [m].
struct TrackingError {
  double as_cameras = 0.0;  // after aligning the cameras
  double nearest = 0.0;     // after aligning the tracks by a similarity
};

TrackingError TrackingErrorOf(const Room& room, const RunOptions& options,
                              const CameraRig& cameras,
                              const DetectionSequence& recording) {
  RunRequest request;
  request.cameras = cameras;
  const TrackSequence truth = TruthOf(room.scene);
  const TrackSequence tracks = TrackSequenceOf(options, request, recording);
  return {EvaluateMpjpe(truth, tracks).raw_m,
          EvaluateMpjpe(truth, Nearest(truth, tracks)).raw_m};
}

// Prints the errors of joints with the found and with the true cameras. Returns
// the logarithms of their ratios.
TrackingError CompareTracking(const Room& room, const RunOptions& options,
                              const RecordingCalibration& found) {
  std::vector<CameraChange> late(room.late_s.size(), CameraChange::Zero());
  // The clock error of the reference view also remains in the found recording.
  CameraChange reference = CameraChange::Zero();
  reference[kOffsetAt] = room.late_s[0] - found.rig.views[0].clock_s;
  for (size_t v = 0; v < late.size(); ++v) {
    late[v][kOffsetAt] = room.late_s[v];
  }
  const TrackingError with_true = TrackingErrorOf(
      room, options, room.scene.cameras, WithClocks(room.recording, late));
  const TrackingError with_found = TrackingErrorOf(
      room, options, Aligned(room.scene.cameras, found.rig.cameras),
      WithClocks(found.rig.recording,
                 std::vector<CameraChange>(late.size(), reference)));
  const TrackingError ratio = {with_found.as_cameras / with_true.as_cameras,
                               with_found.nearest / with_true.nearest};
  std::printf(
      "%4s joints %.1f mm, with the true cameras %.1f: %+.1f %%; after "
      "aligning the tracks %.1f, %.1f: %+.1f %%\n",
      "", 1e3 * with_found.as_cameras, 1e3 * with_true.as_cameras,
      100.0 * (ratio.as_cameras - 1.0), 1e3 * with_found.nearest,
      1e3 * with_true.nearest, 100.0 * (ratio.nearest - 1.0));
  return {std::log(ratio.as_cameras), std::log(ratio.nearest)};
}

void SummariseTracking(const std::vector<TrackingError>& more) {
  if (more.empty()) return;
  TrackingError mean;
  for (const TrackingError& one : more) {
    mean.as_cameras += one.as_cameras / static_cast<double>(more.size());
    mean.nearest += one.nearest / static_cast<double>(more.size());
  }
  std::printf(
      "joint errors in %zu rooms: %+.1f %% (geometric mean), %+.1f %% after "
      "aligning the tracks\n",
      more.size(), 100.0 * std::expm1(mean.as_cameras),
      100.0 * std::expm1(mean.nearest));
}

void Summarise(const std::vector<RoomScore>& scores) {
  std::vector<double> nees;
  int partly = 0;
  int refused = 0;
  int partly_covered = 0;
  int partly_counted = 0;
  int calibrated = 0;
  int of_three = 0;
  int three = 0;
  int within = 0;
  int beyond = 0;
  int covered = 0;
  int counted = 0;
  for (const RoomScore& score : scores) {
    three += score.cameras >= 3 ? 1 : 0;
    if (score.nees > 0.0) nees.push_back(score.nees);
    refused += score.verdict == RigVerdict::kRefused ? 1 : 0;
    if (score.verdict == RigVerdict::kPartly) {
      ++partly;
      partly_covered += score.covered;
      partly_counted += score.counted;
    }
    if (score.verdict != RigVerdict::kCalibrated) continue;
    ++calibrated;
    of_three += score.cameras >= 3 ? 1 : 0;
    within += score.rotation_deg <= 0.3 && score.place <= 0.01 ? 1 : 0;
    beyond += score.rotation_deg > 1.0 ? 1 : 0;
    covered += score.covered;
    counted += score.counted;
  }
  std::printf(
      "%zu rooms, %d calibrated (%d of %d with three or more cameras); of "
      "those %d within 0.3 deg and 1 %%, %d beyond 1 deg; covariances cover "
      "%.1f %%\n",
      scores.size(), calibrated, of_three, three, within, beyond,
      100.0 * covered / std::max(1, counted));
  std::printf(
      "%d partly (covered %.1f %%), %d refused; median NEES per degree of "
      "freedom %.2f\n",
      partly, 100.0 * partly_covered / std::max(1, partly_counted), refused,
      nees.empty() ? 0.0 : Median(nees));
}

// Prints errors (and stated standard deviations) of focal lengths and principal
// points, and k1 with its true value.
void PrintLenses(const Room& room, const RecordingCalibration& found) {
  Eigen::Index at = 0;
  for (size_t v = 0; v < found.rig.used.size(); ++v) {
    const Camera& truth =
        room.scene.cameras[static_cast<size_t>(found.rig.used[v])];
    const Camera& camera = found.rig.cameras[v];
    const auto& places = found.rig.places[v];
    const auto sigma = [&](int place) {
      const auto i = std::find(places.begin(), places.end(), place);
      const Eigen::Index k = at + (i - places.begin());
      return i == places.end() ? 0.0 : std::sqrt(found.rig.covariance(k, k));
    };
    const auto k1 = [](const Camera& one) {
      return one.lens() == nullptr ? 0.0 : one.lens()->parameters()[0];
    };
    std::printf(
        "     %-8s focal %+6.2f %% (%.2f) x %+6.1f px (%.1f) y %+6.1f (%.1f) "
        "k1 %+.3f instead of %+.3f\n",
        truth.name().c_str(),
        100.0 * std::log(camera.focal_px() / truth.focal_px()),
        100.0 * sigma(kFocalAt), camera.K()(0, 2) - truth.K()(0, 2),
        sigma(kShiftAt), camera.K()(1, 2) - truth.K()(1, 2),
        sigma(kShiftAt + 1), k1(camera), k1(truth));
    at += static_cast<Eigen::Index>(places.size());
  }
}

void Rooms(int first, int count, const std::string& kind) {
  const bool track = kind == "track";
  const bool has_lenses = kind == "lenses" || kind == "size" || kind == "clips";
  const RunOptions options =
      ReadRunOptions(ProjectConfig("default.toml"), "", "");
  std::vector<RoomScore> scores;
  std::vector<TrackingError> more;
  for (int seed = first; seed < first + count; ++seed) {
    const Room room = has_lenses ? MakeLensRoom(seed, kind) : MakeRoom(seed);
    const std::clock_t begin = std::clock();
    const RecordingCalibration found =
        CalibrateRecording(options, room.input, room.recording);
    const double seconds =
        static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    scores.push_back(ScoreOf(room, found));
    const RoomScore& score = scores.back();
    double sigma = 0.0;
    double place = 0.0;
    double apart = 0.0;
    double agreement = 1.0;
    double clock_sigma_s = 0.0;
    for (const RigView& view : found.rig.views) {
      sigma = std::max(sigma, view.rotation_sigma_deg);
      place = std::max(place, view.centre_sigma_m / found.rig.size_m);
      apart = std::max(apart, view.halves_apart);
      clock_sigma_s = std::max(clock_sigma_s, view.clock_sigma_s);
      agreement = std::min(agreement, view.agreement);
    }
    std::printf(
        "%4d %s: %-10s agree %.3f likely %.2f sigma %.2f "
        "%.2f %% apart %.1f; %zu of %d, "
        "%6.3f deg %6.2f %%, covered %d of %d, NEES %.2f, clocks "
        "%.1f ms (%.1f stated), %.1f s%s%s\n",
        seed, room.words.c_str(), ToString(score.verdict), agreement,
        found.rig.likely_right, sigma, 100.0 * place, apart,
        found.rig.used.size(), score.cameras, score.rotation_deg,
        100.0 * score.place, score.covered, score.counted, score.nees,
        score.clock_ms, 1e3 * clock_sigma_s, seconds,
        found.rig.reasons.empty() ? "" : "; ",
        found.rig.reasons.empty() ? "" : found.rig.reasons[0].c_str());
    if (kind == "size") PrintLenses(room, found);
    if (track && found.cameras.size() == room.scene.cameras.size()) {
      more.push_back(CompareTracking(room, options, found));
    }
    std::fflush(stdout);
  }
  Summarise(scores);
  SummariseTracking(more);
}

}  // namespace
}  // namespace kinegraph::testing

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if ((arguments.size() == 3 || arguments.size() == 4) &&
      arguments[0] == "compare") {
    kinegraph::testing::Compare(arguments[1], arguments[2],
                                arguments.size() == 4 ? arguments[3] : "");
    return 0;
  }
  if (arguments.size() < 2 || arguments.size() > 3) return 2;
  kinegraph::testing::Rooms(std::stoi(arguments[0]), std::stoi(arguments[1]),
                            arguments.size() == 3 ? arguments[2] : "");
  return 0;
}
