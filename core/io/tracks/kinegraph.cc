// kinegraph's own format of tracks, JSON Lines: a header line, then one line
// per frame.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/data/checks.h"
#include "core/data/limits.h"
#include "core/geometry/ball_probability.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/skeleton_json.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"
#include "core/io/tracks/writer.h"

namespace kinegraph {

// ---- Writing ----

class TrackWriter::Impl {
 public:
  Impl(const std::string& path, const TrackHeader& header,
       const TrackWriteOptions& options)
      : options_(options),
        joint_count_(header.skeleton.joints().size()),
        file_(path) {
    for (const std::string& name : header.view_names) {
      views_.push_back(JsonText(name));
    }
    CheckFrameRate(header.frame_rate_hz, "frame_rate");
    WriteHeader(header);
  }

  void Write(const TrackFrame& frame) {
    if (frame.frame <= last_frame_) {
      throw std::logic_error("tracks of frame " + std::to_string(frame.frame) +
                             " come after those of frame " +
                             std::to_string(last_frame_));
    }
    if (frame.frame > kMaxFrame) {
      throw InputError("frame " + std::to_string(frame.frame) +
                       ": is out of range, expected 0 .. 2^50");
    }
    last_frame_ = frame.frame;
    out_.Add("{\"frame\": ", frame.frame, ", \"time\": ", ToSeconds(frame.time),
             ", \"people\": [");
    out_.Join(frame.people,
              [this](const PersonPose& person) { WritePerson(person); });
    out_.Text("]}\n");
    out_.FlushTo(&file_);
  }

  void Commit() { file_.Commit(); }
  void HandOver() { file_.Flush(); }

 private:
  void WriteHeader(const TrackHeader& header) {
    const std::string config = CompactObject(header.config_json);
    if (config.empty()) {
      throw std::logic_error("the configuration of tracks is no JSON object");
    }
    out_.Add(
        "{\"kinegraph\": 1, \"units\": {\"length\": \"m\", \"time\": \"s\"}, "
        "\"skeleton\": ",
        SkeletonJson(header.skeleton), ", \"mode\": ", JsonText(header.mode),
        ", \"frame_rate\": ");
    header.frame_rate_hz > 0.0 ? out_.Number(header.frame_rate_hz)
                               : out_.Text("null");
    if (options_.observations) {
      out_.Text(", \"views\": ");
      WriteArray(views_, [this](const std::string& view) { out_.Text(view); });
    }
    WriteNames();
    if (!options_.titles.empty()) {
      out_.Text(", \"titles\": ");
      WriteArray(options_.titles, [this](const std::string& title) {
        out_.Text(JsonText(title));
      });
    }
    out_.Add(", \"config\": ", config, "}\n");
    out_.FlushTo(&file_);
  }

  void WriteNames() {
    if (options_.names.empty()) return;
    out_.Text(", \"names\": {");
    out_.Join(options_.names, [this](const auto& named) {
      out_.Add("\"", named.first.value(), "\": ", JsonText(named.second));
    });
    out_.Text("}");
  }

  void WritePerson(const PersonPose& person) {
    CheckLength(person.joints.size());
    out_.Add("{\"id\": ", person.id.value(), ", \"joints\": ");
    WriteArray(person.joints, [this](const Joint3d& joint) {
      if (!joint.present()) return out_.Text("null");
      const Eigen::Vector3d& at_m = joint.position_m;
      WriteNumbers({at_m.x(), at_m.y(), at_m.z()});
    });
    out_.Text(", \"status\": ");
    WriteArray(person.joints, [this](const Joint3d& joint) {
      out_.Add("\"", ToString(joint.status), "\"");
    });
    WriteCovariances(person);
    if (options_.within_m > 0.0) WriteWithin(person);
    if (!person.inlier_views.empty()) {
      CheckLength(person.inlier_views.size());
      out_.Text(", \"views\": ");
      WriteArray(person.inlier_views,
                 [this](int count) { out_.Integer(count); });
    }
    if (options_.observations) WriteObservations(person);
    out_.Text("}");
  }

