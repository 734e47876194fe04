#include "apps/report/page_data.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "apps/report/moments.h"
#include "apps/report/page.h"
#include "apps/report/pairing.h"
#include "apps/report/pose_arrays.h"
#include "core/base/error.h"
#include "core/io/text/json.h"
#include "core/kinematics/ground.h"
#include "core/kinematics/kinematics.h"
#include "core/skeleton/body_joints.h"
#include "solvers/session/subject_gauge.h"
#include "solvers/session/subject_scale.h"

namespace kinegraph {
namespace {

constexpr double kAngleQuantumDeg = 0.1;
constexpr int16_t kNoAngle = -32768;
constexpr size_t kMomentsOfAKind = 8;
constexpr size_t kMaxStartsAndEnds = 60;
constexpr int kMaxExtrasStride = 64;

// The frames of all tracks, each once. Frames that only the ground truth has
// are not shown.
std::map<int64_t, TimeNs> ClockOf(const PageInput& input) {
  std::map<int64_t, TimeNs> clock;
  for (const PageResult& result : input.results) {
    if (result.role != ResultRole::kTracks) continue;
    for (const TrackFrame& frame : result.tracks.frames) {
      clock.emplace(frame.frame, frame.time);
    }
  }
  return clock;
}

// If the times do not ascend, replaces them by those of an assumed frame rate.
// Returns whether they were replaced.
bool RepairTimes(std::map<int64_t, TimeNs>* clock) {
  TimeNs last = 0;
  bool ascends = true;
  for (auto at = clock->begin(); at != clock->end(); ++at) {
    ascends = ascends && (at == clock->begin() || at->second > last);
    last = at->second;
  }
  if (ascends) return false;
  for (auto& [frame, time] : *clock) {
    time = FromSeconds(static_cast<double>(frame) / kFallbackRateHz);
  }
  return true;
}

Json ToJson(const Skeleton& skeleton) {
  Json bones = Json::array();
  for (const Bone& bone : skeleton.bones()) bones.push_back({bone.a, bone.b});
  return {{"joints", skeleton.joints()}, {"bones", bones}};
}

template <typename Derived>
Json Numbers(const Eigen::DenseBase<Derived>& matrix) {
  Json numbers = Json::array();
  for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) {
      numbers.push_back(matrix(r, c));
    }
  }
  return numbers;
}

Json ToJson(const Camera& camera, const std::string& view) {
  Json json = {
      {"name", camera.name()},      {"view", view},
      {"width", camera.width_px()}, {"height", camera.height_px()},
      {"K", Numbers(camera.K())},   {"R", Numbers(camera.R())},
      {"t", Numbers(camera.t())},   {"centre", Numbers(camera.centre())},
      {"model", "pinhole"},         {"distortion", Json::array()}};
  if (camera.lens() != nullptr) {
    json["model"] = camera.lens()->model();
    json["distortion"] = camera.lens()->parameters();
  }
  return json;
}

// Intermediate data for one result.
struct ResultWork {
  std::map<TrackId, uint16_t> person_of;  // index into the page's ids
  // Pairs people with detections; none for the truth or without detections.
  std::optional<DetectionPairing> pairing;
  std::vector<std::vector<double>> differences;  // [frame][person], < 0: none
  PoseArrays arrays;
  std::vector<Moment> residuals;
  std::vector<Moment> apart;
};

// The view with the greatest error of a person's projection.
Moment WorstView(const TrackFrame& frame, const PersonPose& person, TimeNs time,
                 const std::vector<ViewPair>& pairs,
                 const std::vector<std::string>& view_names) {
  Moment worst{MomentKind::kResidual, frame.frame, time, person.id, 0.0, ""};
  for (size_t v = 0; v < pairs.size(); ++v) {
    const double residual = pairs[v].residual_px.value_or(0.0);
    if (residual <= worst.value) continue;
    worst.value = residual;
    worst.detail = view_names[v];
  }
  return worst;
}

// The length of an encoded array.
size_t TextBytes(const Json& text) {
  return text.get_ref<const std::string&>().size();
}

