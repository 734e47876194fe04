#include "core/identity/false_positives.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/median.h"
#include "core/base/time.h"
#include "core/identity/bones.h"

namespace kinegraph {
namespace {

constexpr double kLongestFalsePositive = 0.6;  // s
constexpr double kSettled = 2.0;  // s, of tracks that tell what bones are
// Mean lives of tracks of a person and of a false positive, exponentially
// distributed.
constexpr double kPersonLives = 10.0;         // s
constexpr double kFalsePositiveLives = 0.15;  // s
// Spread of the log ratio of a bone, measured in a few frames, to that of the
// recording's people: of a body (stature, bone and the error of few frames),
// and of unrelated joints.
constexpr double kBodySigma = 0.06;
constexpr double kFewFrames = 0.035;  // m
constexpr double kNobodySigma = 0.45;

double Life(const Tracklet& track) {
  return ToSeconds(track.last().time - track.first().time);
}

using Lengths = std::vector<std::vector<double>>;  // [bone], logarithms

// The median over the people who are there for long; nullopt without any.
std::vector<std::optional<double>> TypicalLengths(
    const std::vector<Tracklet>& tracks, const std::vector<Lengths>& lengths) {
  std::vector<std::optional<double>> typical(lengths.front().size());
  for (size_t bone = 0; bone < typical.size(); ++bone) {
    std::vector<double> medians;
    for (size_t t = 0; t < tracks.size(); ++t) {
      if (Life(tracks[t]) < kSettled || lengths[t][bone].empty()) continue;
      medians.push_back(Median(lengths[t][bone]));
    }
    if (!medians.empty()) typical[bone] = Median(std::move(medians));
  }
  return typical;
}

// Log likelihood ratio [nats] of unrelated joints to a body, from the bones;
// nullopt when none was measured.
std::optional<double> NobodyByBones(
    const Lengths& lengths, const std::vector<std::optional<double>>& typical) {
  double nats = 0.0;
  bool measured = false;
  for (size_t bone = 0; bone < lengths.size(); ++bone) {
    if (lengths[bone].empty() || !typical[bone].has_value()) continue;
    const double x = Median(lengths[bone]) - *typical[bone];
    const double body =
        std::hypot(kBodySigma, kFewFrames / std::exp(*typical[bone]));
    nats += 0.5 * x * x *
                (1.0 / (body * body) - 1.0 / (kNobodySigma * kNobodySigma)) -
            std::log(kNobodySigma / body);
    measured = true;
  }
  if (!measured) return std::nullopt;
  return nats;
}

double NobodyByLife(double life_s) {
  return std::log(kPersonLives / kFalsePositiveLives) -
         life_s * (1.0 / kFalsePositiveLives - 1.0 / kPersonLives);
}

}  // namespace

std::vector<IdentityEdit> FindFalsePositives(
    const Skeleton& skeleton, double min_margin,
    const std::vector<Tracklet>& tracks) {
  std::vector<IdentityEdit> edits;
  if (tracks.empty()) return edits;
  const BoneModel bones(skeleton);
  std::vector<Lengths> lengths;
  for (const Tracklet& track : tracks) {
    lengths.push_back(bones.LogLengths(track));
  }
  const auto typical = TypicalLengths(tracks, lengths);
  for (size_t t = 0; t < tracks.size(); ++t) {
    const double life_s = Life(tracks[t]);
    if (life_s > kLongestFalsePositive) continue;
    const std::optional<double> by_bones = NobodyByBones(lengths[t], typical);
    if (!by_bones.has_value()) continue;
    const double by_life = NobodyByLife(life_s);
    if (*by_bones < 0.0 || *by_bones + by_life < min_margin) continue;
    IdentityEdit edit;
    edit.op = EditOp::kDelete;
    edit.persons = {tracks[t].id};
    edit.frames = FrameSpan{tracks[t].first().frame, tracks[t].last().frame};
    edit.evidence = {{"nobody_by_bones", *by_bones},
                     {"nobody_by_life", by_life}};
    edit.margin = *by_bones + by_life;
    edits.push_back(std::move(edit));
  }
  return edits;
}

}  // namespace kinegraph