  void WriteCovariances(const PersonPose& person) {
    const auto& covariances = person.covariances;
    if (std::none_of(covariances.begin(), covariances.end(),
                     [](const auto& c) { return c.has_value(); })) {
      return;
    }
    CheckLength(covariances.size());
    out_.Text(", \"covariance\": ");
    WriteArray(covariances, [this](const std::optional<Eigen::Matrix3d>& c) {
      if (!c) return out_.Text("null");
      WriteNumbers({(*c)(0, 0), (*c)(0, 1), (*c)(0, 2), (*c)(1, 1), (*c)(1, 2),
                    (*c)(2, 2)});
    });
  }

  void WriteWithin(const PersonPose& person) {
    if (person.covariances.empty()) return;
    out_.Text(", \"within\": ");
    WriteArray(person.covariances,
               [this](const std::optional<Eigen::Matrix3d>& c) {
                 if (!c) return out_.Text("null");
                 out_.Number(ProbabilityWithin(options_.within_m, *c));
               });
  }

  void WriteObservations(const PersonPose& person) {
    out_.Add(", \"score\": ", person.score, ", \"matches\": {");
    out_.Join(person.matches, [this](const ViewMatch& match) {
      out_.Add(ViewOf(match), ": ", match.detection_idx);
    });
    out_.Text("}, \"weights\": {");
    const char* separator = "";
    for (const ViewMatch& match : person.matches) {
      if (match.weights.empty()) continue;
      CheckLength(match.weights.size());
      out_.Add(separator, ViewOf(match), ": ");
      separator = ", ";
      WriteArray(match.weights, [this](const std::optional<double>& weight) {
        weight ? out_.Number(*weight) : out_.Text("null");
      });
    }
    out_.Text("}");
  }

  const std::string& ViewOf(const ViewMatch& match) const {
    const auto view_idx = static_cast<size_t>(match.view_idx);
    if (match.view_idx < 0 || view_idx >= views_.size()) {
      throw std::logic_error(
          "a match names a view that the tracks do not have");
    }
    return views_[view_idx];
  }

  template <typename Values, typename WriteValue>
  void WriteArray(const Values& values, const WriteValue& write_value) {
    out_.Text("[");
    out_.Join(values, write_value);
    out_.Text("]");
  }

  void WriteNumbers(std::initializer_list<double> numbers) {
    out_.Text("[");
    out_.Numbers(numbers);
    out_.Text("]");
  }

  void CheckLength(size_t found) const {
    if (found != joint_count_) {
      throw std::logic_error("a person does not have the joints of its tracks");
    }
  }

  const TrackWriteOptions options_;
  const size_t joint_count_;
  AtomicFile file_;
  std::vector<std::string> views_;  // quoted
  int64_t last_frame_ = -1;
  JsonOutput out_;
};

TrackWriter::TrackWriter(const std::string& path, const TrackHeader& header,
                         const TrackWriteOptions& options)
    : impl_(std::make_unique<Impl>(path, header, options)) {}
TrackWriter::~TrackWriter() = default;
void TrackWriter::Write(const TrackFrame& frame) { impl_->Write(frame); }
void TrackWriter::Flush() { impl_->HandOver(); }
void TrackWriter::Commit() { impl_->Commit(); }

void WriteTracks(const std::string& path, const TrackSequence& sequence,
                 const TrackWriteOptions& options) {
  TrackWriter writer(path, sequence.header, options);
  for (const TrackFrame& frame : sequence.frames) writer.Write(frame);
  writer.Commit();
}

// ---- Reading ----

namespace {

constexpr int kMaxInt = std::numeric_limits<int>::max();

class KinegraphTrackReader {
 public:
  explicit KinegraphTrackReader(const std::string& path) : lines_(path) {}
  // Reads the output of an adapter. `skeleton` replaces the skeleton of the
  // output, which must have the same number of joints.
  KinegraphTrackReader(const std::string& name, int pipe, int silence_ms,
                       const std::optional<Skeleton>& skeleton)
      : lines_(name, pipe, silence_ms),
        is_of_adapter_(true),
        skeleton_(skeleton) {}

