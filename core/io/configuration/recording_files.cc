#include "core/io/configuration/recording_files.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/side_files.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json.h"
#include "core/io/text/names.h"
#include "core/io/text/toml_file.h"

namespace kinegraph {

// ---- Held-out detections ----

namespace {

std::string CameraName(JsonValue value) {
  if (value.is_string()) return std::string(AsText(value, "camera"));
  return std::to_string(AsFrame(value, "camera"));
}

// The view that corresponds to a camera of the set.
std::string ViewOf(const std::string& camera,
                   const std::vector<std::string>& view_names) {
  if (view_names.empty()) return camera;
  if (std::find(view_names.begin(), view_names.end(), camera) !=
      view_names.end()) {
    return camera;
  }
  const std::optional<int64_t> number = LastInteger(camera);
  std::string found;
  int matches = 0;
  for (const std::string& name : view_names) {
    if (!number || LastInteger(name) != number) continue;
    found = name;
    ++matches;
  }
  if (matches != 1) {
    throw InputError("camera: " + std::to_string(matches) + " views match '" +
                     Printable(camera) + "', expected one");
  }
  return found;
}

double ReadLimit(const JsonObject& root, const char* key) {
  const double value = AsNumber(Required(root, key), key);
  if (!(value >= 0.0)) {
    throw InputError(std::string(key) + ": is negative, expected >= 0");
  }
  return value;
}

HeldOutDetection ReadEntry(const JsonObject& entry,
                           const std::vector<std::string>& view_names) {
  HeldOutDetection detection;
  detection.view_name =
      ViewOf(CameraName(Required(entry, "camera")), view_names);
  detection.frame = AsFrame(Required(entry, "frame"), "frame");
  detection.detection_idx =
      static_cast<int>(AsInteger(Required(entry, "detection"), "detection", 0,
                                 std::numeric_limits<int>::max()));
  detection.person = TrackId(AsId(Required(entry, "person"), "person"));
  return detection;
}

}  // namespace

HeldOutSet ReadHeldOutSet(const std::string& path,
                          const std::vector<std::string>& view_names) {
  JsonFileParser parser;
  const JsonValue value = parser.Parse(path);
  std::string place;
  return Located(
      path, [&] { return place; },
      [&] {
        const JsonObject root = AsObject(value, kOutermost);
        HeldOutSet set;
        set.min_confidence = ReadLimit(root, "confidence_at_least");
        set.cap_px = ReadLimit(root, "cap_px");
        set.pairing_gate_m = ReadLimit(root, "pairing_gate_m");
        for (const JsonValue entry : AsArray(Required(root, "set"), "set")) {
          place = "set[" + std::to_string(set.detections.size()) + "]";
          set.detections.push_back(
              ReadEntry(AsObject(entry, "set"), view_names));
        }
        return set;
      });
}

// ---- A detector's bias ----

namespace {

ViewCoefficients ReadCoefficients(const JsonField& field) {
  const std::vector<double> numbers = field.Numbers();
  ViewCoefficients coefficients;
  if (numbers.size() != coefficients.size()) {
    field.FailExpected(std::to_string(coefficients.size()) + " numbers");
  }
  std::copy(numbers.begin(), numbers.end(), coefficients.begin());
  return coefficients;
}

ViewBias::OfJoint ReadJoint(const JsonField& field) {
  ViewBias::OfJoint joint;
  joint.joint = field.At("joint").Text();
  joint.used = field.At("used").Boolean();
  joint.observations = field.At("observations").Integer();
  joint.gain = field.At("gain").Number();
  joint.gain_error = field.At("gain_error").Number();
  joint.across_m = ReadCoefficients(field.At("across_m"));
  joint.along_m = ReadCoefficients(field.At("along_m"));
  return joint;
}

}  // namespace

void WriteViewBias(const std::string& path, const ViewBias& bias,
                   const std::string& tracks) {
  Json json = {{"kinegraph_bias", 1}, {"azimuth_deg", bias.azimuth_deg}};
  json["joints"] = Json::array();
  for (const ViewBias::OfJoint& joint : bias.joints) {
    json["joints"].push_back({{"joint", joint.joint},
                              {"used", joint.used},
                              {"observations", joint.observations},
                              {"gain", joint.gain},
                              {"gain_error", joint.gain_error},
                              {"across_m", joint.across_m},
                              {"along_m", joint.along_m}});
  }
  WriteTextFile(path, WithFingerprint(DumpJson(json, 1) + "\n", tracks));
}

ViewBias ReadViewBias(const std::string& path) {
  const Json json = ParseJson(ReadTextFile(path, kMaxSmallFileBytes), path);
  const JsonField root(json, path);
  const JsonField version = root.At("kinegraph_bias");
  if (version.Integer() != 1) version.FailExpected("1");
  ViewBias bias;
  bias.azimuth_deg = root.At("azimuth_deg").Number();
  for (const JsonField& joint : root.At("joints").Elements("joint")) {
    bias.joints.push_back(ReadJoint(joint));
  }
  return bias;
}

// ---- Joints defined by markers ----

namespace {

constexpr double kMetresPerMm = 0.001;

std::vector<std::string> Texts(const JsonField& field) {
  std::vector<std::string> texts;
  for (const JsonField& element : field.Elements("marker")) {
    texts.push_back(element.Text());
  }
  if (texts.empty()) field.Fail("expected markers, found none");
  return texts;
}

std::vector<std::string> TwoTexts(const JsonField& field,
                                  const std::string& what) {
  std::vector<std::string> texts = Texts(field);
  if (texts.size() != 2) field.FailExpected("two markers: " + what);
  return texts;
}

HipRule RegressionOf(const JsonField& field) {
  const std::string name = field.Text();
  if (name == "harrington") return HipRule::kHarrington;
  if (name == "bell") return HipRule::kBell;
  field.FailExpected("\"harrington\" or \"bell\"");
}

// Reads one key of a joint's table.
void ReadKey(const std::string& key, const JsonField& field, JointRule* rule) {
  if (key == "middle_of") {
    rule->markers = Texts(field);
  } else if (key == "marker") {
    rule->markers = {field.Text()};
  } else if (key == "along") {
    rule->along = TwoTexts(field, "from, to");
  } else if (key == "by_mm") {
    rule->by_m = kMetresPerMm * field.Number();
  } else if (key == "regression") {
    rule->hip = RegressionOf(field);
  } else if (key == "functional") {
    rule->hip = HipRule::kFunctional;
    rule->markers = Texts(field);
  } else if (key == "asis") {
    rule->asis = TwoTexts(field, "left, right");
  } else if (key == "psis") {
    rule->psis = Texts(field);
  } else {
    field.Fail(
        "is not known, expected middle_of, marker, along, by_mm, regression, "
        "functional, asis or psis");
  }
}

JointRule RuleOf(const std::string& joint, const JsonField& table) {
  JointRule rule;
  rule.joint = joint;
  rule.is_centre = true;
  int kinds = 0;
  for (const JsonField::Member& member : table.Members("key")) {
    ReadKey(member.key, member.field, &rule);
    for (const char* kind :
         {"middle_of", "marker", "regression", "functional"}) {
      kinds += member.key == kind ? 1 : 0;
    }
  }
  if (kinds != 1) {
    table.FailExpected("one of middle_of, marker, regression, functional");
  }
  if (rule.along.empty() != (rule.by_m == 0.0)) {
    table.Fail("along and by_mm must be given together");
  }
  const bool is_hip = rule.hip != HipRule::kNone;
  if (is_hip && (rule.asis.empty() || rule.psis.empty())) {
    table.FailExpected(
        "asis = [\"left\", \"right\"] and psis = [...] in the same table");
  }
  if (is_hip && !rule.along.empty()) {
    table.Fail("along requires middle_of or marker");
  }
  return rule;
}

}  // namespace

MarkerSet ReadJointRules(const std::string& path) {
  const Json root = ReadToml(path);
  MarkerSet set;
  set.name = path;
  for (const JsonField::Member& member : JsonField(root, path).Members("key")) {
    if (member.key != "joints") {
      member.field.Fail("is not known, expected [joints.NAME]");
    }
    for (const JsonField::Member& joint : member.field.Members("joint")) {
      set.rules.push_back(RuleOf(joint.key, joint.field));
    }
  }
  if (set.rules.empty()) throw InputError(path, "", "has no [joints.NAME]");
  return set;
}

}  // namespace kinegraph
