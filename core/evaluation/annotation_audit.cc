#include "core/evaluation/annotation_audit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/base/error.h"
#include "core/evaluation/correspondence.h"
#include "core/evaluation/head_conversion.h"
#include "core/geometry/triangulation.h"

namespace kinegraph {
namespace {

constexpr int kBodyJoints = 12;  // of Tum14: all but the head's two
constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool IsLimb(int part) {
  const PcpGroup group = PcpGroupOf(part);
  return group != PcpGroup::kHead && group != PcpGroup::kTorso;
}

// A part's two ends in the world.
using WorldEnds = Ends<Eigen::Vector3d>;

// Of a limb of Tum14, which never ends at the middle of the hips.
std::optional<WorldEnds> EndsOf(const Pose3d& pose, int part) {
  const std::array<int, 2> ends = PcpPartEnds(part);
  if (!pose[ends[0]].present() || !pose[ends[1]].present()) {
    return std::nullopt;
  }
  return WorldEnds{pose[ends[0]].position_m, pose[ends[1]].position_m};
}

// What one view has of a part: the detected ends of the annotated person.
struct Witness {
  int view_idx = 0;
  const Camera* camera = nullptr;
  const Detection* detection = nullptr;
  Ends<const Keypoint*> ends{};
  Ends<Eigen::Vector2d> ideal_px{};
  bool confident = false;

  double RayDistance(const WorldEnds& points_m) const {
    return 0.5 * (DistanceToRay(*camera, ideal_px[0], points_m[0]) +
                  DistanceToRay(*camera, ideal_px[1], points_m[1]));
  }
};

class Auditor {
 public:
  Auditor(const AuditInput& input, const AuditOptions& options)
      : input_(input),
        options_(options),
        to_tum14_truth_(input.truth->header.skeleton, input.pcp->protocol.head),
        to_tum14_(input.tracks->header.skeleton, input.pcp->protocol.head),
        detected_joint_(MapByName(input.detections->header.skeleton, Tum14())) {
    for (const TrackSequence* run : input.held_out) {
      std::map<std::pair<int64_t, int64_t>, TrackId>& people =
          held_out_people_.emplace_back();
      for (const PcpPersonFrame& person :
           EvaluatePcp(*input.truth, *run, input.pcp->protocol).person_frames) {
        if (!person.predicted) continue;
        people[{person.actor, person.frame}] = *person.predicted;
      }
      to_tum14_held_out_.emplace_back(run->header.skeleton,
                                      input.pcp->protocol.head);
    }
  }

  AuditResult Run() {
    AuditResult result;
    result.options = options_;
    for (const PcpPersonFrame& person : input_.pcp->person_frames) {
      OpenFrame(person.frame);
      for (int part = 0; part < kPcpPartCount; ++part) {
        if (person.parts[part] == PartVerdict::kNotCounted || !IsLimb(part)) {
          continue;
        }
        ++result.limbs;
        AskViews(person.actor, person.frame, part, &result);
      }
    }
    for (const LostPart& lost : input_.pcp->lost) {
      result.cases.push_back(Judge(lost));
      result.cases.back().refuted_by_views =
          result.refuted_by_views.count({lost.actor, lost.frame, lost.part}) >
          0;
    }
    return result;
  }

 private:
  // Makes `frame` the one that everything below looks at.
  void OpenFrame(int64_t frame) {
    if (frame_ == frame) return;
    frame_ = frame;
    annotated_.clear();
    true_frame_ = FindFrame(*input_.truth, frame);
    for (const PersonPose& person : true_frame_->people) {
      annotated_[person.id.value()] = to_tum14_truth_(person.joints);
    }
    detections_ = FindDetectionFrame(*input_.detections, frame);
  }

  // Mean distance [px] of a detection from an annotated person over the body
  // joints that are no end of `part`; infinite with too few of them.
  double PersonDistance(const Detection& detection, const Pose3d& annotated,
                        const Camera& camera, int part) const {
    const std::array<int, 2> ends = PcpPartEnds(part);
    double sum = 0.0;
    int64_t count = 0;
    for (int joint = 0; joint < kBodyJoints; ++joint) {
      const int detected = detected_joint_[joint];
      if (joint == ends[0] || joint == ends[1] || detected < 0) continue;
      const Keypoint& keypoint = detection.joints[detected];
      if (!keypoint.found || !annotated[joint].present()) continue;
      const auto px = camera.Project(annotated[joint].position_m);
      if (!px) continue;
      sum += (keypoint.px - *px).norm();
      ++count;
    }
    return count < options_.min_other_joints ? kInfinity
                                             : sum / static_cast<double>(count);
  }

