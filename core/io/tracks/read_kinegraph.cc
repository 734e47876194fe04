// Our own tracks, JSON Lines: a header line, then a line a frame. The fields
// stand in core/io/tracks/writer.cc, which writes them.
#include <algorithm>
#include <fstream>
#include <limits>

#include "core/base/error.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json.h"
#include "core/io/text/skeleton_json.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/formats.h"
#include "core/io/tracks/person_files.h"
#include "core/io/tracks/writer.h"

namespace kinegraph {
namespace {

constexpr int kMaxInt = std::numeric_limits<int>::max();

JointStatus ReadStatus(JsonValue value) {
  const std::string_view text = AsText(value, "status");
  for (const JointStatus status :
       {JointStatus::kObserved, JointStatus::kInferred,
        JointStatus::kMissing}) {
    if (text == ToString(status)) return status;
  }
  throw InputError("status: found '" + Printable(std::string(text)) +
                   "', expected observed, inferred or missing");
}

class KinegraphTrackSource : public TrackSource {
 public:
  KinegraphTrackSource(const std::string& path, const TrackReadOptions& options)
      : lines_(path) {
    JsonValue line;
    if (!lines_.Next(&line)) {
      throw InputError(path, "", "is empty, expected a header line");
    }
    Locate([&] { ReadHeader(AsObject(line, "the header")); });
    if (options.frame_rate_hz > 0.0) {
      header_.frame_rate_hz = options.frame_rate_hz;
    }
  }

  const TrackHeader& header() const override { return header_; }

  bool Next(TrackFrame* frame) override {
    JsonValue line;
    if (!lines_.Next(&line)) return false;
    Locate([&] { ReadFrame(AsObject(line, "the frame"), frame); });
    return true;
  }

 private:
  template <typename Read>
  void Locate(const Read& read) const {
    Located(
        lines_.path(), [&] { return lines_.Place(); }, read);
  }

  void ReadHeader(const JsonObject& object) {
    ObjectKeys keys({"kinegraph", "skeleton", "units", "mode", "frame_rate",
                     "config", "views"});
    for (const auto field : object) {
      switch (keys.Take(field.key)) {
        case 0:
          AsInteger(field.value, field.key, 1, 1);
          break;
        case 1:
          header_.skeleton = ReadSkeleton(field.value);
          break;
        case 2:
          CheckUnits(AsObject(field.value, field.key));
          break;
        case 3:
          header_.mode = AsText(field.value, field.key);
          break;
        case 4:
          header_.frame_rate_hz = AsFrameRate(field.value, field.key);
          break;
        case 5:
          AsObject(field.value, field.key);
          header_.config_json = RawObject(lines_.line(), field.key);
          break;
        case 6:
          for (const JsonValue name : AsArray(field.value, field.key)) {
            header_.view_names.emplace_back(AsText(name, field.key));
          }
          break;
        default:
          break;
      }
    }
    keys.Require(0);
    keys.Require(1);
  }

  static void CheckUnits(const JsonObject& units) {
    const std::string_view length = AsText(Required(units, "length"), "length");
    const std::string_view time = AsText(Required(units, "time"), "time");
    if (length != "m" || time != "s") {
      throw InputError("units: expected metres (m) and seconds (s)");
    }
  }

  void ReadFrame(const JsonObject& object, TrackFrame* frame) {
    frame->people.clear();
    enum { kFrame, kTime, kPeople };  // in the order of `keys`
    ObjectKeys keys({"frame", "time", "people"});
    for (const auto field : object) {
      switch (keys.Take(field.key)) {
        case kFrame:
          frame->frame = AsFrame(field.value, field.key);
          break;
        case kTime:
          frame->time = AsTime(field.value, field.key);
          break;
        case kPeople:
          ReadPeople(AsArray(field.value, field.key), frame);
          break;
        default:
          break;
      }
    }
    keys.Require(kFrame);
    keys.Require(kPeople);
    if (frame->frame <= last_frame_) {
      throw InputError("frame: found " + std::to_string(frame->frame) +
                       " after " + std::to_string(last_frame_) +
                       ", expected frames to ascend");
    }
    last_frame_ = frame->frame;
    if (!keys.Has(kTime)) {
      frame->time = TimeOfFrame(frame->frame, header_.frame_rate_hz);
    }
  }

  void ReadPeople(const JsonArray& people, TrackFrame* frame) {
    for (const JsonValue value : people) {
      PersonPose person;
      ReadPerson(AsObject(value, "people"), &person);
      for (const PersonPose& other : frame->people) {
        if (other.id == person.id) {
          throw InputError("people: id " + std::to_string(person.id.value()) +
                           " stands there twice");
        }
      }
      frame->people.push_back(std::move(person));
    }
  }

  void ReadPerson(const JsonObject& object, PersonPose* person) {
    enum {  // in the order of `keys`
      kId,
      kJoints,
      kStatus,
      kViews,
      kCovariance,
      kScore,
      kMatches,
      kWeights
    };
    ObjectKeys keys({"id", "joints", "status", "views", "covariance", "score",
                     "matches", "weights"});
    JsonObject weights;
    for (const auto field : object) {
      switch (keys.Take(field.key)) {
        case kId:
          person->id = TrackId(AsId(field.value, field.key));
          break;
        case kJoints:
          ReadPositions(AsArray(field.value, field.key), person);
          break;
        case kStatus:
          ReadStatuses(AsArray(field.value, field.key));
          break;
        case kViews:
          for (const JsonValue count : AsArray(field.value, field.key)) {
            person->inlier_views.push_back(
                static_cast<int>(AsInteger(count, field.key, 0, kMaxInt)));
          }
          CheckLength(person->inlier_views.size(), field.key);
          break;
        case kCovariance:
          ReadCovariances(AsArray(field.value, field.key), person);
          break;
        case kScore:
          person->score = AsNumber(field.value, field.key);
          break;
        case kMatches:
          ReadMatches(AsObject(field.value, field.key), person);
          break;
        case kWeights:
          weights = AsObject(field.value, field.key);
          break;
        default:
          break;
      }
    }
    keys.Require(kId);
    keys.Require(kJoints);
    keys.Require(kStatus);
    MergeStatuses(person);
    if (keys.Has(kWeights)) ReadWeights(weights, person);
  }

