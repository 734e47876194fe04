#include "solvers/session/remembered_runs.h"

#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/bytes.h"
#include "core/io/configuration/checkpoint_values.h"
#include "core/io/configuration/config.h"
#include "core/tracking/final_poses.h"
#include "solvers/batch/batch_estimator.h"
#include "solvers/noise/take_notes.h"
#include "solvers/session/ready_take.h"

namespace kinegraph {
namespace {

constexpr int64_t SolveCounts::*kCounts[] = {
    &SolveCounts::solves,           &SolveCounts::sweep_iterations,
    &SolveCounts::ceres_problems,   &SolveCounts::ceres_iterations,
    &SolveCounts::cholmod_problems, &SolveCounts::ceres_decrease_millionths,
    &SolveCounts::not_converged,    &SolveCounts::not_finite,
    &SolveCounts::bones_dropped,    &SolveCounts::positions_in_doubt,
    &SolveCounts::no_covariance};
static_assert(sizeof(SolveCounts) == sizeof(int64_t) * std::size(kCounts),
              "a count is missing above");
static_assert(sizeof(LearntNoise) ==
                  kJointClassCount * (sizeof(int64_t) + 4 * sizeof(double)) +
                      3 * sizeof(double),
              "Put(LearntNoise) leaves something out");

void PutPose(const Pose3d& pose, ByteWriter* writer) {
  writer->PutSize(pose.size());
  for (const Joint3d& joint : pose) {
    writer->PutMatrix(joint.position_m);
    writer->Put(joint.status);
  }
}

// All of it: what the estimator makes depends on nothing else.
std::string BytesOf(const EstimatorFrame& frame) {
  ByteWriter writer;
  writer.Put(frame.frame);
  writer.Put(frame.time);
  writer.PutSize(frame.views.size());
  for (const FreshView& view : frame.views) {
    writer.Put(view.view_idx);
    writer.Put(view.capture_time);
    writer.Put(view.detection_idx);
    writer.PutSize(view.joints.size());
    for (const Keypoint& joint : view.joints) Put(joint, &writer);
    writer.PutSize(view.verdicts.size());
    for (const FilterVerdict verdict : view.verdicts) writer.Put(verdict);
  }
  writer.Put(frame.has_initial);
  if (frame.has_initial) PutPose(frame.initial, &writer);
  writer.PutSize(frame.triangulated.size());
  for (const char one : frame.triangulated) writer.Put(one);
  writer.PutSize(frame.inlier_views.size());
  for (const int views : frame.inlier_views) writer.Put(views);
  return writer.Take();
}

std::string BytesOf(const SceneModel& scene) {
  ByteWriter writer;
  Put(scene.cameras, &writer);
  Put(scene.skeleton, &writer);
  writer.Put(scene.frame_rate_hz);
  writer.Put(scene.kept_matches);
  return writer.Take();
}

// What a solve leaves behind.
struct Solution {
  std::vector<FinalPose> finals;
  SolveCounts counts;
  LearntNoise learnt;
};

void Put(const LearntNoise& learnt, ByteWriter* writer) {
  for (const LearntNoise::OfClass& one : learnt.classes) {
    writer->Put(one.joints_seen);
    writer->Put(one.sigma_px);
    writer->Put(one.process_noise);
    writer->Put(one.least_process_noise);
    writer->Put(one.greatest_process_noise);
  }
  writer->Put(learnt.correlation.share);
  writer->Put(learnt.correlation.time_s);
  writer->Put(learnt.confidence_power);
}

LearntNoise GetLearntNoise(ByteReader* reader) {
  LearntNoise learnt;
  for (LearntNoise::OfClass& one : learnt.classes) {
    one.joints_seen = reader->Get<int64_t>();
    one.sigma_px = reader->Get<double>();
    one.process_noise = reader->Get<double>();
    one.least_process_noise = reader->Get<double>();
    one.greatest_process_noise = reader->Get<double>();
  }
  learnt.correlation.share = reader->Get<double>();
  learnt.correlation.time_s = reader->Get<double>();
  learnt.confidence_power = reader->Get<double>();
  return learnt;
}

std::string BytesOf(const Solution& solution) {
  ByteWriter writer;
  for (const auto count : kCounts) writer.Put(solution.counts.*count);
  Put(solution.learnt, &writer);
  writer.PutSize(solution.finals.size());
  for (const FinalPose& final : solution.finals) {
    writer.Put(final.frame);
    writer.Put(final.time);
    Put(final.person, &writer);
  }
  return writer.Take();
}

Solution SolutionIn(const std::string& bytes) {
  ByteReader reader(bytes);
  Solution solution;
  for (const auto count : kCounts) {
    solution.counts.*count = reader.Get<int64_t>();
  }
  solution.learnt = GetLearntNoise(&reader);
  solution.finals.resize(reader.GetSize(2 * sizeof(int64_t)));
  for (FinalPose& final : solution.finals) {
    final.frame = reader.Get<int64_t>();
    final.time = reader.Get<TimeNs>();
    final.person = GetPersonPose(&reader);
  }
  return solution;
}

// A batch estimator that looks its solution up before it solves.
class RememberedBatch final : public Estimator {
 public:
  RememberedBatch(const SceneModel& scene, GraphOptions options,
                  TakeNotes* notes, const std::string& config_json,
                  Checkpoint* checkpoint)
      : shared_ledger_(options.ledger),
        own_ledger_(std::make_shared<SolveLedger>()),
        shared_learnt_(notes->NewPerson()),
        own_notes_(std::make_shared<TakeNotes>(options)),
        checkpoint_(checkpoint) {
    options.ledger = own_ledger_;
    inner_ = MakeBatchEstimator(scene, options, own_notes_);
    key_.Add(config_json);
    key_.Add(BytesOf(scene));
  }