  // The detection of an annotated person in a view, nullptr if there is none.
  const Detection* Choose(int64_t actor, int view, int part) const {
    const Camera& camera = (*input_.cameras)[view];
    double least = camera.width_px() > 0
                       ? options_.max_person_share * camera.width_px()
                       : kInfinity;
    const Detection* chosen = nullptr;
    for (const Detection& detection : detections_->views[view].detections) {
      const double distance =
          PersonDistance(detection, annotated_.at(actor), camera, part);
      if (distance > least || distance == kInfinity) continue;
      bool another = false;
      for (const auto& [other, pose] : annotated_) {
        another = another ||
                  (other != actor &&
                   PersonDistance(detection, pose, camera, part) < distance);
      }
      if (another) continue;
      least = distance;
      chosen = &detection;
    }
    return chosen;
  }

  std::optional<Witness> WitnessOf(int64_t actor, int view, int part) const {
    if (detections_ == nullptr) return std::nullopt;
    Witness witness;
    witness.view_idx = view;
    witness.camera = &(*input_.cameras)[view];
    witness.detection = Choose(actor, view, part);
    if (witness.detection == nullptr) return std::nullopt;
    witness.confident = true;
    for (int end = 0; end < 2; ++end) {
      const int joint = detected_joint_[PcpPartEnds(part)[end]];
      if (joint < 0) {
        witness.confident = false;
        continue;
      }
      witness.ends[end] = &witness.detection->joints[joint];
      const auto ideal_px =
          witness.ends[end]->found
              ? witness.camera->Undistort(witness.ends[end]->px)
              : std::nullopt;
      if (ideal_px) witness.ideal_px[end] = *ideal_px;
      witness.confident =
          witness.confident && ideal_px &&
          witness.ends[end]->confidence >= options_.min_confidence;
    }
    return witness;
  }

  int view_count() const { return static_cast<int>(input_.cameras->size()); }

  // The views' own rule for one annotated limb.
  void AskViews(int64_t actor, int64_t frame, int part, AuditResult* result) {
    std::vector<Witness> witnesses;
    for (int view = 0; view < view_count(); ++view) {
      if (input_.without_views.count(view) > 0) continue;
      const std::optional<Witness> witness = WitnessOf(actor, view, part);
      if (witness && witness->confident) witnesses.push_back(*witness);
    }
    if (static_cast<int64_t>(witnesses.size()) < options_.min_views) return;
    ++result->limbs_seen;
    WorldEnds seen_m;
    for (int end = 0; end < 2; ++end) {
      std::vector<PointMeasurement> measurements;
      for (const Witness& witness : witnesses) {
        measurements.push_back({witness.camera, witness.ideal_px[end], 1.0});
      }
      const TriangulationResult point = TriangulateDlt(measurements);
      if (!point.ok()) return;
      seen_m[end] = point.point_m;
    }
    const WorldEnds truth_m = *EndsOf(annotated_.at(actor), part);
    const double length_m = (truth_m[0] - truth_m[1]).norm();
    for (const Witness& witness : witnesses) {
      if (witness.RayDistance(seen_m) > options_.agree_share * length_m) return;
    }
    ++result->limbs_agreed;
    const double error_m = 0.5 * ((truth_m[0] - seen_m[0]).norm() +
                                  (truth_m[1] - seen_m[1]).norm());
    if (error_m > input_.pcp->protocol.tolerance * length_m) {
      result->refuted_by_views.insert({actor, frame, part});
      if (witnesses.size() >= 3) {
        result->refuted_by_three_views.insert({actor, frame, part});
      }
    }
  }

  static const PersonPose* Find(const TrackFrame* frame, TrackId id) {
    if (frame == nullptr) return nullptr;
    for (const PersonPose& person : frame->people) {
      if (person.id == id) return &person;
    }
    return nullptr;
  }

  // The ends of the estimate made without a view.
  std::optional<WorldEnds> HeldOutEnds(const LostPart& lost, int view) const {
    if (view >= static_cast<int>(input_.held_out.size())) return std::nullopt;
    const auto id = held_out_people_[view].find({lost.actor, lost.frame});
    if (id == held_out_people_[view].end()) return std::nullopt;
    const PersonPose* person =
        Find(FindPredictedFrame(*input_.held_out[view], *true_frame_,
                                input_.pcp->protocol),
             id->second);
    if (person == nullptr) return std::nullopt;
    return EndsOf(to_tum14_held_out_[view](person->joints), lost.part);
  }

