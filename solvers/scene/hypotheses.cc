// The list of hypotheses, and those that need few words.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "core/evaluation/statistics.h"
#include "solvers/scene/clock_search.h"
#include "solvers/scene/hypothesis.h"
#include "solvers/scene/plausible.h"
#include "solvers/scene/readings.h"
#include "solvers/scene/view_checks.h"

namespace kinegraph {
namespace {

// Of what brings views together.
Finding Found(const char* kind, const std::string& camera,
              const AgreementGain& gain, const std::string& fix,
              const std::string& what) {
  return {kind,
          camera,
          gain.sureness(),
          gain.before.mean_px(),
          gain.after.mean_px(),
          fix,
          what + Format("; agreement %.2f instead of %.2f", gain.after.score(),
                        gain.before.score())};
}

// An answer that changes nothing.
Answer Said(Finding finding) {
  Answer answer;
  answer.findings.push_back(std::move(finding));
  return answer;
}

// ---- Files ----

// Frames too far apart to follow anybody.
std::optional<Answer> AskForGaps(const SetUp& set_up) {
  const std::vector<DetectionFrame>& frames = set_up.input.detections.frames;
  std::vector<double> gaps_s;
  for (size_t k = 1; k < frames.size(); ++k) {
    gaps_s.push_back(ToSeconds(frames[k].time - frames[k - 1].time));
  }
  if (gaps_s.empty()) return std::nullopt;
  const double gap_s = Quantile(std::move(gaps_s), 0.5);
  if (gap_s <= kLongestGapS) return std::nullopt;
  return Said({"frame_rate", "", 0.95, 0.0, 0.0,
               "--set=input.independent_frames=true",
               Format("%.3g s lie between two frames: nothing there is motion, "
                      "unless input.frame_rate is wrong",
                      gap_s)});
}

// Share of the joints that lie elsewhere in the other picture; nullopt where
// the pictures show other people.
std::optional<double> ChangedShare(const ViewDetections& a,
                                   const ViewDetections& b) {
  if (a.detections.empty() || a.detections.size() != b.detections.size()) {
    return std::nullopt;
  }
  double changed = 0.0;
  double all = 0.0;
  for (size_t d = 0; d < a.detections.size(); ++d) {
    const auto& one = a.detections[d].joints;
    const auto& other = b.detections[d].joints;
    for (size_t j = 0; j < one.size(); ++j) {
      if (!one[j].found && !other[j].found) continue;
      all += 1.0;
      changed +=
          one[j].found != other[j].found || one[j].px != other[j].px ? 1 : 0;
    }
  }
  if (all == 0.0) return std::nullopt;
  return changed / all;
}

// Pictures that come twice: a detector says the same to the last digit. Where
// detections are whole pixels and people stand, that is so by chance: the
// picture before must have differed in nearly every joint.
std::optional<Finding> RepeatsOf(const SetUp& set_up, size_t view) {
  const std::vector<DetectionFrame>& frames = set_up.input.detections.frames;
  constexpr double kMoving = 0.8;
  constexpr double kLeastShare = 0.01;
  int64_t repeats = 0;
  int64_t pairs = 0;
  int64_t first = -1;
  double last_change = 0.0;
  for (size_t k = 1; k < frames.size(); ++k) {
    const auto change =
        ChangedShare(frames[k - 1].views[view], frames[k].views[view]);
    if (!change.has_value()) continue;
    ++pairs;
    if (*change > 0.0) {
      last_change = *change;
    } else if (last_change >= kMoving) {
      if (first < 0) first = frames[k].frame;
      ++repeats;
    }
  }
  if (repeats == 0 ||
      static_cast<double>(repeats) < kLeastShare * static_cast<double>(pairs)) {
    return std::nullopt;
  }
  return Finding{
      "frames",
      set_up.CameraName(view),
      0.9,
      0.0,
      0.0,
      "take the repeated pictures out, or give the view's own rate "
      "(input.view_frame_rate)",
      Format("%.0f of %.0f pictures repeat the one before, the first in "
             "frame %.0f",
             static_cast<double>(repeats), static_cast<double>(pairs),
             static_cast<double>(first))};
}

std::optional<Answer> AskForRepeats(const SetUp& set_up) {
  Answer answer;
  for (size_t v = 0; v < set_up.cameras.size(); ++v) {
    if (auto repeats = RepeatsOf(set_up, v)) {
      answer.findings.push_back(*std::move(repeats));
    }
  }
  return answer;
}

// Views that share no frame with the others.
std::optional<Answer> AskForFrameRanges(const SetUp& set_up) {
  const std::vector<ShownFrames> shown = FramesShown(set_up.detections);
  const std::vector<int64_t> offsets = FrameOffsets(shown);
  if (offsets.empty()) return std::nullopt;
  const auto range = [&](size_t v) {
    return " " + set_up.ViewName(v) + " " + std::to_string(shown[v].first) +
           ".." + std::to_string(shown[v].last);
  };
  std::string others;
  std::string keys;
  for (size_t v = 0; v < shown.size(); ++v) {
    if (offsets[v] == 0) {
      others += range(v);
      continue;
    }
    keys += (keys.empty() ? "" : ";") +
            ("input.view_frame_offset." + set_up.ViewName(v)) + "=" +
            std::to_string(offsets[v]);
  }
  Answer answer;
  for (size_t v = 0; v < shown.size(); ++v) {
    if (offsets[v] == 0) continue;
    answer.findings.push_back(
        {"frame_range", set_up.CameraName(v), 0.95, 0.0, 0.0,
         "'--set=" + keys + "'",
         "it shares no frame with the others:" + range(v) + " against" +
             others +
             "; where they begin together its numbers are too high by " +
             std::to_string(offsets[v])});
  }
  answer.detections = WithFrameOffsets(set_up.detections, offsets);
  return answer;
}

// ---- Views with one calibration ----

// The one that agrees less with the other views has another one's calibration.
// It takes no part in what follows, else a clock or a turn would be made up for
// it.
std::optional<Answer> AskForTwins(const SetUp& set_up) {
  const auto alike = [&](size_t a, size_t b) {
    const Camera& one = set_up.cameras[a];
    const Camera& other = set_up.cameras[b];
    // Nobody mounts two cameras within a millimetre, looking one way.
    return set_up.strangers.count(a) + set_up.strangers.count(b) == 0 &&
           (one.centre() - other.centre()).norm() <= 1e-3 &&
           (one.R() - other.R()).cwiseAbs().maxCoeff() <= 1e-4;
  };
  for (size_t a = 0; a < set_up.cameras.size(); ++a) {
    for (size_t b = a + 1; b < set_up.cameras.size(); ++b) {
      if (!alike(a, b)) continue;
      const double score_a = set_up.ScoreWithOthers(a);
      const double score_b = set_up.ScoreWithOthers(b);
      const size_t wrong = score_a < score_b ? a : b;
      Answer answer = Said(
          {"never_matched", set_up.CameraName(wrong), 0.9, 0.0, 0.0,
           "--without_cameras=" + set_up.CameraName(wrong),
           "its calibration equals that of " +
               set_up.CameraName(wrong == a ? b : a) +
               Format(", and it agrees to %.2f with the other views instead of "
                      "%.2f",
                      std::min(score_a, score_b), std::max(score_a, score_b))});
      answer.strangers = {wrong};
      return answer;
    }
  }
  return std::nullopt;
}

// ---- Readings, which compete ----

// Views that agree so well can gain nothing from another reading.
bool AgreeAlready(const SetUp& set_up) {
  constexpr double kSoundEnough = 0.85;
  return set_up.agreement.score() >= kSoundEnough;
}

// A video that was scaled or cropped before people were detected.
std::optional<Answer> AskForOtherImage(const SetUp& set_up) {
  if (AgreeAlready(set_up)) return std::nullopt;
  const auto image = FindOtherImage(set_up.cameras, set_up.raw, set_up.frames);
  if (!image.has_value()) return std::nullopt;
  const Camera& camera = set_up.cameras[image->view];
  // Cameras that are turned by little look alike; by a tenth of the image
  // nobody turns one without moving it.
  const double share = image->offset_px.norm() / ImageWidth(camera);
  const bool either = !image->scaled() && share <= 0.1;
  std::string what;
  if (either) {
    what = Format(
        "its image fits moved by (%+.0f, %+.0f) px: it was cropped or turned",
        -image->offset_px.x(), -image->offset_px.y());
  } else if (image->scaled()) {
    what = Format(
        "its video is %.4g times as large as the calibration's "
        "image",
        image->scale);
  }
  if (image->cropped() && !either) {
    what += (what.empty() ? "its video" : ", and") +
            Format(" begins at pixel (%.0f, %.0f) of ", image->offset_px.x(),
                   image->offset_px.y()) +
            (image->scaled() ? "that" : "the calibration's image");
  }
  const char* kind = either             ? "shift"
                     : image->cropped() ? "crop"
                                        : "image_size";
  Answer answer = Said(Found(kind, set_up.CameraName(image->view), image->gain,
                             kUseCorrected, what));
  answer.cameras = set_up.cameras;
  (*answer.cameras)[image->view] = WithImage(camera, *image);
  answer.score = set_up.ScoreOf(*answer.cameras, set_up.detections);
  return answer;
}

std::optional<Answer> AskForOtherRate(const SetUp& set_up) {
  if (AgreeAlready(set_up)) return std::nullopt;
  const double usual_hz = set_up.input.frame_rate_hz;
  const auto rate =
      FindOtherRate(set_up.cameras, set_up.ideal, set_up.detections, usual_hz);
  if (!rate.has_value()) return std::nullopt;
  const std::string& view = set_up.ViewName(rate->view);
  std::string keys =
      "input.view_frame_rate." + view + "=" + Format("%.4g", rate->rate_hz);
  // Keys take whole frames; where that leaves a part, all count from 0.
  const bool whole = rate->offset == std::round(rate->offset);
  const int64_t first = set_up.detections.frames.front().frame;
  for (size_t v = 0; rate->offset != 0.0 && v < set_up.cameras.size(); ++v) {
    if (whole && v != rate->view) continue;
    keys += ";input.view_frame_offset." + set_up.ViewName(v) + "=" +
            std::to_string(whole ? std::llround(rate->offset) : first);
  }
  Answer answer =
      Said(Found("view_rate", set_up.CameraName(rate->view), rate->gain,
                 rate->offset == 0.0 ? "--set=" + keys : "'--set=" + keys + "'",
                 Format("its files count at %.4g Hz, the others' at %.4g",
                        rate->rate_hz, usual_hz)));
  answer.detections = WithViewRate(set_up.detections, rate->view,
                                   rate->rate_hz / usual_hz, rate->offset);
  answer.score = set_up.ScoreOf(set_up.cameras, *answer.detections);
  return answer;
}

// What a reading of the file changes, each with the words for it.
class ReadingWords {
 public:
  ReadingWords(const SetUp& set_up, const ReadingScore& as_read,
               const ReadingScore& score, size_t alike)
      : set_up_(set_up), as_read_(as_read), score_(score), alike_(alike) {}

