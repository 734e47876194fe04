#include "solvers/session/options.h"

#include <cmath>
#include <cstdlib>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/data/limits.h"
#include "core/io/configuration/config.h"

namespace kinegraph {

void InputOptions::Describe(OptionVisitor& visitor) {
  visitor.Number("frame_rate", &frame_rate_hz, NonNegative(), "Hz",
                 "nominal frame rate; 0: as in the files");
  visitor.Integer(
      "repeat_first_frame", &repeat_first_frame, Between(0, 1000), "frames",
      "number of times the first frame is processed before the recording");
  visitor.Boolean("independent_frames", &independent_frames,
                  "unrelated frames: no track continues into the next frame");
  visitor.Boolean("skip_bad_frames", &skip_bad_frames,
                  "kinegraph's JSON Lines: skip frames that cannot be read");
  visitor.TextMap(
      "view_frame_rate", &view_frame_rate,
      "rate [Hz] at which a view's files count frames, if it differs");
  visitor.TextMap("view_frame_offset", &view_frame_offset,
                  "subtracted from the frame numbers of a view's files");
}

void OutputOptions::Describe(OptionVisitor& visitor) {
  visitor.Boolean("observations", &observations,
                  "also write each person's matches and weights");
}

void RunOptions::Describe(OptionVisitor& visitor) {
  visitor.Text("skeleton", &skeleton,
               "skeleton of the tracks; empty: that of the detections");
  estimators.Describe(visitor);
  visitor.Enter("input");
  input.Describe(visitor);
  visitor.Leave();
  visitor.Enter("cameras");
  cameras.Describe(visitor);
  refine.Describe(visitor);
  visitor.Number("subject_m", &subject_m, NonNegative(), "m",
                 "stature or length of the subject; 0: measured");
  visitor.Leave();
  visitor.Enter("detections");
  detections.Describe(visitor);
  visitor.Leave();
  tracker.Describe(visitor);
  visitor.Enter("identity");
  identity.Describe(visitor);
  visitor.Leave();
  visitor.Enter("output");
  output.Describe(visitor);
  visitor.Leave();
}

RunOptions WithRulesOfMode(RunOptions options) {
  if (options.estimators.mode == Mode::kPaper) {
    constexpr double kRate_hz = 25.0;  // frame rate of the paper
    TrackLifeOptions& life = options.tracker.life;
    life.max_age_frames = life.max_age_s * kRate_hz;
    life.confirm_hits = 1 + std::llround(life.confirm_s * kRate_hz);
    life.max_gap_frames = 0.0;
    life.backfill = false;
    life.second_pass = false;
    options.identity.link = false;
  } else {
    options.tracker.life.in_seconds = true;
    options.tracker.rules = AssociationRules::kGraph;
  }
  if (options.input.independent_frames) {
    options.tracker.life.independent_frames = true;
    options.identity.link = false;  // people cannot be followed between frames
  }
  return options;
}

namespace {

void CheckViewBias(const RunOptions& options) {
  const EstimatorOptions& estimators = options.estimators;
  if (estimators.mode == Mode::kPaper ||
      estimators.graph.view_bias != ViewBiasUse::kOn) {
    return;
  }
  if (estimators.output != OutputKind::kBatch ||
      !options.tracker.life.second_pass) {
    throw OptionError("graph.view_bias",
                      "\"on\" needs output.estimator = \"batch\" and "
                      "tracking.second_pass = true: the first pass "
                      "estimates the bias that the second removes");
  }
}

RunOptions OptionsOf(ConfigFile config, const std::string& set,
                     const std::string& mode) {
  if (!set.empty()) config.Override(set, "--set");
  if (!mode.empty()) config.Override("mode=" + mode, "--mode");
  RunOptions options;
  config.Apply(&options);
  options.user_skeletons = config.ReadSkeletons();
  config.RejectUnknown();
  if (!options.detections.skeleton_name.empty()) {
    options.detections.skeleton = ResolveSkeleton(
        options.detections.skeleton_name, options.user_skeletons);
  }
  options = WithRulesOfMode(std::move(options));
  CheckViewBias(options);
  return options;
}

}  // namespace

RunOptions ReadRunOptions(const std::string& config_path,
                          const std::string& set, const std::string& mode) {
  return OptionsOf(ConfigFile::Read(config_path), set, mode);
}

RunOptions ParseRunOptions(const std::string& toml, const std::string& set,
                           const std::string& mode) {
  return OptionsOf(ConfigFile::Parse(toml, "configuration"), set, mode);
}

namespace {

double RateOf(const std::string& view, const std::string& text) {
  char* end = nullptr;
  const double rate_hz = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' ||
      !(rate_hz > 0.0 && rate_hz <= kMaxFrameRate_hz)) {
    throw OptionError("input.view_frame_rate." + view,
                      "found '" + Printable(text) +
                          "', expected a rate in Hz above 0 and at most 1e6");
  }
  return rate_hz;
}

int64_t OffsetOf(const std::string& view, const std::string& text) {
  const auto offset = ParseNumber<int64_t>(text);
  if (!offset.has_value()) {
    throw OptionError(
        "input.view_frame_offset." + view,
        "found '" + Printable(text) + "', expected a whole number of frames");
  }
  return *offset;
}

}  // namespace

DetectionReadOptions DetectionOptionsOf(const RunOptions& options) {
  DetectionReadOptions read = options.detections;
  read.frame_rate_hz = options.input.frame_rate_hz;
  read.skip_bad_frames = options.input.skip_bad_frames;
  for (const auto& [view, text] : options.input.view_frame_rate) {
    read.view_frame_rate_hz[view] = RateOf(view, text);
  }
  for (const auto& [view, text] : options.input.view_frame_offset) {
    read.view_frame_offset[view] = OffsetOf(view, text);
  }
  return read;
}

EstimatorFactory FeedbackOf(const RunOptions& options) {
  // A replay (core/tracking/replay.h) makes estimators for one person after
  // another, also with one camera left out; they must not share learnt data.
  EstimatorOptions alone = options.estimators;
  alone.graph.view_bias = ViewBiasUse::kOff;
  return MakeEstimators(alone).feedback;
}

}  // namespace kinegraph
