// Hypotheses about faults of a set-up. A hypothesis examines the set-up as
// corrected by earlier answers; its answer has findings (kind, description, fix
// as a command) and the correction. doctor.cc asks the hypotheses, applies
// their answers, and asks again.
//
// To add one, write a function, add it to the list in hypotheses.cc, and test
// it in tests/solvers/scene/doctor_test.cc.
#ifndef KINEGRAPH_SOLVERS_SCENE_HYPOTHESIS_H_
#define KINEGRAPH_SOLVERS_SCENE_HYPOTHESIS_H_

#include <algorithm>
#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "solvers/cameras/fit_error.h"
#include "solvers/cameras/segments.h"
#include "solvers/scene/doctor.h"
#include "solvers/scene/view_agreement.h"

namespace kinegraph {

// A set-up with all corrections found so far.
class SetUp {
 public:
  SetUp(const DoctorInput& input, const DoctorOptions& options);

  const DoctorInput& input;
  const DoctorOptions& options;
  CameraRig cameras;
  // Evenly spaced (OnGrid), unless frames are independent.
  DetectionSequence detections;
  int64_t number_step = 1;  // between the numbers of these frames
  double rate_hz = 0.0;     // of these frames, nominal

  // People in the detections, in raw and in ideal pixels of the cameras, the
  // frames in which they are compared, and the agreement of all pairs of views
  // in these frames. Recomputed by Look().
  std::vector<ViewPeople> raw;
  std::vector<ViewPeople> ideal;
  std::vector<int> frames;
  PairAgreement agreement;
  void Look();
  // If the views agree this well, the search leaves out other calibrations,
  // images, rates and assignments of cameras to views, but not exchanged sides
  // and clock offsets.
  bool AgreeAlready() const { return agreement.score() >= 0.85; }

  // Segments of the tracker's matches with these cameras and detections; empty
  // before the stage kStrangers. Recomputed by Match().
  SceneSegments segments;
  FitError Fit() const;
  void Match();

  // Views excluded from further hypotheses: their detections are left out.
  std::set<size_t> strangers;
  // Number of reinterpretations of files, cameras, images or clocks so far.
  int readings_changed = 0;