  void CheckLength(size_t found, std::string_view key) const {
    const size_t expected = header_.skeleton.joints().size();
    if (found != expected) {
      throw InputError(std::string(key) + ": found " + std::to_string(found) +
                       " entries, expected one a joint, " +
                       std::to_string(expected));
    }
  }

  void ReadPositions(const JsonArray& positions, PersonPose* person) const {
    person->joints.reserve(header_.skeleton.joints().size());
    for (const JsonValue position : positions) {
      if (position.is_null()) {
        person->joints.emplace_back();
        continue;
      }
      double m[3];
      AsNumbers(position, "joints", 3, m);
      person->joints.push_back(ObservedJoint(m[0], m[1], m[2]));
    }
    CheckLength(person->joints.size(), "joints");
  }

  void ReadStatuses(const JsonArray& statuses) {
    statuses_.clear();
    for (const JsonValue status : statuses) {
      statuses_.push_back(ReadStatus(status));
    }
    CheckLength(statuses_.size(), "status");
  }

  // A joint is null exactly when it is missing.
  void MergeStatuses(PersonPose* person) const {
    for (size_t j = 0; j < statuses_.size(); ++j) {
      const bool is_missing = statuses_[j] == JointStatus::kMissing;
      if (person->joints[j].present() == is_missing) {
        throw InputError(
            "status: joint " + std::to_string(j) + " is " +
            ToString(statuses_[j]) +
            (is_missing ? " but has a position" : " but its position is null"));
      }
      person->joints[j].status = statuses_[j];
    }
  }

  void ReadCovariances(const JsonArray& covariances, PersonPose* person) const {
    for (const JsonValue value : covariances) {
      if (value.is_null()) {
        person->covariances.emplace_back();
        continue;
      }
      double c[6];
      AsNumbers(value, "covariance", 6, c);
      Eigen::Matrix3d matrix;
      matrix << c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5];
      person->covariances.emplace_back(matrix);
    }
    CheckLength(person->covariances.size(), "covariance");
  }

  // A file without view names in its header teaches them as they come.
  int ViewOf(std::string_view name) {
    auto& names = header_.view_names;
    const auto at = std::find(names.begin(), names.end(), name);
    const auto view_idx = static_cast<int>(at - names.begin());
    if (at == names.end()) names.emplace_back(name);
    return view_idx;
  }

  void ReadMatches(const JsonObject& matches, PersonPose* person) {
    for (const auto field : matches) {
      ViewMatch match;
      match.view_idx = ViewOf(field.key);
      match.detection_idx =
          static_cast<int>(AsInteger(field.value, "matches", 0, kMaxInt));
      if (MatchOf(match.view_idx, person) != nullptr) {
        throw InputError("matches: '" + Printable(std::string(field.key)) +
                         "' stands there twice");
      }
      person->matches.push_back(match);
    }
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
        throw InputError("weights: '" + Printable(std::string(field.key)) +
                         "' stands there twice or has no match");
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

  JsonLineReader lines_;
  TrackHeader header_;
  int64_t last_frame_ = -1;
  std::vector<JointStatus> statuses_;  // of one person
};

PersonNames ReadNames(const std::string& path) {
  PersonNames names;
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line)) return names;
  const Json json = Json::parse(line, nullptr, false);
  if (!json.is_object() || json.count("kinegraph") == 0) return names;
  const auto entries = json.find("names");
  if (entries == json.end()) return names;
  for (const auto& [key, name] : entries->items()) {
    const std::optional<TrackId> id = PersonIdOf(key);
    if (!entries->is_object() || !id.has_value() || !name.is_string()) {
      throw InputError(path, "names",
                       "found '" + Printable(key) + ": " +
                           Printable(name.dump()) +
                           "', expected {\"identity\": \"name\"}");
    }
    names[*id] = name.get<std::string>();
  }
  return names;
}

}  // namespace

std::unique_ptr<TrackSource> OpenKinegraphTracks(
    const std::string& path, const TrackReadOptions& options) {
  return std::make_unique<KinegraphTrackSource>(path, options);
}

TrackFormat KinegraphTrackFormat() {
  TrackFormat format;
  format.name = "kinegraph";
  format.layout = "JSON Lines";
  format.extensions = {".jsonl"};
  format.recognise = [](const TrackHead& head) {
    return head.HasKey("kinegraph");
  };
  format.open = OpenKinegraphTracks;
  format.read_names = ReadNames;
  format.keeps_names = true;
  format.write = [](const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& options, Losses* losses) {
    if (!(tracks.header.frame_rate_hz > 0.0)) {
      losses->push_back("the frame rate is not known (--frame_rate=HZ)");
    }
    // The header has views only when the input had observations.
    WriteTracks(path, tracks,
                {!tracks.header.view_names.empty(), options.names});
  };
  format.kept = "everything";
  format.lost = "nothing";
  return format;
}

}  // namespace kinegraph