// The identity of the person `id` after the joins among the edits from `index`
// on.
TrackId InTheEnd(const std::vector<IdentityEdit>& edits, size_t index,
                 TrackId id) {
  for (size_t e = index; e < edits.size(); ++e) {
    const bool joins = edits[e].op == EditOp::kJoin;
    if (joins && edits[e].persons.size() == 2 && edits[e].persons[1] == id) {
      id = edits[e].persons[0];
    }
  }
  return id;
}

void AddIdentity(const PageResult& result, Json* json) {
  const std::vector<IdentityEdit>& edits = result.identity_edits;
  Json list = Json::array();
  for (size_t e = 0; e < edits.size(); ++e) {
    Json edit = {{"op", ToString(edits[e].op)}};
    for (const TrackId id : edits[e].persons) {
      edit["persons"].push_back(std::to_string(id.value()));
      edit["now"].push_back(std::to_string(InTheEnd(edits, e, id).value()));
    }
    if (edits[e].frames.has_value()) {
      edit["frames"] = {edits[e].frames->first, edits[e].frames->last};
    }
    if (edits[e].margin.has_value()) edit["margin"] = *edits[e].margin;
    if (!edits[e].name.empty()) edit["name"] = edits[e].name;
    list.push_back(std::move(edit));
  }
  (*json)["edits"] = std::move(list);
  (*json)["identityLines"] = result.identity_lines;
}

class PageMaker {
 public:
  // `metre`: metres of the world per unit of the input's lengths.
  PageMaker(const PageInput& input, const PageOptions& options, double metre)
      : input_(input),
        options_(options),
        metre_(metre),
        clock_(ClockOf(input)) {
    if (clock_.empty()) {
      throw InputError("--tracks: there is no frame to show");
    }
    assumed_rate_ = RepairTimes(&clock_);
    if (input.detections.has_value()) {
      for (const DetectionFrame& frame : input.detections->frames) {
        detections_[frame.frame] = &frame;
      }
    }
  }

  PageData Make();

 private:
  void ChooseStrides();
  bool HasExtras(size_t clock_idx) const {
    return clock_idx % static_cast<size_t>(data_.extras_stride) == 0;
  }
  std::optional<size_t> ReferenceOf(size_t r) const;
  Json ResultJson(size_t r);
  ResultWork WorkOf(size_t r) const;
  void AddFrame(const TrackFrame& frame, const std::vector<double>* differences,
                ResultWork* work);
  void AddResultMoments(size_t r, ResultWork* work);
  void AddAngles(const TrackSequence& tracks, Json* json);
  void AddMoments(size_t r, std::vector<Moment> moments);
  Json DetectionsJson() const;
  // The cameras with their images and videos.
  Json CamerasJson();
  void FindUp(const TrackSequence& lead);
  Json PicturesJson(const std::map<int64_t, std::string>& pictures);
  Json VideoJson(const PageVideo& video);
  size_t view_count() const {
    return input_.detections.has_value() ? input_.cameras.size() : 0;
  }

  const PageInput& input_;
  const PageOptions& options_;
  const double metre_;
  std::map<int64_t, TimeNs> clock_;
  bool assumed_rate_ = false;  // the times do not ascend
  std::map<int64_t, const DetectionFrame*> detections_;
  std::map<int64_t, uint32_t> index_;  // of the kept frames
  UpEvidence up_evidence_;
  Eigen::Vector3d up_ = Eigen::Vector3d::UnitZ();  // as drawn
  bool up_is_known_ = true;
  std::vector<Colours> colours_;
  Json moments_ = Json::array();
  PageData data_;
};