  void AddTo(std::vector<Finding>* findings) const {
    const Reading& reading = score_.reading;
    if (reading.pose != PoseReading::kAsRead) {
      findings->push_back(
          Said("convention", "", kUseCorrected,
               std::string("the poses fit as: ") + Describe(reading.pose)));
    }
    if (reading.image_scale != 1.0) {
      findings->push_back(Said("intrinsics", "", kUseCorrected,
                               Format("the camera matrix fits multiplied by "
                                      "%.4g",
                                      reading.image_scale)));
    }
    AddImages(findings);
    AddSwaps(findings);
  }

 private:
  Finding Said(const char* kind, const std::string& camera,
               const std::string& fix, const std::string& what) const {
    Finding finding =
        Found(kind, camera, {as_read_.agreement, score_.agreement}, fix, what);
    finding.confidence = Shared(finding.confidence, alike_);
    return finding;
  }

  void AddImages(std::vector<Finding>* findings) const {
    const std::vector<ImageReading>& images = score_.reading.images;
    const bool all_alike = std::all_of(
        images.begin(), images.end(),
        [&](ImageReading image) { return image == images.front(); });
    for (size_t v = 0; v < images.size(); ++v) {
      if (images[v] == ImageReading::kAsRead) continue;
      findings->push_back(
          Said("image", all_alike ? "" : set_up_.CameraName(v),
               images[v] == ImageReading::kMirrored
                   ? "mirror the images back before people are detected"
                   : kUseCorrected,
               std::string("the images were ") + Describe(images[v])));
      if (all_alike) return;
    }
  }