  void Add(const EstimatorFrame& frame) override {
    key_.Add(BytesOf(frame));
    inner_->Add(frame);
  }
  const Pose3d& Last() const override {
    return inner_ == nullptr ? last_ : inner_->Last();
  }
  TimeNs LastTime() const override {
    return inner_ == nullptr ? last_time_ : inner_->LastTime();
  }
  void Predict(TimeNs, Pose3d* pose) const override {
    ExpectUnmoved(Last(), pose);
  }
  void TakeFinals(std::vector<FinalPose>* finals) override {
    MoveFinals(&finals_, finals);
  }

  void Finish() override {
    Solution solution;
    if (const auto kept = checkpoint_->Find(key_.Hex())) {
      solution = SolutionIn(*kept);
    } else {
      inner_->Finish();
      inner_->TakeFinals(&solution.finals);
      solution.counts = own_ledger_->Total();
      solution.learnt = own_notes_->Noise();
      checkpoint_->Add(key_.Hex(), BytesOf(solution));
    }
    // Finals may wait long for those of other people: nothing else should.
    last_ = inner_->Last();
    last_time_ = inner_->LastTime();
    inner_.reset();
    finals_ = std::move(solution.finals);
    *shared_learnt_ = solution.learnt;
    if (shared_ledger_ != nullptr) shared_ledger_->Add(solution.counts);
  }

 private:
  const std::shared_ptr<SolveLedger> shared_ledger_;
  const std::shared_ptr<SolveLedger> own_ledger_;
  // What was learnt goes to the run's notes, from the solve or as it was kept.
  const std::shared_ptr<LearntNoise> shared_learnt_;
  const std::shared_ptr<TakeNotes> own_notes_;
  Checkpoint* const checkpoint_;
  std::unique_ptr<Estimator> inner_;  // null when finished
  Pose3d last_;                       // its last pose then
  TimeNs last_time_ = 0;
  Fingerprint key_;
  std::vector<FinalPose> finals_;
};

}  // namespace

EstimatorPair MakeRememberedEstimators(const EstimatorOptions& options,
                                       const std::string& config_json,
                                       Checkpoint* checkpoint) {
  EstimatorPair pair = MakeEstimators(options);
  // Factors of the caller's own are no part of the key, nor is what other
  // people tell of the detector's bias.
  if (checkpoint->keeps() && options.mode == Mode::kGraph &&
      options.output == OutputKind::kBatch && !options.graph.user_factors &&
      options.graph.view_bias == ViewBiasUse::kOff) {
    pair.output = [=, graph = options.graph,
                   notes = pair.notes](const SceneModel& scene) {
      return std::make_unique<RememberedBatch>(scene, graph, notes.get(),
                                               config_json, checkpoint);
    };
  }
  return pair;
}

TrackSequence RememberedTracks(const RunOptions& options,
                               const RunRequest& request,
                               const DetectionSequence& detections,
                               Checkpoint* checkpoint) {
  if (checkpoint == nullptr || !checkpoint->keeps() ||
      !request.corrections.empty() || ChangesCameras(options)) {
    return TrackSequenceOf(options, request, detections);
  }
  ByteWriter depends;
  depends.PutText(EffectiveConfigJson(options));
  Put(request.cameras, &depends);
  depends.PutSize(request.without_cameras.size());
  for (const std::string& name : request.without_cameras) {
    depends.PutText(name);
  }
  depends.PutSize(request.frames.size());
  for (const FrameRange& range : request.frames) {
    depends.Put(range.begin);
    depends.Put(range.end);
  }
  depends.Put(request.kept_matches);
  depends.PutText(ContentOf(detections));
  const std::string key = FingerprintOf(depends.bytes());
  if (const auto kept = checkpoint->Find(key)) {
    ByteReader reader(*kept);
    TrackSequence tracks;
    // The header costs nothing to make.
    tracks.header = PrepareScene(options, request, detections.header).header;
    tracks.frames = GetTrackFrames(&reader);
    return tracks;
  }
  TrackSequence tracks = TrackSequenceOf(options, request, detections);
  ByteWriter kept;
  Put(tracks.frames, &kept);
  checkpoint->Add(key, kept.bytes());
  return tracks;
}

}  // namespace kinegraph