// Estimates sizes in bytes before Base64, which adds a third. The numbers of
// bytes are those of PoseArrays, AddAngles and DetectionsJson.
void PageMaker::ChooseStrides() {
  double poses = 0.0;
  double extras = 0.0;
  for (const PageResult& result : input_.results) {
    const auto joints =
        static_cast<double>(result.tracks.header.skeleton.joint_count());
    const auto views = static_cast<double>(view_count());
    for (const TrackFrame& frame : result.tracks.frames) {
      if (clock_.count(frame.frame) == 0) continue;
      const auto people = static_cast<double>(frame.people.size());
      // Angles of 2 bytes (AnglesOf): a body without feet has 16. One with feet
      // has 18, for which 16 is near enough.
      constexpr double kAngles = 16.0;
      poses += people * (20.0 + 2.0 * kAngles + 7.0 * joints + 2.0 * views);
      if (options_.with_covariance) poses += people * 4.0 * kAngles;
      extras += people * views * (2.0 + joints);
      if (options_.with_covariance) extras += people * 12.0 * joints;
    }
  }
  for (const auto& [number, frame] : detections_) {
    if (clock_.count(number) == 0) continue;
    for (const ViewDetections& view : frame->views) {
      for (const Detection& detection : view.detections) {
        extras += 5.0 * static_cast<double>(detection.joints.size());
      }
    }
  }
  const double budget = 0.75 * static_cast<double>(options_.max_bytes);
  const double left = std::max(budget - poses, budget / 8.0);
  data_.extras_stride = static_cast<int>(
      std::clamp(std::ceil(extras / left), 1.0, double{kMaxExtrasStride}));
  const double rest = poses + extras / data_.extras_stride;
  data_.frame_stride =
      static_cast<int>(std::max(1.0, std::ceil(rest / budget)));
}

// A moment is shown at the last kept frame that is not after it.
void PageMaker::AddMoments(size_t r, std::vector<Moment> moments) {
  for (const Moment& moment : moments) {
    if (clock_.count(moment.frame) == 0) continue;
    const auto after = index_.upper_bound(moment.frame);
    const uint32_t at = std::prev(after)->second;
    moments_.push_back({{"kind", ToString(moment.kind)},
                        {"at", at},
                        {"frame", moment.frame},
                        {"result", r},
                        {"id", std::to_string(moment.id.value())},
                        {"value", moment.value},
                        {"detail", moment.detail}});
  }
}

// What a result is compared with: the ground truth if there is one, otherwise
// the first result (the second one for the first result itself).
std::optional<size_t> PageMaker::ReferenceOf(size_t r) const {
  if (input_.results[r].role == ResultRole::kGroundTruth) return std::nullopt;
  for (size_t other = 0; other < input_.results.size(); ++other) {
    if (input_.results[other].role == ResultRole::kGroundTruth) return other;
  }
  if (input_.results.size() < 2) return std::nullopt;
  return r == 0 ? 1 : 0;
}

ResultWork PageMaker::WorkOf(size_t r) const {
  const PageResult& result = input_.results[r];
  ResultWork work{{}, {}, {}, PoseArrays(result.tracks, view_count()), {}, {}};
  for (const TrackId id : colours_[r].ids()) {
    const auto index = static_cast<uint16_t>(work.person_of.size());
    work.person_of[id] = index;
  }
  if (input_.detections.has_value() && result.role == ResultRole::kTracks) {
    work.pairing.emplace(result.tracks.header, input_.detections->header,
                         input_.cameras);
  }
  if (const auto reference = ReferenceOf(r)) {
    work.differences =
        DifferencesTo(input_.results[*reference].tracks, result.tracks);
  }
  return work;
}

// Moments are searched in every frame, also in frames that the page leaves out.
void PageMaker::AddFrame(const TrackFrame& frame,
                         const std::vector<double>* differences,
                         ResultWork* work) {
  const auto clock_at = clock_.find(frame.frame);
  if (clock_at == clock_.end()) return;
  std::vector<std::vector<ViewPair>> pairs(frame.people.size(),
                                           std::vector<ViewPair>(view_count()));
  const auto seen = detections_.find(frame.frame);
  if (work->pairing.has_value() && seen != detections_.end()) {
    pairs = work->pairing->Pair(frame, *seen->second);
  }
  const auto kept = index_.find(frame.frame);
  for (size_t p = 0; p < frame.people.size(); ++p) {
    const PersonPose& person = frame.people[p];
    if (view_count() > 0) {
      Moment worst = WorstView(frame, person, clock_at->second, pairs[p],
                               input_.detections->header.view_names);
      if (worst.value > 0.0) work->residuals.push_back(std::move(worst));
    }
    const double* difference =
        differences == nullptr ? nullptr : &(*differences)[p];
    if (difference != nullptr && *difference >= 0.0) {
      work->apart.push_back({MomentKind::kDifference, frame.frame,
                             clock_at->second, person.id, *difference, ""});
    }
    if (kept == index_.end()) continue;
    PoseArrays& arrays = work->arrays;
    arrays.Add(person, kept->second, work->person_of.at(person.id));
    if (work->pairing.has_value()) arrays.AddResiduals(pairs[p]);
    if (difference != nullptr) arrays.AddDifference(*difference);
    if (!HasExtras(kept->second)) continue;
    if (work->pairing.has_value()) {
      arrays.AddMatches(person, pairs[p], *work->pairing);
    }
    if (options_.with_covariance) arrays.AddCovariances(person);
  }
}