  std::string CameraName(size_t view) const {
    return input.cameras[view].name();
  }
  // The cameras, each with the name that pairs it with its view.
  CameraRig NamedCameras() const;
  const std::string& ViewName(size_t view) const {
    return input.detections.header.view_names[view];
  }
  int LongestLag() const;  // in frames
  // Agreement of all pairs of views, with other cameras or detections.
  double ScoreOf(const CameraRig& other_cameras,
                 const DetectionSequence& other_detections) const;
  // Agreement of a view with the others (ComparedPairs); optionally with
  // another camera and other people in this view.
  PairAgreement WithOthers(size_t view) const;
  PairAgreement WithOthers(size_t view, const Camera& camera,
                           const ViewPeople& own,
                           const std::vector<int>& in_frames) const;
};

// An answer: findings, and changes to the set-up. Empty fields leave it
// unchanged.
struct Answer {
  std::vector<Finding> findings;
  std::vector<std::string> notes;
  double score = 0.0;  // agreement of all pairs of views, for competing answers
  double stature_m = 0.0;  // of the people, if determined
  std::optional<CameraRig> cameras;
  std::optional<DetectionSequence> detections;
  // Segments of the matches with these changes, if known; otherwise, from the
  // stage kStrangers on, Match() is called.
  std::optional<SceneSegments> segments;
  std::vector<size_t> strangers;
};

// When a hypothesis is asked. Within a stage they are asked in the order of the
// list; those of kReadings compete: the answer with the best agreement is
// applied, and they are asked again, until none has an answer or three answers
// were applied.
enum class Stage {
  kFiles,      // the frames of the files, without cameras
  kTwins,      // two views with the same calibration
  kReadings,   // reinterpretations of files, images and clocks of the views
  kWorld,      // other examinations before the whole recording is tracked
  kStrangers,  // with the tracker's matches: views with hardly any
  kJumps,      // with the matches: images that were lost or duplicated
  kMatches,    // with the matches: speeds, lenses, residuals
};

struct Hypothesis {
  const char* name;
  Stage stage;
  std::optional<Answer> (*ask)(const SetUp& set_up);
  int most = 1;  // maximum number of answers
};

// All hypotheses; hypotheses.cc contains the list and the short hypotheses.
const std::vector<Hypothesis>& Hypotheses();

// view_checks.cc
std::optional<Answer> AskForOtherImage(const SetUp& set_up);
std::optional<Answer> AskForOtherRate(const SetUp& set_up);
std::optional<Answer> AskForSides(const SetUp& set_up);
// Whether changing one view's image, even by a small shift, increases its
// agreement with the others.
bool AMovedImageHelps(const SetUp& set_up);
// readings.cc
std::optional<Answer> AskForOtherReading(const SetUp& set_up);
// breaks.cc
std::optional<Answer> AskForBreak(const SetUp& set_up);
std::optional<Answer> AskForJump(const SetUp& set_up);
// explain_residuals.cc
std::optional<Answer> AskResiduals(const SetUp& set_up);

// ---- Reporting ----

// The confidence of each of `count` findings that fit equally well. The
// confidence of a certain finding is 0.95, never 1.
double Shared(double confidence, size_t count);

// A finding whose correction increases the agreement of the views, by `gain`.
Finding Found(const char* kind, const std::string& camera,
              const AgreementGain& gain, const std::string& fix,
              const std::string& what);

// An answer with a finding only.
Answer AnswerWith(Finding finding);

// The image size of the camera, or twice its principal point if unknown [px].
double ImageWidth(const Camera& camera);
double ImageHeight(const Camera& camera);

// Views whose left and right are exchanged relative to most others, in the
// frames of `seen`: a flag per view, the gain over the pairs with exactly one
// exchanged view, and the corrected people (ideal px).
struct ExchangedSides {
  std::vector<char> views;
  AgreementGain gain;
  std::vector<ViewPeople> people;
  bool any() const {
    return std::find(views.begin(), views.end(), 1) != views.end();
  }
};
ExchangedSides FindExchangedSides(const CameraRig& cameras,
                                  DetectionSequence seen);

// The flag that exchanges left and right in the views with a nonzero entry.
std::string ExchangeSidesFlag(const std::vector<char>& views,
                              const std::vector<std::string>& names);

// Value of detections.mirror_px: an axis, 'x' or 'y', and the sum of a
// coordinate and its mirror image.
std::string MirrorText(char axis, double sum_px);
// The flag that mirrors views back, from one MirrorText per view, empty if the
// view is not mirrored.
std::string MirrorFlag(const std::vector<std::string>& mirrors,
                       const std::vector<std::string>& names);
// The MirrorText of each camera if y counts from the bottom of the images.
std::vector<std::string> FromTheBottom(const CameraRig& cameras);

// Number of people in 3D whose nose lies behind the shoulders, among those
// looked at. If these are most people, left and right are exchanged or the
// world is mirrored.
struct Noses {
  int backwards = 0;
  int looked_at = 0;
  bool are_backwards() const {
    constexpr int kEnough = 10;
    constexpr double kMost = 0.8;
    return looked_at >= kEnough && backwards > kMost * looked_at;
  }
};
Noses NosesOf(const CameraRig& cameras, const std::vector<ViewPeople>& ideal,
              const Skeleton& skeleton);

// Whether nearly all people are upside down in the images. If noses also lie
// behind the shoulders, y counts from the bottom; in rotated images noses
// remain in front.
bool StandOnHeads(const DetectionSequence& seen);

// Exchanges left and right in the views with a nonzero flag.
void ExchangeSides(const std::vector<char>& views,
                   DetectionSequence* detections);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_HYPOTHESIS_H_