  ViewEvidence Examine(const LostPart& lost, int view,
                       const WorldEnds& annotation_m,
                       const WorldEnds& estimate_m) const {
    ViewEvidence evidence;
    evidence.view_idx = view;
    const Camera& camera = (*input_.cameras)[view];
    const std::optional<WorldEnds> held_out_m = HeldOutEnds(lost, view);
    for (int end = 0; end < 2; ++end) {
      evidence.annotation_px[end] = camera.Project(annotation_m[end]);
      evidence.estimate_px[end] = camera.Project(estimate_m[end]);
      if (held_out_m) {
        evidence.held_out_px[end] = camera.Project((*held_out_m)[end]);
      }
    }
    const std::optional<Witness> witness =
        WitnessOf(lost.actor, view, lost.part);
    if (!witness) return evidence;
    evidence.detection_idx = witness->detection->index_in_file;
    for (int end = 0; end < 2; ++end) {
      if (witness->ends[end] == nullptr || !witness->ends[end]->found) continue;
      evidence.confidence[end] = witness->ends[end]->confidence;
      evidence.detected_px[end] = witness->ends[end]->px;
    }
    evidence.verdict = ViewVerdict::kUnsure;
    if (!witness->confident) return evidence;
    evidence.annotation_m = witness->RayDistance(annotation_m);
    evidence.estimate_m = witness->RayDistance(estimate_m);
    evidence.annotation_mean_px =
        MeanPixels(evidence.detected_px, evidence.annotation_px);
    evidence.estimate_mean_px =
        MeanPixels(evidence.detected_px, evidence.estimate_px);
    if (held_out_m) {
      evidence.held_out_m = witness->RayDistance(*held_out_m);
      evidence.held_out_mean_px =
          MeanPixels(evidence.detected_px, evidence.held_out_px);
    }
    evidence.verdict = Compare(evidence.estimate_m / lost.length_m,
                               evidence.annotation_m / lost.length_m);
    return evidence;
  }

  static double MeanPixels(const Ends<std::optional<Eigen::Vector2d>>& a,
                           const Ends<std::optional<Eigen::Vector2d>>& b) {
    double sum = 0.0;
    for (int end = 0; end < 2; ++end) {
      if (!a[end] || !b[end]) return std::numeric_limits<double>::quiet_NaN();
      sum += (*a[end] - *b[end]).norm();
    }
    return 0.5 * sum;
  }

  ViewVerdict Compare(double estimate_share, double annotation_share) const {
    const auto with = [&](double share) {
      return share <= options_.agree_share;
    };
    const auto against = [&](double share) {
      return share > options_.disagree_share;
    };
    if (with(estimate_share) && with(annotation_share)) {
      return ViewVerdict::kBoth;
    }
    if (against(estimate_share) && against(annotation_share)) {
      return ViewVerdict::kNeither;
    }
    if (with(estimate_share) && against(annotation_share)) {
      return ViewVerdict::kEstimate;
    }
    if (against(estimate_share) && with(annotation_share)) {
      return ViewVerdict::kAnnotation;
    }
    return ViewVerdict::kSilent;
  }

  AuditCase Judge(const LostPart& lost) {
    AuditCase judged;
    judged.lost = lost;
    if (!IsLimb(lost.part) || lost.reason() == LossReason::kNobody ||
        lost.reason() == LossReason::kNoJoint) {
      return judged;
    }
    OpenFrame(lost.frame);
    const PersonPose* estimate = Find(
        FindPredictedFrame(*input_.tracks, *true_frame_, input_.pcp->protocol),
        *lost.predicted);
    if (estimate == nullptr) return judged;
    const auto annotation_m = EndsOf(annotated_.at(lost.actor), lost.part);
    const auto estimate_m = EndsOf(to_tum14_(estimate->joints), lost.part);
    if (!annotation_m || !estimate_m) return judged;
    int64_t with_estimate = 0;
    int64_t with_annotation = 0;
    int64_t held_out = 0;
    for (int view = 0; view < view_count(); ++view) {
      if (input_.without_views.count(view) > 0) continue;
      judged.views.push_back(Examine(lost, view, *annotation_m, *estimate_m));
      const ViewEvidence& evidence = judged.views.back();
      with_annotation += evidence.verdict == ViewVerdict::kAnnotation;
      if (evidence.verdict != ViewVerdict::kEstimate) continue;
      ++with_estimate;
      held_out += evidence.held_out_m &&
                  *evidence.held_out_m <= options_.agree_share * lost.length_m;
    }
    judged.verdict = AuditVerdict::kUndecided;
    if (with_estimate > 0 && with_annotation > 0) {
      judged.verdict = AuditVerdict::kDisputed;
    } else if (with_estimate >= options_.min_views) {
      judged.verdict = AuditVerdict::kContradicted;
      judged.held_out_confirmed = held_out >= options_.min_views;
    } else if (with_annotation >= options_.min_views) {
      judged.verdict = AuditVerdict::kEstimateWrong;
    }
    return judged;
  }