void PageMaker::AddResultMoments(size_t r, ResultWork* work) {
  const TrackSequence& tracks = input_.results[r].tracks;
  AddMoments(r, Largest(std::move(work->residuals), kMomentsOfAKind));
  AddMoments(r, Largest(SpeedJumps(tracks), kMomentsOfAKind));
  AddMoments(r, Largest(BoneDeviations(tracks), kMomentsOfAKind));
  std::vector<Moment> lives = StartsAndEnds(tracks);
  if (lives.size() > kMaxStartsAndEnds) lives.resize(kMaxStartsAndEnds);
  AddMoments(r, std::move(lives));
  AddMoments(r, Largest(std::move(work->apart), kMomentsOfAKind));
}

Json PageMaker::ResultJson(size_t r) {
  const PageResult& result = input_.results[r];
  const bool is_tracks = result.role == ResultRole::kTracks;
  colours_.emplace_back(result.tracks,
                        r == 0 ? nullptr : &input_.results[0].tracks,
                        r == 0 ? nullptr : &colours_[0]);
  Json ids = Json::array();
  Json colour_list = Json::array();
  for (const TrackId id : colours_[r].ids()) {
    ids.push_back(std::to_string(id.value()));
    colour_list.push_back(colours_[r].ColourOf(id));
  }
  ResultWork work = WorkOf(r);
  for (size_t f = 0; f < result.tracks.frames.size(); ++f) {
    AddFrame(result.tracks.frames[f],
             work.differences.empty() ? nullptr : &work.differences[f], &work);
  }
  data_.poses += work.arrays.count();
  if (is_tracks) AddResultMoments(r, &work);

  Json json = {{"label", result.label},
               {"role", is_tracks ? "tracks" : "truth"},
               {"mode", result.tracks.header.mode},
               {"skeleton", ToJson(result.tracks.header.skeleton)},
               {"ids", ids},
               {"colours", colour_list}};
  work.arrays.PosesTo(&json);
  for (const auto& [id, name] : result.names) {
    json["names"][std::to_string(id.value())] = name;
  }
  if (is_tracks) AddIdentity(result, &json);
  if (!result.summary_json.empty()) {
    // An unreadable summary must not prevent the page.
    try {
      json["summary"] = ReadSummaryJson(result.summary_json,
                                        "the summary of " + result.label);
    } catch (const InputError& error) {
      data_.notes.push_back("left out: " + std::string(error.what()));
    }
  }
  work.arrays.DetailsTo(&json, &data_);
  AddAngles(result.tracks, &json);
  return json;
}

// Adds {"names": [...], "quantum": degrees, "values": [Base64 per name], "low",
// "high"}: the angles of each pose on the page, with intervals if covariances
// are requested.
void PageMaker::AddAngles(const TrackSequence& tracks, Json* json) {
  KinematicsOptions options;
  if (up_is_known_) options.up = up_;
  options.known = up_evidence_;
  const KinematicsTable table = MeasureKinematics(tracks, options);
  Json names = Json::array();
  std::map<std::string, Json> lists;
  for (const std::string& angle : table.angles) {
    names.push_back(angle);
    for (const std::string end : {"", "_low", "_high"}) {
      const int column = table.IndexOf(angle + end + "_deg");
      if (column < 0 || (!end.empty() && !options_.with_covariance)) continue;
      std::vector<int16_t> values;
      for (const KinematicsRow& row : table.rows) {
        if (index_.count(row.frame) == 0) continue;
        const double value = row.values[static_cast<size_t>(column)];
        values.push_back(std::isfinite(value)
                             ? Quantise<int16_t>(value, kAngleQuantumDeg)
                             : kNoAngle);
      }
      lists[end.empty() ? "values" : end.substr(1)].push_back(Base64(values));
    }
  }
  if (names.empty()) return;
  Json angles = {{"names", names}, {"quantum", kAngleQuantumDeg}};
  for (const auto& [name, list] : lists) {
    angles[name] = list;
    if (name == "values") continue;
    for (const Json& text : list) data_.covariance_bytes += TextBytes(text);
  }
  (*json)["angles"] = angles;
}