  void AddSwaps(std::vector<Finding>* findings) const {
    const std::vector<int>& cameras = score_.reading.camera_of_view;
    std::string map;
    std::string names;
    for (size_t v = 0; v < cameras.size(); ++v) {
      const auto camera = static_cast<size_t>(cameras[v]);
      if (camera == v) continue;
      const std::string& view = set_up_.ViewName(v);
      map += (map.empty() ? "'--set=cameras.map." : ";cameras.map.") + view +
             "=" + set_up_.CameraName(camera);
      names += (names.empty() ? "" : ", ") + view + " is seen by " +
               set_up_.CameraName(camera);
    }
    if (!map.empty()) {
      findings->push_back(Said("swapped_views", "", map + "'", names));
    }
  }

  const SetUp& set_up_;
  const ReadingScore& as_read_;
  const ReadingScore& score_;
  size_t alike_;
};

// The detections of a view that was mirrored, mirrored back.
void MirrorBack(const Camera& camera, size_t view, DetectionSequence* all) {
  for (DetectionFrame& frame : all->frames) {
    for (Detection& detection : frame.views[view].detections) {
      for (Keypoint& joint : detection.joints) {
        joint.px.x() = ImageWidth(camera) - 1.0 - joint.px.x();
      }
    }
  }
}

// Conventions, sizes, turned images and exchanged views.
std::optional<Answer> AskForOtherReading(const SetUp& set_up) {
  if (AgreeAlready(set_up)) return std::nullopt;
  const ReadingSearch search =
      SearchReadings(set_up.cameras, set_up.raw, set_up.frames);
  if (search.better.empty()) return std::nullopt;
  Answer answer;
  for (const ReadingScore& score : search.better) {
    ReadingWords(set_up, search.as_read, score, search.better.size())
        .AddTo(&answer.findings);
  }
  const Reading& reading = search.better.front().reading;
  answer.score = search.better.front().score();
  answer.cameras = CamerasOf(set_up.cameras, reading);
  for (size_t v = 0; v < set_up.cameras.size(); ++v) {
    Camera& camera = (*answer.cameras)[v];
    if (auto seeing = Seeing(camera, reading.images[v])) {
      camera = *std::move(seeing);
      continue;
    }
    if (!answer.detections.has_value()) {
      answer.detections = set_up.detections;
      answer.notes.emplace_back(
          "no camera sees mirrored images: the corrected calibration holds "
          "for the images mirrored back");
    }
    MirrorBack(camera, v, &*answer.detections);
  }
  return answer;
}

std::optional<Answer> AskForSides(const SetUp& set_up) {
  const auto sides =
      FindExchangedSides(set_up.cameras, set_up.ideal, set_up.frames,
                         set_up.detections.header.skeleton);
  if (!sides.has_value()) return std::nullopt;
  std::string names;
  size_t count = 0;
  for (size_t v = 0; v < sides->views.size(); ++v) {
    if (!sides->views[v]) continue;
    names += (count++ == 0 ? "\"" : ",\"") + set_up.ViewName(v) + "\"";
  }
  const std::string fix = "'--set=detections.exchange_sides=[" + names + "]'";
  Answer answer;
  for (size_t v = 0; v < sides->views.size(); ++v) {
    if (!sides->views[v]) continue;
    if (count == sides->views.size()) {
      answer = Said({"sides", "", 0.9, 0.0, 0.0, fix,
                     Format("left and right are exchanged: noses lie behind "
                            "the shoulders in %.0f of %.0f people",
                            sides->backwards, sides->looked_at)});
      break;
    }
    answer.findings.push_back(Found("sides", set_up.CameraName(v), sides->gain,
                                    fix, "left and right are exchanged in it"));
  }
  answer.detections = set_up.detections;
  ExchangeSides(sides->views, &*answer.detections);
  answer.score = set_up.ScoreOf(set_up.cameras, *answer.detections);
  return answer;
}

std::optional<Answer> AskForLags(const SetUp& set_up) {
  const ClockSearch clocks =
      SearchClocks(set_up.cameras, set_up.ideal, set_up.LongestLag());
  if (!clocks.found()) return std::nullopt;
  // What hardly helps is left to the matches, which know single frames.
  constexpr double kLeastSure = 0.5;
  const double sureness =
      AgreementGain::Sureness(clocks.moved.gain(), clocks.all.after.score());
  if (sureness < kLeastSure) return std::nullopt;
  Answer answer;
  for (size_t v = 0; v < set_up.cameras.size(); ++v) {
    const int lag = clocks.lag_frames[v];
    if (lag == 0) continue;
    answer.findings.push_back(
        {"clock_offset", set_up.CameraName(v), sureness,
         clocks.all.before.mean_px(), clocks.all.after.mean_px(),
         "--set=cameras.refine_clock=true",
         Format("its frames agree best with those of the first view %+.0f "
                "frames away (%+.3f s)",
                static_cast<double>(lag), -lag / set_up.input.frame_rate_hz)});
  }
  answer.score = clocks.all.after.score();
  answer.detections = Realigned(set_up.detections, clocks.lag_frames);
  return answer;
}

// ---- The world ----

// No reading and no clock brings the views together.
std::optional<Answer> AskForAnotherRoom(const SetUp& set_up) {
  // Sound takes agree to 0.5 and more; people of two views who are paired
  // without any relation agree to 0.1 or so (docs/doctor.md).
  constexpr double kUnrelated = 0.2;
  const PairAgreement& as_read = set_up.agreement;
  if (set_up.readings_changed > 0 || as_read.score() > kUnrelated) {
    return std::nullopt;
  }
  return Said({"never_matched", "", 0.8, as_read.mean_px(), as_read.mean_px(),
               kCalibrateAnew,
               Format("people seen by two views agree to %.2f of 1, and no "
                      "other reading of the calibration and no lag brings them "
                      "together: it may be of another set-up, or of other "
                      "images than the detections",
                      as_read.score())});
}

std::string UnitFix(const DoctorInput& input, double units_per_metre) {
  if (!input.unit_can_be_set) return kUseCorrected;
  for (const auto& [units, name] :
       {std::pair{1.0, "m"}, {100.0, "cm"}, {1000.0, "mm"}}) {
    if (std::abs(units_per_metre / units - 1.0) < 1e-9) {
      return std::string("--set=cameras.unit=") + name;
    }
  }
  return kUseCorrected;
}

CameraRig Rescaled(CameraRig cameras, double factor) {
  for (Camera& camera : cameras) {
    CameraParameters parameters = camera.parameters();
    parameters.t *= factor;
    camera = Camera(std::move(parameters));
  }
  return cameras;
}

std::optional<Answer> AskForUnit(const SetUp& set_up) {
  const Stature stature = StatureOf(set_up.cameras, set_up.ideal, set_up.frames,
                                    set_up.detections.header.skeleton);
  Answer answer;
  if (stature.count < kEnoughStatures) {
    answer.notes.emplace_back("too few whole bodies to tell the unit");
    return answer;
  }
  answer.notes.push_back(
      Format("people are %.3g m tall (median of %.0f bodies)", stature.median_m,
             stature.count));
  answer.stature_m = stature.median_m;
  const auto plausible = [](double height_m) {
    return height_m >= kMinHeight && height_m <= kMaxHeight;
  };
  if (plausible(stature.median_m)) return answer;
  const double px = set_up.agreement.mean_px();
  const std::string found =
      Format("people would be %.3g m tall", stature.median_m);
  for (const double factor : {0.001, 0.01, 0.1, 10.0, 100.0, 1000.0}) {
    const double height_m = stature.median_m * factor;
    if (!plausible(height_m)) continue;
    answer.findings.push_back(
        {"unit", "", 0.95, px, px,
         UnitFix(set_up.input, set_up.input.units_per_metre / factor),
         found + Format("; lengths times %.4g make them %.2f m", factor,
                        height_m)});
    answer.cameras = Rescaled(set_up.cameras, factor);
    return answer;
  }
  // No unit explains it: a board whose squares were given wrongly.
  answer.findings.push_back(
      {"unit", "", 0.5, px, px,
       "measure a length in the room and scale the calibration",
       found + " and no unit makes them 0.5 to 2.3 m"});
  return answer;
}

// ---- With the tracker's matches ----

// Views that are hardly ever matched. The few matches that they have are wrong,
// and take no part in what follows.
std::optional<Answer> AskForStrangers(const SetUp& set_up) {
  Answer answer;
  for (size_t v = 0; v < set_up.cameras.size(); ++v) {
    const auto all = static_cast<double>(set_up.segments.detections[v]);
    const auto matched = static_cast<double>(set_up.segments.matched[v]);
    if (all < kEnoughDetections || matched > kStrangerShare * all) continue;
    answer.strangers.push_back(v);
    answer.findings.push_back(
        {"never_matched", set_up.CameraName(v), 0.9, 0.0, 0.0,
         "--without_cameras=" + set_up.CameraName(v),
         Format("%.0f of %.0f detections are matched where two other views "
                "match somebody",
                matched, all)});
  }
  return answer;
}

// People who are faster than any: the frame rate is less than told.
std::optional<Answer> AskForSpeed(const SetUp& set_up) {
  // A recording that is told as too short by its rate has few stretches.
  constexpr size_t kEnough = 20;
  const Skeleton& skeleton = set_up.detections.header.skeleton;
  std::vector<double> speeds_mps;
  for (const MotionSegment& segment : set_up.segments.segments) {
    const std::string& name =
        skeleton.joints()[static_cast<size_t>(segment.joint)];
    if (name != "l_hip" && name != "r_hip") continue;
    speeds_mps.push_back(segment.state.segment<3>(3).norm());
  }
  if (speeds_mps.size() < kEnough) return std::nullopt;
  const double speed_mps = Quantile(std::move(speeds_mps), 0.95);
  if (speed_mps <= kMaxBodySpeed) return std::nullopt;
  return Said({"frame_rate", "", 0.8, 0.0, 0.0, "the right input.frame_rate",
               Format("people move at %.1f m/s at %.4g Hz", speed_mps,
                      set_up.input.frame_rate_hz)});
}

std::optional<Answer> AskForLens(const SetUp& set_up) {
  CameraRig bare;
  bool any = false;
  for (const Camera& camera : set_up.cameras) {
    CameraParameters parameters = camera.parameters();
    any = any || parameters.lens != nullptr;
    parameters.lens = nullptr;
    bare.emplace_back(std::move(parameters));
  }
  if (!any) return std::nullopt;
  const FitGain gain = CompareFits(
      set_up.Fit(),
      MeasureFit(bare, set_up.segments,
                 std::vector<CameraChange>(bare.size(), CameraChange::Zero()),
                 set_up.options.bundle.segments));
  // Lenses of a few coefficients that hardly bend anything fit either way.
  if (!gain.is_enough()) return std::nullopt;
  Answer answer =
      Said({"lens", "", 0.9, gain.before_px, gain.after_px,
            "--set=cameras.ignore_distortion=true",
            "the detections fit better without the lens: their images were "
            "undistorted, or the lens is another one's"});
  answer.cameras = std::move(bare);
  return answer;
}

}  // namespace

const std::vector<Hypothesis>& Hypotheses() {
  constexpr int kMostTwins = 8;
  constexpr int kMostJumps = 5;
  constexpr int kMostReadings = 3;
  static const std::vector<Hypothesis> kAll = {
      {"gaps between frames", Stage::kFiles, AskForGaps},
      {"repeated pictures", Stage::kFiles, AskForRepeats},
      {"frame ranges", Stage::kFiles, AskForFrameRanges},
      {"one calibration twice", Stage::kTwins, AskForTwins, kMostTwins},
      {"image scaled or cropped", Stage::kReadings, AskForOtherImage,
       kMostReadings},
      {"another rate", Stage::kReadings, AskForOtherRate, kMostReadings},
      {"another reading", Stage::kReadings, AskForOtherReading, kMostReadings},
      {"left and right", Stage::kReadings, AskForSides, kMostReadings},
      {"clocks, whole frames", Stage::kReadings, AskForLags},
      {"another room", Stage::kWorld, AskForAnotherRoom},
      {"unit", Stage::kWorld, AskForUnit},
      {"a camera that was moved", Stage::kWorld, AskForBreak},
      {"views of strangers", Stage::kStrangers, AskForStrangers},
      {"lost pictures", Stage::kJumps, AskForJump, kMostJumps},
      {"people too fast", Stage::kMatches, AskForSpeed},
      {"lens", Stage::kMatches, AskForLens},
      {"residuals", Stage::kMatches, AskResiduals},
  };
  return kAll;
}

}  // namespace kinegraph
