#include "solvers/scene/doctor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>
#include <utility>

#include "core/evaluation/statistics.h"
#include "solvers/scene/clock_jumps.h"
#include "solvers/scene/clock_search.h"
#include "solvers/scene/consistency.h"
#include "solvers/scene/fit_terms.h"
#include "solvers/scene/readings.h"
#include "solvers/scene/refine.h"

namespace kinegraph {
namespace {

constexpr double kDegreesPerRadian = 57.29577951308232;
constexpr double kMinConfidence = 0.3;
// What is written beside the report, and how to use it.
const char* const kUseCorrected = "--cameras=cameras.json of this report";

std::string Format(const char* format, double a, double b = 0.0,
                   double c = 0.0) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), format, a, b, c);
  return text.data();
}

// Sure things are 0.95, doubtful ones less, nothing is 1.
double Shared(double confidence, size_t count) {
  return std::min(0.95, confidence) / static_cast<double>(count);
}

class Doctor {
 public:
  Doctor(const DoctorInput& input, const DoctorOptions& options)
      : input_(input),
        options_(options),
        cameras_(input.cameras),
        detections_(input.detections) {}

  Diagnosis Run() {
    LookAtFrames();
    raw_ = PeopleOfViews(detections_, kMinConfidence);
    frames_ = FramesToLookAt(raw_, options_.frames_to_look_at);
    if (frames_.empty() || cameras_.size() < 2) {
      diagnosis_.notes.push_back(
          "no frame in which two views see a person: nothing can be said");
      diagnosis_.cameras = cameras_;
      diagnosis_.sound = diagnosis_.findings.empty();
      return diagnosis_;
    }
    LookForTwins();
    LookAtReadings();
    LookAtUnit();
    if (input_.match) LookAtMatches();
    // The corrected file gives each view the right camera under the name that
    // the view is paired with.
    for (size_t v = 0; v < cameras_.size(); ++v) {
      CameraParameters parameters = cameras_[v].parameters();
      parameters.name = NameOf(v);
      cameras_[v] = Camera(parameters);
    }
    diagnosis_.cameras = cameras_;
    diagnosis_.sound = diagnosis_.findings.empty();
    return diagnosis_;
  }

 private:
  std::string NameOf(size_t view) const { return input_.cameras[view].name(); }

  void Add(Finding finding) {
    diagnosis_.findings.push_back(std::move(finding));
  }

  // ---- Frames and rates ----

  void LookAtFrames() {
    std::vector<double> gaps;
    for (size_t k = 1; k < detections_.frames.size(); ++k) {
      gaps.push_back(ToSeconds(detections_.frames[k].time -
                               detections_.frames[k - 1].time));
    }
    if (gaps.empty()) return;
    const double gap_s = Quantile(gaps, 0.5);
    // Nothing that people do can be followed over a second.
    constexpr double kLongestGapS = 1.0;
    if (gap_s > kLongestGapS) {
      Add({"frame_rate", "", 0.95, 0.0, 0.0,
           "--set=input.independent_frames=true, or the right "
           "input.frame_rate",
           Format("%.3g s lie between two frames: nothing there is motion",
                  gap_s)});
    }
    for (size_t v = 0; v < cameras_.size(); ++v) LookForRepeats(v);
  }