Json PageMaker::DetectionsJson() const {
  const DetectionHeader& header = input_.detections->header;
  double largest = 1.0;
  for (const auto& [number, frame] : detections_) {
    for (const ViewDetections& view : frame->views) {
      for (const Detection& detection : view.detections) {
        for (const Keypoint& joint : detection.joints) {
          if (joint.found) largest = std::max(largest, joint.px.maxCoeff());
        }
      }
    }
  }
  // Coordinates are stored as unsigned integers, so joints to the left of or
  // above the image appear at its edge.
  const double quantum = std::max(0.1, largest / 65000.0);
  std::vector<uint16_t> counts;
  std::vector<uint16_t> xy;
  std::vector<uint8_t> confidence;
  for (const auto& [number, idx] : index_) {
    const auto at = detections_.find(number);
    for (size_t v = 0; v < input_.cameras.size(); ++v) {
      counts.push_back(0);
      if (!HasExtras(idx) || at == detections_.end()) continue;
      for (const Detection& detection : at->second->views[v].detections) {
        ++counts.back();
        for (const Keypoint& joint : detection.joints) {
          xy.push_back(Quantise<uint16_t>(joint.px.x(), quantum));
          xy.push_back(Quantise<uint16_t>(joint.px.y(), quantum));
          confidence.push_back(
              joint.found ? static_cast<uint8_t>(std::clamp(
                                1.0 + 254.0 * joint.confidence, 1.0, 255.0))
                          : uint8_t{0});
        }
      }
    }
  }
  return {{"skeleton", ToJson(header.skeleton)},
          {"quantum", quantum},
          {"counts", Base64(counts)},
          {"xy", Base64(xy)},
          {"confidence", Base64(confidence)}};
}

// {"at": [indices of kept frames], "base64": [JPEG or PNG]}; frames that are
// not on the page are left out.
Json PageMaker::PicturesJson(const std::map<int64_t, std::string>& pictures) {
  Json json = {{"at", Json::array()}, {"base64", Json::array()}};
  for (const auto& [number, bytes] : pictures) {
    const auto at = index_.find(number);
    if (at == index_.end()) continue;
    json["at"].push_back(at->second);
    json["base64"].push_back(Base64(bytes));
    data_.picture_bytes += TextBytes(json["base64"].back());
  }
  return json;
}

// The time of a frame in the video is the middle of the interval in which its
// image is shown, so that rounding cannot select another one; -1: none.
Json PageMaker::VideoJson(const PageVideo& video) {
  std::vector<double> at_s;
  const auto pictures = static_cast<int64_t>(video.times_s.size()) - 1;
  for (const auto& [number, index] : index_) {
    const int64_t i = number - video.first_frame;
    const auto at = static_cast<size_t>(i);
    at_s.push_back(i < 0 || i >= pictures
                       ? -1.0
                       : 0.5 * (video.times_s[at] + video.times_s[at + 1]));
  }
  Json json = {{"type", video.type}, {"at", Base64(at_s)}};
  if (!video.source.empty()) {
    json["source"] = video.source;
    return json;
  }
  json["data"] = Base64(video.bytes);
  data_.picture_bytes += TextBytes(json["data"]);
  return json;
}

