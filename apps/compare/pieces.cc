#include "apps/compare/pieces.h"

#include "core/io/configuration/checkpoint_values.h"
#include "core/io/configuration/config.h"

namespace kinegraph {

std::string PieceContent(const Comparison& comparison) {
  ByteWriter content;
  content.PutText(EffectiveConfigJson(comparison.options));
  Put(comparison.scene().cameras, &content);
  Put(comparison.scene().skeleton, &content);
  content.Put(comparison.rate_hz());
  content.Put(comparison.run.first_frame);
  content.PutText(ContentOf(comparison.run.detections));
  for (const Fold& fold : comparison.folds) {
    content.Put(fold.frames.begin);
    content.Put(fold.frames.end);
    content.PutText(ContentOf(fold.take->detections));
  }
  for (const double cap : comparison.cap_px) content.Put(cap);
  content.Put(comparison.set.min_confidence);
  content.Put(comparison.set.pairing_gate_m);
  for (const HeldOutDetection& one : comparison.set.detections) {
    content.Put(one.frame);
    content.PutText(one.view_name);
    content.Put(one.detection_idx);
    content.Put(one.person.value());
  }
  return FingerprintOf(content.bytes());
}

std::string PieceKey(const Comparison& comparison, const std::string& what,
                     const Strategy& strategy, const FoldValues& values,
                     int view) {
  ByteWriter key;
  key.PutText(comparison.content);
  key.PutText(what);
  key.PutText(strategy.name);
  key.PutSize(values.size());
  for (const StrategyValues& fold : values) {
    key.PutSize(fold.size());
    for (const double value : fold) key.Put(value);
  }
  key.Put(view);
  return FingerprintOf(key.bytes());
}

void Put(const StrategyRun& run, ByteWriter* writer) {
  Put(run.tracks.frames, writer);
  writer->Put(run.cpu_ns);
  writer->Put(run.person_frames);
  writer->Put(run.delay.has_value());
  writer->Put(run.delay.value_or(0));
  writer->Put(run.whole_take);
}

StrategyRun GetStrategyRun(ByteReader* reader) {
  StrategyRun run;
  run.tracks.frames = GetTrackFrames(reader);
  run.cpu_ns = reader->Get<int64_t>();
  run.person_frames = reader->Get<int64_t>();
  const bool known = reader->Get<bool>();
  const auto delay = reader->Get<TimeNs>();
  if (known) run.delay = delay;
  run.whole_take = reader->Get<bool>();
  return run;
}

void Put(const HeldOutScores& scores, ByteWriter* writer) {
  writer->PutSize(scores.people.size());
  for (const HeldOutPerson& person : scores.people) {
    writer->Put(person.frame);
    writer->Put(person.view_idx);
    writer->Put(person.paired);
  }
  writer->PutSize(scores.joints.size());
  for (const HeldOutJoint& joint : scores.joints) {
    writer->PutSize(joint.person_idx);
    writer->Put(joint.joint_class);
    writer->Put(joint.error_px);
    writer->Put(joint.predicted);
    writer->Put(joint.normalised_squared.has_value());
    writer->Put(joint.normalised_squared.value_or(0.0));
  }
}

HeldOutScores GetHeldOutScores(ByteReader* reader) {
  HeldOutScores scores;
  scores.people.resize(reader->GetSize(sizeof(int64_t)));
  for (HeldOutPerson& person : scores.people) {
    person.frame = reader->Get<int64_t>();
    person.view_idx = reader->Get<int>();
    person.paired = reader->Get<bool>();
  }
  scores.joints.resize(reader->GetSize(sizeof(double)));
  for (HeldOutJoint& joint : scores.joints) {
    joint.person_idx = static_cast<size_t>(reader->Get<uint64_t>());
    joint.joint_class = reader->Get<JointClass>();
    joint.error_px = reader->Get<double>();
    joint.predicted = reader->Get<bool>();
    const bool known = reader->Get<bool>();
    const auto value = reader->Get<double>();
    if (known) joint.normalised_squared = value;
  }
  return scores;
}

}  // namespace kinegraph
