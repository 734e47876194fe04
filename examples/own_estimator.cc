// A custom smoother, behind the interface of the built-in ones: the mean of the
// last three initial poses (EstimatorFrame::initial), joint by joint.
// Association, new people and track life are unchanged.
#include <kinegraph/kinegraph.h>

#include <cstdio>
#include <deque>
#include <memory>
#include <utility>

#include "example_take.h"

class MeanOfThree final : public kinegraph::Estimator {
 public:
  void Add(const kinegraph::EstimatorFrame& frame) override {
    kinegraph::FinalPose pose;
    pose.frame = frame.frame;
    pose.time = frame.time;
    DescribeViews(frame, kinegraph::KeptMatches::kNone, &pose.person);
    if (frame.has_initial) {
      recent_.push_back(frame.initial);
      if (recent_.size() > 3) recent_.pop_front();
      last_ = Mean();
      last_time_ = frame.time;
      pose.person.joints = last_;
    }
    finals_.push_back(std::move(pose));
  }
  const kinegraph::Pose3d& Last() const override { return last_; }
  kinegraph::TimeNs LastTime() const override { return last_time_; }
  void Predict(kinegraph::TimeNs, kinegraph::Pose3d* pose) const override {
    *pose = last_;
  }
  void ExtractFinals(std::vector<kinegraph::FinalPose>* finals) override {
    for (kinegraph::FinalPose& pose : finals_) {
      finals->push_back(std::move(pose));
    }
    finals_.clear();
  }
  void Finish() override {}

 private:
  kinegraph::Pose3d Mean() const {
    kinegraph::Pose3d mean = recent_.back();
    for (size_t j = 0; j < mean.size(); ++j) {
      if (!mean[j].present()) continue;
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      int count = 0;
      for (const kinegraph::Pose3d& pose : recent_) {
        if (!pose[j].present()) continue;
        sum += pose[j].position_m;
        ++count;
      }
      mean[j].position_m = sum / count;
    }
    return mean;
  }

  std::deque<kinegraph::Pose3d> recent_;
  kinegraph::Pose3d last_;
  kinegraph::TimeNs last_time_ = 0;
  std::vector<kinegraph::FinalPose> finals_;
};

int main() {
  const ExampleRecording recording = MakeExampleRecording();

  kinegraph::RunOptions options;
  options.estimators.mode = kinegraph::Mode::kGraph;
  kinegraph::EstimatorPair estimators =
      kinegraph::MakeEstimators(options.estimators);
  estimators.output = [](const kinegraph::SceneModel&) {
    return std::make_unique<MeanOfThree>();
  };
  kinegraph::RunRequest request;
  request.cameras = recording.scene.cameras;
  kinegraph::Session session(options, request, recording.detections.header,
                             estimators);
  kinegraph::MemorySource source(recording.detections);
  kinegraph::TrackSequence tracks;
  tracks.header = session.scene().header;
  kinegraph::TrackAll(&source, &session, [&](kinegraph::TrackFrame&& frame) {
    tracks.frames.push_back(std::move(frame));
  });
  const kinegraph::MpjpeResult error =
      kinegraph::EvaluateMpjpe(recording.truth, tracks);
  std::printf("%lld poses, mean error %.1f mm\n",
              static_cast<long long>(session.summary().person_frames),
              1e3 * error.raw_m);
  return session.summary().person_frames > 0 ? 0 : 1;
}
