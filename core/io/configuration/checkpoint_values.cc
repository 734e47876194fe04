#include "core/io/configuration/checkpoint_values.h"

#include <optional>
#include <utility>

#include "core/geometry/camera_bytes.h"

namespace kinegraph {
namespace {

void PutJoint(const Joint3d& joint, ByteWriter* writer) {
  writer->PutMatrix(joint.position_m);
  writer->Put(joint.status);
}

Joint3d GetJoint(ByteReader* reader) {
  Joint3d joint;
  reader->GetMatrix(&joint.position_m);
  joint.status = reader->Get<JointStatus>();
  return joint;
}

void PutMatch(const ViewMatch& match, ByteWriter* writer) {
  writer->Put(match.view_idx);
  writer->Put(match.detection_idx);
  writer->PutSize(match.weights.size());
  for (const std::optional<double>& weight : match.weights) {
    writer->Put(weight.has_value());
    writer->Put(weight.value_or(0.0));
  }
}

ViewMatch GetMatch(ByteReader* reader) {
  ViewMatch match;
  match.view_idx = reader->Get<int>();
  match.detection_idx = reader->Get<int>();
  match.weights.resize(reader->GetSize(sizeof(double)));
  for (std::optional<double>& weight : match.weights) {
    const bool known = reader->Get<bool>();
    const auto value = reader->Get<double>();
    if (known) weight = value;
  }
  return match;
}

}  // namespace

void Put(const PersonPose& person, ByteWriter* writer) {
  writer->Put(person.id.value());
  writer->Put(person.score);
  writer->PutSize(person.joints.size());
  for (const Joint3d& joint : person.joints) PutJoint(joint, writer);
  writer->PutSize(person.inlier_views.size());
  for (const int views : person.inlier_views) writer->Put(views);
  writer->PutSize(person.covariances.size());
  for (const auto& covariance : person.covariances) {
    writer->Put(covariance.has_value());
    if (covariance.has_value()) writer->PutMatrix(*covariance);
  }
  writer->PutSize(person.matches.size());
  for (const ViewMatch& match : person.matches) PutMatch(match, writer);
}

PersonPose GetPersonPose(ByteReader* reader) {
  PersonPose person;
  person.id = TrackId(reader->Get<int64_t>());
  person.score = reader->Get<double>();
  person.joints.resize(reader->GetSize(3 * sizeof(double)));
  for (Joint3d& joint : person.joints) joint = GetJoint(reader);
  person.inlier_views.resize(reader->GetSize(sizeof(int)));
  for (int& views : person.inlier_views) views = reader->Get<int>();
  person.covariances.resize(reader->GetSize());
  for (auto& covariance : person.covariances) {
    if (!reader->Get<bool>()) continue;
    covariance.emplace();
    reader->GetMatrix(&*covariance);
  }
  person.matches.resize(reader->GetSize(2 * sizeof(int)));
  for (ViewMatch& match : person.matches) match = GetMatch(reader);
  return person;
}

void Put(const std::vector<TrackFrame>& frames, ByteWriter* writer) {
  writer->PutSize(frames.size());
  for (const TrackFrame& frame : frames) {
    writer->Put(frame.frame);
    writer->Put(frame.time);
    writer->PutSize(frame.people.size());
    for (const PersonPose& person : frame.people) Put(person, writer);
  }
}

std::vector<TrackFrame> GetTrackFrames(ByteReader* reader) {
  std::vector<TrackFrame> frames(reader->GetSize(3 * sizeof(int64_t)));
  for (TrackFrame& frame : frames) {
    frame.frame = reader->Get<int64_t>();
    frame.time = reader->Get<TimeNs>();
    const size_t people = reader->GetSize(sizeof(int64_t));
    for (size_t i = 0; i < people; ++i) {
      frame.people.push_back(GetPersonPose(reader));
    }
  }
  return frames;
}

void Put(const Skeleton& skeleton, ByteWriter* writer) {
  writer->PutText(skeleton.name());
  writer->PutSize(skeleton.joints().size());
  for (const std::string& joint : skeleton.joints()) writer->PutText(joint);
  writer->PutSize(skeleton.bones().size());
  for (const Bone& bone : skeleton.bones()) {
    writer->Put(bone.a);
    writer->Put(bone.b);
  }
}

void Put(const CameraRig& cameras, ByteWriter* writer) {
  writer->PutSize(cameras.size());
  for (const Camera& camera : cameras) Put(camera, writer);
}

void Put(const Keypoint& joint, ByteWriter* writer) {
  writer->PutMatrix(joint.px);
  writer->Put(joint.confidence);
  writer->Put(joint.found);
}

// The fingerprint frame by frame, so that no second take is in memory.
std::string ContentOf(const DetectionSequence& detections) {
  Fingerprint content;
  ByteWriter head;
  Put(detections.header.skeleton, &head);
  head.Put(detections.header.frame_rate_hz);
  for (const std::string& name : detections.header.view_names) {
    head.PutText(name);
  }
  content.Add(head.bytes());
  for (const DetectionFrame& frame : detections.frames) {
    ByteWriter writer;
    writer.Put(frame.frame);
    writer.Put(frame.time);
    for (const ViewDetections& view : frame.views) {
      writer.Put(view.capture_time);
      writer.PutSize(view.detections.size());
      for (const Detection& detection : view.detections) {
        writer.Put(detection.index_in_file);
        writer.PutSize(detection.joints.size());
        for (const Keypoint& joint : detection.joints) Put(joint, &writer);
      }
    }
    content.Add(writer.bytes());
  }
  return content.Hex();
}

}  // namespace kinegraph