  TrackSequence Read(const TrackReadOptions& options) {
    lines_.ReadHeader([&](const JsonObject& object) { ReadHeader(object); });
    const bool had_rate = header_.frame_rate_hz > 0.0;
    header_.frame_rate_hz =
        ChooseFrameRate(options.frame_rate_hz, header_.frame_rate_hz,
                        options.refuse_other_rate);
    TrackSequence sequence;
    TrackFrame frame;
    while (lines_.ReadFrame(
        [&](const JsonObject& object) { ReadFrame(object, &frame); })) {
      sequence.frames.push_back(std::move(frame));
      frame = TrackFrame();
    }
    // TrackWriter writes unknown times as 0.
    const bool has_times =
        std::any_of(sequence.frames.begin(), sequence.frames.end(),
                    [](const TrackFrame& one) { return one.time != 0; });
    if (!had_rate && !has_times) {
      for (TrackFrame& one : sequence.frames) {
        one.time = TimeOfFrame(one.frame, header_.frame_rate_hz);
      }
    }
    sequence.header = std::move(header_);  // view names may have been added
    return sequence;
  }

 private:
  using Self = KinegraphTrackReader;
  template <typename Target>
  using Key = JsonKey<KinegraphTrackReader, Target>;

  // ---- The header ----

  void ReadHeader(const JsonObject& object) {
    static constexpr Key<TrackHeader> kKeys[] = {
        {"kinegraph", Presence::kRequired, &Self::AcceptVersion},
        {"skeleton", Presence::kRequired, &Self::AcceptSkeleton},
        {"units", Presence::kOptional, &Self::CheckUnits},
        {"mode", Presence::kOptional, &Self::AcceptMode},
        {"frame_rate", Presence::kOptional, &Self::AcceptFrameRate},
        {"config", Presence::kOptional, &Self::AcceptConfig},
        {"views", Presence::kOptional, &Self::AcceptViewNames}};
    ReadKeys(object, kKeys, this, &header_);
  }

  void AcceptVersion(JsonValue value, std::string_view key, TrackHeader*) {
    AsInteger(value, key, 1, 1);
  }
  void AcceptSkeleton(JsonValue value, std::string_view, TrackHeader* header) {
    if (!is_of_adapter_) {
      header->skeleton = ReadSkeleton(value);
      return;
    }
    header->skeleton = ReadStatedSkeleton(value);
    if (!skeleton_.has_value()) return;
    CheckCount("skeleton", header->skeleton.joints().size(),
               skeleton_->joints().size(), " joints");
    header->skeleton = *skeleton_;
  }
  void CheckUnits(JsonValue value, std::string_view key, TrackHeader*) {
    const JsonObject units = AsObject(value, key);
    const std::string_view length = AsText(Required(units, "length"), "length");
    const std::string_view time = AsText(Required(units, "time"), "time");
    if (length != "m" || time != "s") {
      throw InputError("units: expected metres (m) and seconds (s)");
    }
  }
  void AcceptMode(JsonValue value, std::string_view key, TrackHeader* header) {
    header->mode = AsText(value, key);
  }
  void AcceptFrameRate(JsonValue value, std::string_view key,
                       TrackHeader* header) {
    header->frame_rate_hz = AsFrameRate(value, key);
  }
  void AcceptConfig(JsonValue value, std::string_view key,
                    TrackHeader* header) {
    AsObject(value, key);
    header->config_json = RawObject(lines_.line(), key);
    // NaN in the line is not valid JSON; in `value` it is already null.
    if (CompactObject(header->config_json).empty()) {
      header->config_json = simdjson::minify(value);
    }
  }
  void AcceptViewNames(JsonValue value, std::string_view key,
                       TrackHeader* header) {
    for (const JsonValue name : AsArray(value, key)) {
      header->view_names.emplace_back(AsText(name, key));
    }
  }

  // ---- A frame ----

  void ReadFrame(const JsonObject& object, TrackFrame* frame) {
    static constexpr Key<TrackFrame> kKeys[] = {
        {"frame", Presence::kRequired, &Self::TakeFrame},
        {"time", Presence::kOptional, &Self::AcceptTime},
        {"people", Presence::kRequired, &Self::AcceptPeople}};
    frame->people.clear();
    has_time_ = false;
    ReadKeys(object, kKeys, this, frame);
    lines_.CheckFrame(frame->frame);
    if (!has_time_) {
      frame->time = TimeOfFrame(frame->frame, header_.frame_rate_hz);
    }
  }