  // Share of the joints that lie elsewhere in the other picture; nullopt where
  // the pictures show other people.
  static std::optional<double> ChangedShare(const ViewDetections& a,
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
  void LookForRepeats(size_t view) {
    constexpr double kMoving = 0.8;
    constexpr double kLeastShare = 0.01;
    int64_t repeats = 0;
    int64_t pairs = 0;
    int64_t first = -1;
    double last_change = 0.0;
    for (size_t k = 1; k < detections_.frames.size(); ++k) {
      const auto change = ChangedShare(detections_.frames[k - 1].views[view],
                                       detections_.frames[k].views[view]);
      if (!change.has_value()) continue;
      ++pairs;
      if (*change > 0.0) {
        last_change = *change;
      } else if (last_change >= kMoving) {
        if (first < 0) first = detections_.frames[k].frame;
        ++repeats;
      }
    }
    if (repeats == 0 || static_cast<double>(repeats) <
                            kLeastShare * static_cast<double>(pairs)) {
      return;
    }
    Add({"frames", NameOf(view), 0.9, 0.0, 0.0,
         "take the repeated pictures out, or give the view's own rate "
         "(input.view_frame_rate)",
         Format("%.0f of %.0f pictures repeat the one before, the first in "
                "frame %.0f",
                static_cast<double>(repeats), static_cast<double>(pairs),
                static_cast<double>(first))});
  }

  // ---- Without tracking ----

  // Two views with one calibration: the one that agrees less with the other
  // views has another one's. It takes no part in what follows, else a clock or
  // a turn would be made up for it.
  void LookForTwins() {
    for (size_t a = 0; a < cameras_.size(); ++a) {
      for (size_t b = a + 1; b < cameras_.size(); ++b) {
        // Nobody mounts two cameras within a millimetre, looking one way.
        if ((cameras_[a].centre() - cameras_[b].centre()).norm() > 1e-3 ||
            (cameras_[a].R() - cameras_[b].R()).cwiseAbs().maxCoeff() > 1e-4) {
          continue;
        }
        const bool first = AgreementWithOthers(a) < AgreementWithOthers(b);
        AddTwin(first ? a : b, first ? b : a);
      }
    }
  }

  double AgreementWithOthers(size_t view) const {
    const std::vector<ViewPeople> ideal = Ideal();
    PairAgreement all;
    for (size_t v = 0; v < cameras_.size(); ++v) {
      if (v == view) continue;
      all.Add(AgreementOf(cameras_[v], ideal[v], cameras_[view], ideal[view],
                          frames_));
    }
    return all.score();
  }

  void AddTwin(size_t wrong, size_t right) {
    if (!strangers_.insert(wrong).second) return;
    Add({"never_matched", NameOf(wrong), 0.9, 0.0, 0.0,
         "--without_cameras=" + NameOf(wrong) + ", or calibrate it anew",
         "its calibration equals that of " + NameOf(right) +
             Format(", and it agrees to %.2f with the other views instead of "
                    "%.2f",
                    AgreementWithOthers(wrong), AgreementWithOthers(right))});
    for (DetectionFrame& frame : detections_.frames) {
      frame.views[wrong].detections.clear();
    }
    raw_ = PeopleOfViews(detections_, kMinConfidence);
    frames_ = FramesToLookAt(raw_, options_.frames_to_look_at);
  }

  std::vector<ViewPeople> Ideal() const {
    std::vector<ViewPeople> ideal;
    for (size_t v = 0; v < raw_.size(); ++v) {
      ideal.push_back(Undistorted(raw_[v], cameras_[v]));
    }
    return ideal;
  }

  int LongestLag() const {
    return static_cast<int>(options_.longest_lag_s * input_.frame_rate_hz);
  }

  void LookAtReadings() {
    const ReadingSearch search = SearchReadings(cameras_, raw_, frames_);
    diagnosis_.notes.push_back(
        Format("people seen by two views agree to %.2f of 1 as the "
               "calibration is read (%.1f px from each other's epipolar lines)",
               search.as_read.score, search.as_read.distance_px));
    const ClockSearch clocks = SearchClocks(cameras_, Ideal(), LongestLag());
    const double reading_score =
        search.better.empty() ? 0.0 : search.better.front().score;
    if (clocks.found() && clocks.score_after > reading_score) {
      TakeClocks(clocks);
      return;
    }
    if (search.better.empty()) {
      LookForAnotherRoom(search);
      return;
    }
    TakeReading(search);
    // A clock may be wrong as well.
    const ClockSearch then = SearchClocks(cameras_, Ideal(), LongestLag());
    if (then.found()) TakeClocks(then);
  }

  // No reading and no clock brings the views together.
  void LookForAnotherRoom(const ReadingSearch& search) {
    // Sound takes agree to 0.5 and more; people of two views who are paired
    // without any relation agree to 0.1 or so (docs/doctor.md).
    constexpr double kUnrelated = 0.2;
    if (search.as_read.score > kUnrelated) return;
    Add({"never_matched", "", 0.8, search.as_read.distance_px,
         search.as_read.distance_px,
         "calibrate anew, or check that calibration and detections are of one "
         "take",
         Format("people seen by two views agree to %.2f of 1, and no other "
                "reading of the calibration and no lag brings them together: "
                "it may be of another set-up",
                search.as_read.score)});
  }

  void TakeClocks(const ClockSearch& clocks) {
    for (size_t v = 0; v < cameras_.size(); ++v) {
      const int lag = clocks.lag_frames[v];
      if (lag == 0) continue;
      const double offset_s = -lag / input_.frame_rate_hz;
      Add({"clock_offset", NameOf(v),
           Shared(Sureness(clocks.score_before, clocks.score_after), 1),
           clocks.before_px, clocks.after_px, "--set=cameras.refine_clock=true",
           Format("its frames agree best with those of the first view %+.0f "
                  "frames away (%+.3f s)",
                  static_cast<double>(lag), offset_s)});
    }
    detections_ = Realigned(detections_, clocks.lag_frames);
    raw_ = PeopleOfViews(detections_, kMinConfidence);
    frames_ = FramesToLookAt(raw_, options_.frames_to_look_at);
  }

  // How sure a change is that brings agreement from `before` to `after`.
  static double Sureness(double before, double after) {
    const double gain = std::min(1.0, (after - before) / 0.15);
    const double reach = std::min(1.0, after / 0.5);
    return 0.95 * gain * reach;
  }

  void TakeReading(const ReadingSearch& search) {
    for (const ReadingScore& score : search.better) {
      AddReading(search.as_read, score, search.better.size());
    }
    const Reading& reading = search.better.front().reading;
    CameraRig rig = CamerasOf(cameras_, reading);
    bool mirrored = false;
    for (size_t v = 0; v < rig.size(); ++v) {
      if (const auto seeing = Seeing(rig[v], reading.images[v])) {
        rig[v] = *seeing;
      } else {
        mirrored = true;
        MirrorBack(v, rig[v]);
      }
    }
    cameras_ = std::move(rig);
    if (mirrored) {
      diagnosis_.notes.push_back(
          "no camera sees mirrored images: the corrected calibration holds "
          "for the images mirrored back");
    }
    raw_ = PeopleOfViews(detections_, kMinConfidence);
  }

  void MirrorBack(size_t view, const Camera& camera) {
    const double width =
        camera.width_px() > 0 ? camera.width_px() : 2.0 * camera.K()(0, 2);
    for (DetectionFrame& frame : detections_.frames) {
      for (Detection& detection : frame.views[view].detections) {
        for (Keypoint& joint : detection.joints) {
          joint.px.x() = width - joint.px.x();
        }
      }
    }
  }

  void AddReading(const ReadingScore& before, const ReadingScore& after,
                  size_t alike) {
    const double confidence =
        Shared(Sureness(before.score, after.score), alike);
    const std::string agreement =
        Format("; agreement %.2f instead of %.2f", after.score, before.score);
    const Reading& reading = after.reading;
    const auto add = [&](const std::string& kind, const std::string& camera,
                         const std::string& fix, const std::string& what) {
      Add({kind, camera, confidence, before.distance_px, after.distance_px, fix,
           what + agreement});
    };
    if (reading.pose != PoseReading::kAsRead) {
      add("convention", "", kUseCorrected,
          std::string("the poses fit as: ") + Describe(reading.pose));
    }
    if (reading.image_scale != 1.0) {
      add("intrinsics", "", kUseCorrected,
          Format("the camera matrix fits multiplied by %.4g",
                 reading.image_scale));
    }
    AddImages(reading, add);
    std::string map;
    std::string names;
    for (size_t v = 0; v < reading.camera_of_view.size(); ++v) {
      const auto camera = static_cast<size_t>(reading.camera_of_view[v]);
      if (camera == v) continue;
      const std::string& view = input_.detections.header.view_names[v];
      map += (map.empty() ? "--set=cameras.map." : ";cameras.map.") + view +
             "=" + NameOf(camera);
      names +=
          (names.empty() ? "" : ", ") + view + " is seen by " + NameOf(camera);
    }
    if (!map.empty()) add("swapped_views", "", map, names);
  }

  template <typename AddFunction>
  void AddImages(const Reading& reading, const AddFunction& add) {
    const bool all_alike = std::all_of(
        reading.images.begin(), reading.images.end(),
        [&](ImageReading image) { return image == reading.images.front(); });
    for (size_t v = 0; v < reading.images.size(); ++v) {
      const ImageReading image = reading.images[v];
      if (image == ImageReading::kAsRead) continue;
      const bool mirrored = image == ImageReading::kMirrored;
      add("image", all_alike ? "" : NameOf(v),
          mirrored ? "mirror the images back before people are detected"
                   : kUseCorrected,
          std::string("the images were ") + Describe(image));
      if (all_alike) return;
    }
  }

  // ---- Unit ----

  void LookAtUnit() {
    const Stature stature =
        StatureOf(cameras_, Ideal(), frames_, detections_.header.skeleton);
    constexpr int kEnough = 20;
    if (stature.count < kEnough) {
      diagnosis_.notes.push_back("too few whole bodies to tell the unit");
      return;
    }
    diagnosis_.notes.push_back(
        Format("people are %.3g m tall (median of %.0f bodies)",
               stature.median_m, stature.count));
    constexpr double kSmallest = 1.2;
    constexpr double kTallest = 2.2;
    if (stature.median_m >= kSmallest && stature.median_m <= kTallest) return;
    for (const double factor : {0.001, 0.01, 0.1, 10.0, 100.0, 1000.0}) {
      const double height = stature.median_m * factor;
      if (height < kSmallest || height > kTallest) continue;
      Finding finding{"unit", "", 0.95, stature.median_m, height, "", ""};
      finding.before_px = finding.after_px = MeanDistancePx();
      finding.fix = UnitFix(input_.units_per_metre / factor);
      finding.evidence = Format(
          "people would be %.3g m tall; lengths times %.4g make them "
          "%.2f m",
          stature.median_m, factor, height);
      Add(finding);
      Rescale(factor);
      return;
    }
    // No unit explains it: a board whose squares were given wrongly, or
    // children. A typical adult is the guess.
    constexpr double kAdult = 1.7;
    const double factor = kAdult / stature.median_m;
    Add({"unit", "", 0.5, MeanDistancePx(), MeanDistancePx(), kUseCorrected,
         Format("people would be %.3g m tall and no unit makes them 1.2 to "
                "2.2 m; if they are adults, lengths are to be multiplied by "
                "%.4g",
                stature.median_m, factor)});
    Rescale(factor);
  }

  std::string UnitFix(double units_per_metre) const {
    if (!input_.unit_can_be_set) return kUseCorrected;
    for (const auto& [units, name] :
         {std::pair{1.0, "m"}, {100.0, "cm"}, {1000.0, "mm"}}) {
      if (std::abs(units_per_metre / units - 1.0) < 1e-9) {
        return std::string("--set=cameras.unit=") + name;
      }
    }
    return kUseCorrected;
  }

  double MeanDistancePx() const {
    return AgreementOfAll(cameras_, Ideal(), frames_).mean_px();
  }

  void Rescale(double factor) {
    for (Camera& camera : cameras_) {
      CameraParameters parameters = camera.parameters();
      parameters.t *= factor;
      camera = Camera(parameters);
    }
  }

  // ---- With the tracker's matches ----

  void LookAtMatches() {
    Match();
    LookForStrangers();
    constexpr size_t kEnough = 100;
    if (segments_.segments.size() < kEnough) {
      diagnosis_.notes.push_back(
          "too few people are matched between views to look at single "
          "cameras and clocks");
      return;
    }
    LookForJumps();
    const FitError before =
        MeasureFit(cameras_, segments_, changes_, options_.bundle);
    diagnosis_.notes.push_back(Format(
        "matched joints lie %.2f px from their best place in 3D (mean, "
        "capped at 30 px), %.0f stretches of a fifth of a second",
        before.MeanPx(), static_cast<double>(segments_.segments.size())));
    LookAtSpeeds();
    LookAtLens(before);
    // A late clock of a camera that looks at one walking person is a shifted
    // image: clocks and cameras compete. What explains most goes first; the
    // other may explain what is left.
    for (int round = 0; round < 2; ++round) {
      if (!Explain()) break;
    }
    cameras_ = RefinedCameras(cameras_, changes_);
  }

  void Match() {
    const FrozenMatches matches = input_.match(cameras_, detections_);
    segments_ =
        MakeSegments(cameras_, detections_, matches, options_.bundle.segments);
    changes_.assign(cameras_.size(), CameraChange::Zero());
  }

  // Pictures that were lost, one jump after the other.
  void LookForJumps() {
    constexpr int kMostJumps = 5;
    for (int i = 0; i < kMostJumps && TakeJump(); ++i) {
    }
  }

  bool TakeJump() {
    const double frame_s = 1.0 / std::max(1.0, input_.frame_rate_hz);
    const auto jump = FindClockJump(cameras_, segments_, changes_,
                                    options_.bundle.segments, frame_s);
    if (!jump.has_value()) return false;
    const auto view = static_cast<size_t>(jump->view_idx);
    if (strangers_.count(view) > 0) return false;
    const auto& frames = detections_.frames;
    const TimeNs middle =
        frames.front().time + (frames.back().time - frames.front().time) / 2;
    const auto at = std::lower_bound(
        frames.begin(), frames.end(), middle + FromSeconds(jump->at_s),
        [](const DetectionFrame& f, TimeNs time) { return f.time < time; });
    const auto from = static_cast<int64_t>(at - frames.begin());
    const auto number = static_cast<double>(
        at == frames.end() ? frames.back().frame : at->frame);
    const double before_px =
        MeasureFit(cameras_, segments_, changes_, options_.bundle)
            .MeanPx(jump->view_idx);
    DetectionSequence moved = WithoutJump(detections_, *jump, from);
    std::swap(detections_, moved);
    SceneSegments old = segments_;
    Match();
    const double after_px =
        MeasureFit(cameras_, segments_, changes_, options_.bundle)
            .MeanPx(jump->view_idx);
    constexpr double kLeastShare = 0.05;
    if (before_px - after_px < kLeastShare * before_px) {
      std::swap(detections_, moved);
      segments_ = std::move(old);
      return false;
    }
    const double count = std::abs(jump->missing);
    Add({"frames", NameOf(view), 0.9, before_px, after_px,
         jump->missing > 0
             ? Format("give its files from about %.0f on numbers that are %.0f "
                      "higher",
                      number, count)
             : Format("take %.0f pictures out before about frame %.0f", count,
                      number),
         Format(jump->missing > 0
                    ? "%.0f pictures are missing before about frame %.0f"
                    : "%.0f pictures are too many before about frame %.0f",
                count, number) +
             Format(": its clock jumps by %+.1f +- %.1f ms", 1e3 * jump->jump_s,
                    1e3 * jump->sigma_s)});
    return true;
  }

  // People who are faster than any: the frame rate is less than told.
  void LookAtSpeeds() {
    constexpr double kFastestMps = 8.0;  // sprinters reach 10
    constexpr size_t kEnough = 50;
    std::vector<double> speeds;
    for (const Stretch& segment : segments_.segments) {
      const std::string& name =
          detections_.header.skeleton
              .joints()[static_cast<size_t>(segment.joint)];
      if (name != "l_hip" && name != "r_hip") continue;
      speeds.push_back(segment.state.segment<3>(3).norm());
    }
    if (speeds.size() < kEnough) return;
    const double speed_mps = Quantile(speeds, 0.95);
    if (speed_mps <= kFastestMps) return;
    Add({"frame_rate", "", 0.8, 0.0, 0.0, "the right input.frame_rate",
         Format("people move at %.1f m/s at %.4g Hz", speed_mps,
                input_.frame_rate_hz)});
  }

  // Views that are hardly ever matched.
  void LookForStrangers() {
    for (size_t v = 0; v < cameras_.size(); ++v) {
      const double all = static_cast<double>(segments_.detections[v]);
      const double share =
          all > 0.0 ? static_cast<double>(segments_.matched[v]) / all : 1.0;
      constexpr double kStranger = 0.2;
      constexpr double kEnough = 20.0;
      if (all < kEnough || share > kStranger) continue;
      strangers_.insert(v);
      std::string evidence = Format(
          "%.0f of %.0f detections are matched where two other views match "
          "somebody",
          static_cast<double>(segments_.matched[v]), all);
      Add({"never_matched", NameOf(v), 0.9, 0.0, 0.0,
           "--without_cameras=" + NameOf(v) + ", or calibrate it anew",
           evidence});
    }
  }

  void LookAtLens(const FitError& before) {
    CameraRig bare;
    bool any = false;
    for (const Camera& camera : cameras_) {
      CameraParameters parameters = camera.parameters();
      any = any || parameters.lens != nullptr;
      parameters.lens = nullptr;
      bare.emplace_back(parameters);
    }
    if (!any) return;
    const FitGain gain = CompareFits(
        before, MeasureFit(bare, segments_, changes_, options_.bundle));
    // Lenses of a few coefficients that hardly bend anything fit either way.
    constexpr double kLeastShare = 0.05;
    if (!gain.certain() ||
        gain.before_px - gain.after_px < kLeastShare * gain.before_px) {
      return;
    }
    Add({"lens", "", 0.9, gain.before_px, gain.after_px,
         "--set=cameras.ignore_distortion=true",
         "the detections fit better without the lens: their images were "
         "undistorted, or the lens is another one's"});
    cameras_ = bare;
  }

  // ---- Single cameras and clocks ----

  struct Model {
    std::string kind;
    FreeParameters free;
  };

  std::vector<Model> Models() const {
    const FreeParameters clock = ClockParametersOf(segments_.span_s);
    FreeParameters shift;
    shift.shift = true;
    FreeParameters rotation;
    rotation.rotation = true;
    FreeParameters focal;
    focal.focal = true;
    std::vector<Model> models;
    if (!clocks_done_) models.push_back({"clock", clock});
    if (!cameras_done_) {
      models.push_back({"shift", shift});
      models.push_back({"rotation", rotation});
      models.push_back({"focal_length", focal});
    }
    return models;
  }

  // Root mean square distance [px] by which a change moves the points that the
  // view sees, and the same of a length of 1 m at their depth.
  void MeasureChange(size_t view, const CameraChange& change, double* moved_px,
                     double* px_per_m) const {
    double squares = 0.0;
    double scale = 0.0;
    double count = 0.0;
    for (const Stretch& segment : segments_.segments) {
      const Eigen::Vector3d point = PositionOf(segment);
      const bool seen =
          std::any_of(segment.measurements.begin(), segment.measurements.end(),
                      [&](const SegmentMeasurement& m) {
                        return m.view_idx == static_cast<int>(view);
                      });
      if (!seen) continue;
      const auto before = ProjectChanged(cameras_[view], CameraChange::Zero(),
                                         point, nullptr, nullptr);
      const auto after =
          ProjectChanged(cameras_[view], change, point, nullptr, nullptr);
      if (!before.has_value() || !after.has_value()) continue;
      squares += (*after - *before).squaredNorm();
      scale += cameras_[view].focal_px() / cameras_[view].Depth(point);
      count += 1.0;
    }
    *moved_px = count > 0.0 ? std::sqrt(squares / count) : 0.0;
    *px_per_m = count > 0.0 ? scale / count : 0.0;
  }

  struct Explanation {
    Model model;
    CrossedGain gain;
    BundleResult fit;
    std::vector<char> moves;  // the views that it finds to be off
  };

  // Fits a model with those views free that `moves` names (empty: all).
  std::optional<Explanation> FitModel(const Model& model,
                                      const std::vector<char>& moves) const {
    Explanation one;
    one.model = model;
    one.gain = CrossFit(cameras_, segments_, model.free, changes_,
                        options_.bundle, moves);
    if (!one.gain.all.certain()) return std::nullopt;
    one.fit = AdjustBundle(cameras_, segments_, model.free, changes_,
                           options_.bundle, moves);
    if (!one.fit.usable) return std::nullopt;
    one.moves.assign(cameras_.size(), 0);
    if (model.kind == "clock") {
      MarkLate(one.fit, &one.moves);
    } else {
      MarkMoved(one.fit, one.gain, &one.moves);
    }
    if (std::count(one.moves.begin(), one.moves.end(), 1) == 0) {
      return std::nullopt;
    }
    return one;
  }

  // Finds what explains the residuals best and takes it; false when nothing
  // does.
  bool Explain() {
    std::vector<Explanation> explanations;
    std::vector<char> moves(cameras_.size(), 0);
    for (const Model& model : Models()) {
      if (auto one = FitModel(model, {})) {
        for (size_t v = 0; v < moves.size() && model.kind != "clock"; ++v) {
          moves[v] = moves[v] || one->moves[v];
        }
        explanations.push_back(*std::move(one));
      }
    }
    // Cameras that are right keep their place: those alone may move that some
    // model finds to be off.
    for (Explanation& one : explanations) {
      if (one.model.kind == "clock") continue;
      if (auto again = FitModel(one.model, moves)) one = *std::move(again);
    }
    if (explanations.empty()) return false;
    std::stable_sort(explanations.begin(), explanations.end(),
                     [](const Explanation& a, const Explanation& b) {
                       return a.gain.all.after_px < b.gain.all.after_px;
                     });
    const FitGain& best = explanations.front().gain.all;
    // Within a tenth of what is gained they fit equally.
    constexpr double kEqual = 0.1;
    const double limit_px =
        best.after_px + kEqual * (best.before_px - best.after_px);
    size_t alike = 0;
    while (alike < explanations.size() &&
           explanations[alike].gain.all.after_px <= limit_px) {
      ++alike;
    }
    for (size_t e = 0; e < alike; ++e) {
      AddExplanation(explanations[e], alike);
    }
    const Explanation& taken = explanations.front();
    (taken.model.kind == "clock" ? clocks_done_ : cameras_done_) = true;
    changes_ = taken.fit.changes;
    return true;
  }

  void AddExplanation(const Explanation& one, size_t alike) {
    for (size_t v = 0; v < cameras_.size(); ++v) {
      if (!one.moves[v]) continue;
      const CameraChange& change = one.fit.changes[v];
      Finding finding;
      finding.camera = NameOf(v);
      finding.confidence = Shared(0.95, alike);
      finding.before_px = one.gain.views[v].before_px;
      finding.after_px = one.gain.views[v].after_px;
      if (one.model.kind != "clock") {
        finding.kind = one.model.kind;
        finding.fix = kUseCorrected;
        finding.evidence = Words(one.model.kind, change);
        Add(finding);
        continue;
      }
      finding.fix = "--set=cameras.refine_clock=true";
      const double usual_s = UsualOf(one.fit.changes, kOffsetAt);
      if (IsLate(v, one.fit, kOffsetAt)) {
        finding.kind = "clock_offset";
        finding.evidence = Format(
            "its pictures were taken %+.1f ms from the time told, against the "
            "usual of all views",
            1e3 * (change[kOffsetAt] - usual_s));
        Add(finding);
      }
      if (one.model.free.drift && IsLate(v, one.fit, kDriftAt)) {
        const double usual = UsualOf(one.fit.changes, kDriftAt);
        finding.kind = "clock_drift";
        finding.evidence = Format(
            "it runs %+.0f ppm against the usual of all views, %+.0f "
            "ms over the take",
            1e6 * (change[kDriftAt] - usual),
            1e3 * (change[kDriftAt] - usual) * segments_.span_s);
        Add(finding);
      }
    }
  }

  // The first view's clock is the reference of the fit, which does not make it
  // right: views are late against the median of all.
  static double UsualOf(const std::vector<CameraChange>& changes, int place) {
    std::vector<double> values;
    for (const CameraChange& change : changes) values.push_back(change[place]);
    return Quantile(values, 0.5);
  }

  bool IsLate(size_t view, const BundleResult& fit, int place) const {
    // Under a sixth of a frame a clock hardly matters, and what walking people
    // do to a detector's bias looks like it.
    constexpr double kLeastFrames = 0.15;
    constexpr double kSigmas = 4.0;
    const double frame_s = 1.0 / std::max(1.0, input_.frame_rate_hz);
    const double span_s = place == kDriftAt ? segments_.span_s : 1.0;
    const double late =
        std::abs(fit.changes[view][place] - UsualOf(fit.changes, place));
    // The covariance has the free clocks in order, the first view's left out.
    const size_t per_view = static_cast<size_t>(fit.covariance.rows()) /
                            std::max<size_t>(1, cameras_.size() - 1);
    const size_t other = view == 0 ? 1 : view;
    const auto at = static_cast<Eigen::Index>((other - 1) * per_view +
                                              (place == kDriftAt ? 1 : 0));
    const double sigma = std::sqrt(std::max(0.0, fit.covariance(at, at)));
    // Stretches are a fifth of a second long: what they say of a clock that is
    // farther off is made up. Whole frames were looked for before.
    constexpr double kFarthestS = 0.25;
    return late * span_s < kFarthestS &&
           late * span_s > kLeastFrames * frame_s && late > kSigmas * sigma;
  }

  void MarkLate(const BundleResult& fit, std::vector<char>* moves) const {
    const bool drift =
        segments_.span_s > 0.0 &&
        fit.covariance.rows() > static_cast<Eigen::Index>(cameras_.size()) - 1;
    for (size_t v = 0; v < cameras_.size(); ++v) {
      if (strangers_.count(v) > 0) continue;
      (*moves)[v] =
          IsLate(v, fit, kOffsetAt) || (drift && IsLate(v, fit, kDriftAt));
    }
  }

  void MarkMoved(const BundleResult& fit, const CrossedGain& gain,
                 std::vector<char>* moves) const {
    for (size_t v = 0; v < cameras_.size(); ++v) {
      if (strangers_.count(v) > 0) continue;
      CameraChange change = fit.changes[v] - changes_[v];
      change[kOffsetAt] = change[kDriftAt] = 0.0;
      double moved_px = 0.0;
      double px_per_m = 0.0;
      MeasureChange(v, change, &moved_px, &px_per_m);
      // A detector's joints sit this far from where they should, on average
      // over joints and directions of view: no fault of the camera.
      constexpr double kDetectorBiasM = 0.012;
      constexpr double kLeastShare = 0.05;
      const FitGain& of_view = gain.views[v];
      const bool worth = of_view.before_px - of_view.after_px >
                         kLeastShare * of_view.before_px;
      if (worth && of_view.certain() && moved_px > kDetectorBiasM * px_per_m) {
        (*moves)[v] = 1;
      }
    }
  }

  static std::string Words(const std::string& kind,
                           const CameraChange& change) {
    if (kind == "shift") {
      return Format("its image fits moved by (%+.1f, %+.1f) px",
                    change[kShiftAt], change[kShiftAt + 1]);
    }
    if (kind == "rotation") {
      return Format("it fits turned by %.2f degrees",
                    kDegreesPerRadian * change.segment<3>(kRotationAt).norm());
    }
    return Format("its focal length fits multiplied by %.4f",
                  std::exp(change[kFocalAt]));
  }

  const DoctorInput& input_;
  const DoctorOptions& options_;
  Diagnosis diagnosis_;
  CameraRig cameras_;
  DetectionSequence detections_;
  std::vector<ViewPeople> raw_;
  std::vector<int> frames_;
  std::set<size_t> strangers_;
  SceneSegments segments_;
  bool clocks_done_ = false;
  bool cameras_done_ = false;
  std::vector<CameraChange> changes_;
};

}  // namespace

Diagnosis Diagnose(const DoctorInput& input, const DoctorOptions& options) {
  return Doctor(input, options).Run();
}

}  // namespace kinegraph