  const AuditInput& input_;
  const AuditOptions& options_;
  Tum14Converter to_tum14_truth_;
  Tum14Converter to_tum14_;
  std::vector<Tum14Converter> to_tum14_held_out_;
  std::vector<int> detected_joint_;  // of each joint of Tum14, or -1
  // [view]: actor and frame -> the person of the run without it.
  std::vector<std::map<std::pair<int64_t, int64_t>, TrackId>> held_out_people_;

  // The frame that is open.
  std::optional<int64_t> frame_;
  const TrackFrame* true_frame_ = nullptr;
  std::map<int64_t, Pose3d> annotated_;  // by actor
  const DetectionFrame* detections_ = nullptr;
};

std::set<PartKey> KeysOf(const std::vector<AuditCase>& cases,
                         bool (*wanted)(const AuditCase&)) {
  std::set<PartKey> keys;
  for (const AuditCase& one : cases) {
    if (wanted(one)) {
      keys.insert({one.lost.actor, one.lost.frame, one.lost.part});
    }
  }
  return keys;
}

}  // namespace

void AuditOptions::Describe(OptionVisitor& visitor) {
  visitor.Number("min_confidence", &min_confidence, NonNegative(), "",
                 "of both ends of a part");
  visitor.Number("max_person_share", &max_person_share, Positive(),
                 "of the image width", "of a detection from the annotation");
  visitor.Integer("min_other_joints", &min_other_joints, Between(1, 12),
                  "joints", "that tell whose detection it is");
  visitor.Number("disagree_share", &disagree_share, Positive(),
                 "of the part's length", "beyond it a view does not agree");
  visitor.Number("agree_share", &agree_share, Positive(),
                 "of the part's length", "within it a view agrees");
  visitor.Integer("min_views", &min_views, Between(2, 1000), "views",
                  "that must say the same");
}

const char* ToString(ViewVerdict verdict) {
  static constexpr std::array<const char*, 7> kNames = {
      "no detection", "unsure",   "silent",    "both",
      "neither",      "estimate", "annotation"};
  return kNames[static_cast<size_t>(verdict)];
}

const char* ToString(AuditVerdict verdict) {
  static constexpr std::array<const char*, kAuditVerdictCount> kNames = {
      "not auditable", "undecided", "disputed", "estimate wrong",
      "contradicted"};
  return kNames[static_cast<size_t>(verdict)];
}

std::set<PartKey> AuditResult::Contradicted() const {
  return KeysOf(cases, [](const AuditCase& one) {
    return one.verdict == AuditVerdict::kContradicted;
  });
}

std::set<PartKey> AuditResult::HeldOutConfirmed() const {
  return KeysOf(cases,
                [](const AuditCase& one) { return one.held_out_confirmed; });
}

int64_t AuditResult::Count(AuditVerdict verdict) const {
  return std::count_if(cases.begin(), cases.end(), [&](const AuditCase& one) {
    return one.verdict == verdict;
  });
}

AuditResult AuditAnnotation(const AuditInput& input,
                            const AuditOptions& options) {
  AuditOptions checked = options;
  CheckOptions(checked);
  if (checked.agree_share > checked.disagree_share) {
    throw OptionError("agree_share", "found " +
                                         std::to_string(checked.agree_share) +
                                         ", allowed up to disagree_share");
  }
  return Auditor(input, checked).Run();
}

PcpResult WithoutParts(PcpResult result, const std::set<PartKey>& parts) {
  for (PcpPersonFrame& person : result.person_frames) {
    for (int part = 0; part < kPcpPartCount; ++part) {
      if (parts.count({person.actor, person.frame, part}) > 0) {
        person.parts[part] = PartVerdict::kNotCounted;
      }
    }
  }
  result.lost.erase(
      std::remove_if(
          result.lost.begin(), result.lost.end(),
          [&](const LostPart& lost) {
            return parts.count({lost.actor, lost.frame, lost.part}) > 0;
          }),
      result.lost.end());
  return result;
}

}  // namespace kinegraph