  void TakeFrame(JsonValue value, std::string_view key, TrackFrame* frame) {
    frame->frame = AsFrame(value, key);
  }
  void AcceptTime(JsonValue value, std::string_view key, TrackFrame* frame) {
    frame->time = AsTime(value, key);
    has_time_ = true;
  }
  void AcceptPeople(JsonValue value, std::string_view key, TrackFrame* frame) {
    for (const JsonValue element : AsArray(value, key)) {
      PersonPose person;
      ReadPerson(AsObject(element, key), &person);
      if (FindPerson(frame, person.id) != nullptr) {
        Refuse("people: id {} appears twice", person.id.value());
      }
      frame->people.push_back(std::move(person));
    }
  }

  // ---- A person ----

  void ReadPerson(const JsonObject& object, PersonPose* person) {
    static constexpr Key<PersonPose> kKeys[] = {
        {"id", Presence::kRequired, &Self::AcceptId},
        {"joints", Presence::kRequired, &Self::ExtractPositions},
        {"status", Presence::kRequired, &Self::ExtractStatuses},
        {"views", Presence::kOptional, &Self::AcceptViewCounts},
        {"covariance", Presence::kOptional, &Self::ExtractCovariances},
        {"score", Presence::kOptional, &Self::AcceptScore},
        {"matches", Presence::kOptional, &Self::ExtractMatches},
        {"weights", Presence::kOptional, &Self::ExtractWeights}};
    weights_.reset();
    ReadKeys(object, kKeys, this, person);
    MergeStatuses(person);
    if (weights_.has_value()) ReadWeights(*weights_, person);
  }

  void AcceptId(JsonValue value, std::string_view key, PersonPose* person) {
    person->id = TrackId(AsId(value, key));
  }

  void ExtractPositions(JsonValue value, std::string_view key,
                        PersonPose* person) {
    person->joints.reserve(header_.skeleton.joints().size());
    for (const JsonValue position : AsArray(value, key)) {
      if (position.is_null()) {
        person->joints.emplace_back();
        continue;
      }
      Eigen::Vector3d at_m;
      AsNumbers(position, key, 3, at_m.data());
      person->joints.push_back(ObservedJoint(at_m));
    }
    CheckLength(person->joints.size(), key);
  }

  void ExtractStatuses(JsonValue value, std::string_view key, PersonPose*) {
    statuses_.clear();
    for (const JsonValue status : AsArray(value, key)) {
      statuses_.push_back(ParseJointStatus(AsText(status, key)));
    }
    CheckLength(statuses_.size(), key);
  }

  void AcceptViewCounts(JsonValue value, std::string_view key,
                        PersonPose* person) {
    for (const JsonValue count : AsArray(value, key)) {
      person->inlier_views.push_back(
          static_cast<int>(AsInteger(count, key, 0, kMaxInt)));
    }
    CheckLength(person->inlier_views.size(), key);
  }

  void ExtractCovariances(JsonValue value, std::string_view key,
                          PersonPose* person) {
    for (const JsonValue covariance : AsArray(value, key)) {
      if (covariance.is_null()) {
        person->covariances.emplace_back();
        continue;
      }
      double c[6];
      AsNumbers(covariance, key, 6, c);
      Eigen::Matrix3d matrix;
      matrix << c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5];
      person->covariances.emplace_back();
      if (matrix.allFinite()) person->covariances.back() = matrix;
    }
    CheckLength(person->covariances.size(), key);
  }

  void AcceptScore(JsonValue value, std::string_view key, PersonPose* person) {
    person->score = AsNumber(value, key);
  }

  void ExtractMatches(JsonValue value, std::string_view key,
                      PersonPose* person) {
    for (const auto field : AsObject(value, key)) {
      ViewMatch match;
      match.view_idx = ViewOf(field.key);
      match.detection_idx =
          static_cast<int>(AsInteger(field.value, key, 0, kMaxInt));
      if (MatchOf(match.view_idx, person) != nullptr) {
        Refuse("matches: '{}' appears twice",
               Printable(std::string(field.key)));
      }
      person->matches.push_back(match);
    }
  }

  // Stored until all matches are known.
  void ExtractWeights(JsonValue value, std::string_view key, PersonPose*) {
    weights_ = AsObject(value, key);
  }

  void CheckLength(size_t found, std::string_view key) const {
    const size_t expected = header_.skeleton.joints().size();
    if (found != expected) {
      Refuse("{}: found {} entries, expected one per joint, {}", key, found,
             expected);
    }
  }

