#include "core/tracking/packed_frames.h"

#include <glog/logging.h>

#include <algorithm>
#include <cstdint>
#include <string>

#include "core/base/bytes.h"

namespace kinegraph {
namespace {

// Eight flags a byte.
template <typename Is>
void PutFlags(size_t count, const Is& is, ByteWriter* writer) {
  for (size_t begin = 0; begin < count; begin += 8) {
    uint8_t flags = 0;
    for (size_t i = begin; i < std::min(count, begin + 8); ++i) {
      if (is(i)) flags = static_cast<uint8_t>(flags | (1u << (i - begin)));
    }
    writer->Put(flags);
  }
}

// Calls set(i, flag) for each.
template <typename Set>
void GetFlags(size_t count, const Set& set, ByteReader* reader) {
  for (size_t begin = 0; begin < count; begin += 8) {
    const auto flags = reader->Get<uint8_t>();
    for (size_t i = begin; i < std::min(count, begin + 8); ++i) {
      set(i, ((flags >> (i - begin)) & 1) != 0);
    }
  }
}

void Put(const FreshView& view, ByteWriter* writer) {
  writer->Put(view.view_idx);
  writer->Put(view.capture_time);
  writer->Put(view.detection_idx);
  writer->PutCount(view.joints.size());
  PutFlags(
      view.joints.size(), [&](size_t j) { return view.joints[j].found; },
      writer);
  for (const Keypoint& joint : view.joints) {
    if (!joint.found) continue;
    writer->PutMatrix(joint.px);
    writer->Put(joint.confidence);
  }
}

void Get(ByteReader* reader, FreshView* view) {
  view->view_idx = reader->Get<int>();
  view->capture_time = reader->Get<TimeNs>();
  view->detection_idx = reader->Get<int>();
  view->joints.assign(reader->GetCount(), Keypoint());
  view->verdicts.clear();
  GetFlags(
      view->joints.size(),
      [&](size_t j, bool found) { view->joints[j].found = found; }, reader);
  for (Keypoint& joint : view->joints) {
    if (!joint.found) continue;
    reader->GetMatrix(&joint.px);
    joint.confidence = reader->Get<double>();
  }
}

void Put(const Pose3d& pose, ByteWriter* writer) {
  writer->PutCount(pose.size());
  PutFlags(
      pose.size(), [&](size_t j) { return pose[j].present(); }, writer);
  PutFlags(
      pose.size(),
      [&](size_t j) { return pose[j].status == JointStatus::kObserved; },
      writer);
  for (const Joint3d& joint : pose) {
    if (joint.present()) writer->PutMatrix(joint.position_m);
  }
}

void Get(ByteReader* reader, Pose3d* pose) {
  pose->assign(reader->GetCount(), Joint3d());
  GetFlags(
      pose->size(),
      [&](size_t j, bool present) {
        if (present) (*pose)[j].status = JointStatus::kInferred;
      },
      reader);
  GetFlags(
      pose->size(),
      [&](size_t j, bool observed) {
        if (observed) (*pose)[j].status = JointStatus::kObserved;
      },
      reader);
  for (Joint3d& joint : *pose) {
    if (joint.present()) reader->GetMatrix(&joint.position_m);
  }
}

std::string BytesOf(const EstimatorFrame& frame) {
  ByteWriter writer;
  writer.Put(frame.frame);
  writer.Put(frame.time);
  writer.PutCount(frame.views.size());
  for (const FreshView& view : frame.views) Put(view, &writer);
  writer.Put(frame.has_initial);
  if (frame.has_initial) Put(frame.initial, &writer);
  writer.PutCount(frame.triangulated.size());
  PutFlags(
      frame.triangulated.size(),
      [&](size_t j) { return frame.triangulated[j] != 0; }, &writer);
  return writer.Take();
}

}  // namespace

void PackedFrames::Push(const EstimatorFrame& frame) {
  frames_.Push(BytesOf(frame));
}

void PackedFrames::Pop(EstimatorFrame* frame) {
  CHECK(!empty());
  ByteReader reader(frames_.front());
  frame->frame = reader.Get<int64_t>();
  frame->time = reader.Get<TimeNs>();
  frame->views.resize(reader.GetCount());
  for (FreshView& view : frame->views) Get(&reader, &view);
  frame->has_initial = reader.Get<bool>();
  frame->initial.clear();
  if (frame->has_initial) Get(&reader, &frame->initial);
  frame->triangulated.resize(reader.GetCount());
  GetFlags(
      frame->triangulated.size(),
      [&](size_t j, bool yes) { frame->triangulated[j] = yes ? 1 : 0; },
      &reader);
  frame->inlier_views.clear();
  frames_.Pop();
}

}  // namespace kinegraph
