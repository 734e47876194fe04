// What may be wrong with a set-up. A hypothesis is a question that is asked of
// the set-up as the answers before it have left it; it answers with findings
// (their kind, the words, the fix as a command) and with what sets things
// right. doctor.cc asks them, takes what they answer, and asks again.
//
// A new one is a function and a line of the list in hypotheses.cc, and its test
// in tests/solvers/scene/doctor_test.cc.
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

// A set-up with everything set right that was found so far.
class SetUp {
 public:
  SetUp(const DoctorInput& input, const DoctorOptions& options);

  const DoctorInput& input;
  const DoctorOptions& options;
  CameraRig cameras;
  DetectionSequence detections;

  // People in the detections, in raw and in ideal pixels of the cameras, and
  // the frames in which they are compared. Look makes them anew.
  std::vector<ViewPeople> raw;
  std::vector<ViewPeople> ideal;
  std::vector<int> frames;
  PairAgreement agreement;  // of all pairs of views there
  void Look();
  // Views that agree so well can gain nothing from another reading.
  bool AgreeAlready() const { return agreement.score() >= 0.85; }

  // From the stage of the matches on: of the tracker with these cameras and
  // detections. Match makes them anew.
  SceneSegments segments;
  FitError Fit() const;
  void Match();

  // Views that nothing more is said of: their detections are left out.
  std::set<size_t> strangers;
  // How often files, cameras, images or clocks were read otherwise.
  int readings_changed = 0;

  std::string CameraName(size_t view) const {
    return input.cameras[view].name();
  }
  // The cameras, each under the name that its view is paired with.
  CameraRig NamedCameras() const;
  const std::string& ViewName(size_t view) const {
    return input.detections.header.view_names[view];
  }
  int LongestLag() const;  // frames
  // Agreement of all pairs of views, with other cameras or detections.
  double ScoreOf(const CameraRig& other_cameras,
                 const DetectionSequence& other_detections) const;
  // Of a view with all others; with another camera or people of its own.
  PairAgreement WithOthers(size_t view) const;
  PairAgreement WithOthers(size_t view, const Camera& camera,
                           const ViewPeople& own,
                           const std::vector<int>& in_frames) const;
};

// An answer: what was found, and what becomes of the set-up. What is empty
// stays as it is.
struct Answer {
  std::vector<Finding> findings;
  std::vector<std::string> notes;
  double score = 0.0;  // agreement of all pairs of views, where answers compete
  double stature_m = 0.0;  // of the people, where it was told
  std::optional<CameraRig> cameras;
  std::optional<DetectionSequence> detections;
  std::optional<SceneSegments> segments;  // where they were made with these
  std::vector<size_t> strangers;
};

// When it is asked. Within a stage hypotheses are asked in the order of the
// list; those of kReadings compete: the answer that brings the views together
// best is taken, and all are asked again.
enum class Stage {
  kFiles,      // the frames of the files, without cameras
  kTwins,      // views with one calibration
  kReadings,   // files, images and clocks of the views read otherwise
  kWorld,      // what is left to say without tracking
  kStrangers,  // with the tracker's matches: views that have none
  kJumps,      // and pictures that were lost
  kMatches,    // and what residuals tell
};

struct Hypothesis {
  const char* name;
  Stage stage;
  std::optional<Answer> (*ask)(const SetUp& set_up);
  int most = 1;  // times that it is answered
};

// All of them; hypotheses.cc holds the list and the short ones.
const std::vector<Hypothesis>& Hypotheses();

// view_checks.cc
std::optional<Answer> AskForOtherImage(const SetUp& set_up);
std::optional<Answer> AskForOtherRate(const SetUp& set_up);
std::optional<Answer> AskForSides(const SetUp& set_up);
// readings.cc
std::optional<Answer> AskForOtherReading(const SetUp& set_up);
// breaks.cc
std::optional<Answer> AskForBreak(const SetUp& set_up);
std::optional<Answer> AskForJump(const SetUp& set_up);

// Whether another image of one view, also one that is moved by little, brings
// it nearer to the others.
bool AMovedImageHelps(const SetUp& set_up);
// explain_residuals.cc
std::optional<Answer> AskResiduals(const SetUp& set_up);

// ---- How it is told ----

// The confidence of each of `count` findings that fit equally. Sure things are
// 0.95, doubtful ones less, nothing is 1.
double Shared(double confidence, size_t count);

// Of what brings views together.
Finding Found(const char* kind, const std::string& camera,
              const AgreementGain& gain, const std::string& fix,
              const std::string& what);

// An answer that changes nothing.
Answer Said(Finding finding);

// As the camera says, or twice its principal point [px].
double ImageWidth(const Camera& camera);
double ImageHeight(const Camera& camera);

// Views whose left and right are exchanged against most of the others', in the
// frames of `seen`: one a view, with what exchanging them gains over the pairs
// of which one view is among them, and the people (ideal px) as they then are.
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

// The flag that exchanges these views'.
std::string ExchangeSidesFlag(const std::vector<char>& views,
                              const std::vector<std::string>& names);

// Of detections.mirror_px: an axis, 'x' or 'y', and the sum of a coordinate and
// the mirrored one.
std::string MirrorText(char axis, double sum_px);
// The flag that mirrors views back: such a text a view, empty where it stays.
std::string MirrorFlag(const std::vector<std::string>& mirrors,
                       const std::vector<std::string>& names);
// The texts for images of these cameras whose y counts from the bottom.
std::vector<std::string> FromTheBottom(const CameraRig& cameras);

// Of people in 3D, how many have their noses behind the shoulders: their left
// and right are exchanged, or their world is a mirror image.
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

// Whether nearly all people stand on their heads in the images. With noses
// behind the shoulders, y counts from the bottom; images that are turned leave
// noses where they are.
bool StandOnHeads(const DetectionSequence& seen);

// Left and right of these views.
void ExchangeSides(const std::vector<char>& views,
                   DetectionSequence* detections);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_HYPOTHESIS_H_