  // A joint is null if and only if it is missing.
  void MergeStatuses(PersonPose* person) const {
    for (size_t j = 0; j < statuses_.size(); ++j) {
      const bool is_missing = statuses_[j] == JointStatus::kMissing;
      if (person->joints[j].present() == is_missing) {
        Refuse("status: joint {} is {} but {}", j, ToString(statuses_[j]),
               is_missing ? "has a position" : "its position is null");
      }
      person->joints[j].status = statuses_[j];
    }
  }

  // Names of views that the header does not list are added as they occur.
  int ViewOf(std::string_view name) {
    auto& names = header_.view_names;
    const auto at = std::find(names.begin(), names.end(), name);
    const auto view_idx = static_cast<int>(at - names.begin());
    if (at == names.end()) names.emplace_back(name);
    return view_idx;
  }

  static ViewMatch* MatchOf(int view_idx, PersonPose* person) {
    for (ViewMatch& match : person->matches) {
      if (match.view_idx == view_idx) return &match;
    }
    return nullptr;
  }

  void ReadWeights(const JsonObject& weights, PersonPose* person) {
    for (const auto field : weights) {
      ViewMatch* match = MatchOf(ViewOf(field.key), person);
      if (match == nullptr || !match->weights.empty()) {
        Refuse("weights: '{}' appears twice or has no match",
               Printable(std::string(field.key)));
      }
      for (const JsonValue weight : AsArray(field.value, "weights")) {
        match->weights.emplace_back();
        if (!weight.is_null()) {
          match->weights.back() = AsNumber(weight, "weights");
        }
      }
      CheckLength(match->weights.size(), "weights");
    }
  }

  OwnLines lines_;
  const bool is_of_adapter_ = false;
  const std::optional<Skeleton> skeleton_;
  TrackHeader header_;
  bool has_time_ = false;              // of the current frame
  std::vector<JointStatus> statuses_;  // of the current person
  std::optional<JsonObject> weights_;  // of the current person
};

}  // namespace

bool RecogniseKinegraphTracks(const TrackHead& head) {
  return head.HasKey("kinegraph");
}

TrackSequence ReadKinegraphTracks(const std::string& path,
                                  const TrackReadOptions& options) {
  return KinegraphTrackReader(path).Read(options);
}

TrackSequence ReadTracksByAdapter(const Adapter& adapter,
                                  const std::string& path,
                                  const TrackReadOptions& options) {
  std::vector<std::string> flags;
  if (options.skeleton.has_value()) {
    flags.push_back(
        fmt::format("--joints={}", options.skeleton->joints().size()));
  }
  AdapterRun run(adapter, path, flags);
  TrackSequence tracks = run.Guard([&] {
    return KinegraphTrackReader(path, run.TakeOutput(), run.silence_ms(),
                                options.skeleton)
        .Read(options);
  });
  run.Finish();
  return tracks;
}

void WriteTracksByAdapter(const std::string& format, const std::string& path,
                          const TrackSequence& tracks,
                          const TrackWriteOptions& options) {
  AtomicFile file(path);
  file.Write(WriteByAdapter(format, path, [&](const std::string& lines) {
    WriteTracks(lines, tracks, options);
  }));
  file.Commit();
}

PersonNames ReadKinegraphNames(const std::string& path) {
  constexpr const char* kKey = "names";
  PersonNames names;
  OwnLines lines(path);
  lines.ReadHeader([&](const JsonObject& header) {
    JsonValue entries;
    if (!Get(header, kKey, &entries) || entries.is_null()) return;
    for (const auto& [key, name] : AsObject(entries, kKey)) {
      const std::optional<TrackId> id = PersonIdOf(key);
      if (!id.has_value()) {
        throw InputError(std::string(kKey) + ": found '" +
                         Printable(std::string(key)) +
                         "', expected {\"identity\": \"name\"}");
      }
      names[*id] = AsText(name, kKey);
    }
  });
  return names;
}

void WriteKinegraphTracks(const std::string& path, const TrackSequence& tracks,
                          const TrackExportOptions& options,
                          LostFields* lost_fields) {
  if (!(tracks.header.frame_rate_hz > 0.0)) {
    lost_fields->push_back("the frame rate is not known (--frame_rate=HZ)");
  }
  // The header has views only if the input had observations.
  WriteTracks(path, tracks, {!tracks.header.view_names.empty(), options.names});
}

}  // namespace kinegraph
