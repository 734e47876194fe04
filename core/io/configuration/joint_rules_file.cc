#include "core/io/configuration/joint_rules_file.h"

#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json.h"
#include "core/io/text/toml_file.h"

namespace kinegraph {
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

// Of each key one joint has, what it means.
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
    table.Fail("along and by_mm belong together");
  }
  const bool is_hip = rule.hip != HipRule::kNone;
  if (is_hip && (rule.asis.empty() || rule.psis.empty())) {
    table.FailExpected(
        "asis = [\"left\", \"right\"] and psis = [...] beside it");
  }
  if (is_hip && !rule.along.empty()) {
    table.Fail("along belongs to middle_of and marker");
  }
  return rule;
}

}  // namespace

MarkerSet ReadJointRules(const std::string& path) {
  const Json root = ToJson(ParseToml(ReadTextFile(path), path));
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
  if (set.rules.empty())
    throw InputError(path, "", "[joints.NAME]: there is none");
  return set;
}

}  // namespace kinegraph
