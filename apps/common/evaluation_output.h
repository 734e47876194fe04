// Formats results of core/evaluation as tables for users and JSON for scripts.
#ifndef KINEGRAPH_APPS_COMMON_EVALUATION_OUTPUT_H_
#define KINEGRAPH_APPS_COMMON_EVALUATION_OUTPUT_H_

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/data/stance.h"
#include "core/evaluation/cameras.h"
#include "core/evaluation/held_out.h"
#include "core/evaluation/identity.h"
#include "core/evaluation/motion.h"
#include "core/evaluation/mpjpe.h"
#include "core/evaluation/panoptic.h"
#include "core/evaluation/parity.h"
#include "core/evaluation/pcp.h"
#include "core/io/text/json.h"

namespace kinegraph {

// The same result in two forms. In JSON lengths are metres or pixels, as the
// key specifies; a Share is written as counts with their percentage, a key that
// ends in "percent" is one, and other scores (such as HOTA and average
// precision) are fractions; undefined values are null.
struct EvaluationOutput {
  std::string text;
  Json json;
};

// Percentages with counts; the means over the protocol's headline_actors and
// each actor's total with confidence intervals. `list_lost` adds every
// incorrect part to the text (the JSON always has them).
EvaluationOutput DescribePcp(const PcpResult& result, bool list_lost);
EvaluationOutput DescribeParity(const ParityResult& result,
                                const ParityOptions& options,
                                const Skeleton& reference_skeleton);
EvaluationOutput DescribeMpjpe(const MpjpeResult& result);
// PA-MPJPE and PCK, also part of DescribeMpjpe.
EvaluationOutput DescribePck(const MpjpeResult& result);
EvaluationOutput DescribeCameras(const CameraResult& result);
EvaluationOutput DescribeIdentity(const IdentityResult& result);
EvaluationOutput DescribePanoptic(const PanopticResult& result,
                                  const PanopticOptions& options);
EvaluationOutput DescribeMotion(const MotionResult& result);
// Empty text and null if there are no covariances.
EvaluationOutput DescribeConsistency(const ConsistencyResult& result);
EvaluationOutput DescribeCoverage(const Share& covered);
// Rows: all joints, all joints but the face, each joint class and each view;
// those without scored joints are left out.
EvaluationOutput DescribeHeldOut(const HeldOutScores& scores,
                                 const std::vector<std::string>& view_names);

// The up direction of a ground truth's world: -y for CMU Panoptic, whose y axis
// points down, else UpDirection or, if that is unknown, z.
Eigen::Vector3d UpOfTruth(const TrackSequence& truth,
                          const UpEvidence& known = {});

// Helpers shared with other tables.
std::string ActorName(int64_t actor);         // "actor 0"
std::string PercentCell(const Share& share);  // "99.71 (2782/2790)"
Json ToJson(const Interval& interval);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_EVALUATION_OUTPUT_H_