Json PageMaker::CamerasJson() {
  Json cameras = Json::array();
  for (size_t v = 0; v < input_.cameras.size(); ++v) {
    const Camera& camera = input_.cameras[v];
    cameras.push_back(
        ToJson(camera, input_.detections.has_value()
                           ? input_.detections->header.view_names[v]
                           : camera.name()));
    if (v < input_.image_patterns.size() && !input_.image_patterns[v].empty()) {
      cameras.back()["images"] = input_.image_patterns[v];
    }
    if (v < input_.pictures.size() && !input_.pictures[v].empty()) {
      cameras.back()["pictures"] = PicturesJson(input_.pictures[v]);
    }
    if (v < input_.videos.size() && input_.videos[v].has_value()) {
      cameras.back()["video"] = VideoJson(*input_.videos[v]);
    }
  }
  return cameras;
}

void PageMaker::FindUp(const TrackSequence& lead) {
  const auto up =
      options_.up.has_value() ? options_.up : UpDirection(lead, up_evidence_);
  up_is_known_ = up.has_value();
  if (up_is_known_) {
    up_ = *up;
    return;
  }
  const Eigen::Vector3d& cameras = up_evidence_.of_cameras;
  if (cameras.norm() > 0.0) up_ = cameras.normalized();
  if (!IsHuman(lead.header.skeleton)) return;
  data_.notes.emplace_back(
      "the people do not determine which direction is up: the page draws the "
      "cameras' up direction, else z, upwards and omits angles that depend on "
      "the up direction (set it with --up=z)");
}

PageData PageMaker::Make() {
  ChooseStrides();
  std::vector<double> numbers;
  std::vector<double> times_s;
  size_t position = 0;
  for (const auto& [number, time] : clock_) {
    if (position++ % static_cast<size_t>(data_.frame_stride) != 0) continue;
    index_[number] = static_cast<uint32_t>(numbers.size());
    numbers.push_back(static_cast<double>(number));
    times_s.push_back(ToSeconds(time));
  }
  data_.frames = numbers.size();

  const TrackSequence& lead = input_.results[0].tracks;
  up_evidence_ = {options_.stated_up, UpOfCameras(input_.cameras)};
  FindUp(lead);
  Json page = {{"title", input_.title},
               {"frames", Base64(numbers)},
               {"times", Base64(times_s)},
               {"metre", metre_},
               {"who", IsHuman(lead.header.skeleton) ? "person" : "track"},
               {"up", Numbers(up_)},
               {"floor", FloorHeight(lead, up_)},
               {"assumedRate", assumed_rate_ ? kFallbackRateHz : 0.0},
               {"frameStride", data_.frame_stride},
               {"extrasStride", data_.extras_stride},
               {"cameras", CamerasJson()},
               {"results", Json::array()}};
  colours_.reserve(input_.results.size());
  for (size_t r = 0; r < input_.results.size(); ++r) {
    page["results"].push_back(ResultJson(r));
  }
  if (input_.detections.has_value()) {
    page["detections"] = DetectionsJson();
    for (const char* key : {"counts", "xy", "confidence"}) {
      data_.detection_bytes += TextBytes(page["detections"][key]);
    }
  }
  page["moments"] = moments_;
  if (!input_.doctor_json.empty()) {
    page["doctor"] = ReadDoctorJson(input_.doctor_json, "doctor.json");
    LeaveOutMended(lead.header.config_json, &page["doctor"]);
  }
  page["bytes"] = {{"detections", data_.detection_bytes},
                   {"covariances", data_.covariance_bytes},
                   {"pictures", data_.picture_bytes}};
  data_.moments = moments_.size();
  data_.json = WithoutAngleBrackets(DumpJson(page));
  return std::move(data_);
}

}  // namespace

PageData MakePageData(const PageInput& input, const PageOptions& options) {
  // The page draws and quantises in the run's unit of length, in which subjects
  // have the size of people; its scripts convert lengths that they show.
  const SubjectScale scale = input.results.empty()
                                 ? SubjectScale()
                                 : ScaleOf(input.results.front().tracks);
  if (scale.is_one()) return PageMaker(input, options, 1.0).Make();
  PageInput scaled = input;
  scaled.cameras = scale.IntoRun(scaled.cameras);
  for (PageResult& result : scaled.results) {
    for (TrackFrame& frame : result.tracks.frames) {
      frame = scale.IntoRun(std::move(frame));
    }
  }
  return PageMaker(scaled, options, scale.metres()).Make();
}

}  // namespace kinegraph
