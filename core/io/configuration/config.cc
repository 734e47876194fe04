#include "core/io/configuration/config.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "core/base/text.h"
#include "core/io/files/text_file.h"
#include "core/io/text/toml_file.h"

namespace kinegraph {
namespace {

// ---- Texts of messages ----

std::string Quoted(const std::string& text) {
  return "'" + Printable(text) + "'";
}

std::string WithoutQuotes(const std::string& text) {
  const bool quoted = text.size() >= 2 && text.front() == text.back() &&
                      (text.front() == '"' || text.front() == '\'');
  return quoted ? text.substr(1, text.size() - 2) : text;
}

std::string WithUnit(const std::string& unit) {
  return unit.empty() ? "" : " (" + unit + ")";
}

// "allowed > 0 (px)".
std::string Allowed(const Limits& limits, const std::string& unit) {
  return "allowed " + limits.ToString() + WithUnit(unit);
}

// Description of a value in the file, for a message.
std::string Found(const toml::node& node) {
  if (node.is_table()) return "a table";
  if (const toml::array* array = node.as_array()) {
    return "a list of " + std::to_string(array->size());
  }
  const Json json = ToJson(node);
  if (json.is_string()) return Quoted(json.get<std::string>());
  if (json.is_number_float()) return fmt::format("{}", json.get<double>());
  return DumpJson(json);
}

std::string LastPart(const std::string& key) {
  return key.substr(key.rfind('.') + 1);  // npos + 1 is 0
}

// The known key most similar to an unknown one; empty if none is similar.
std::string Nearest(const std::string& key, const std::set<std::string>& keys) {
  constexpr size_t kLongest = 200;  // longer than any mistyped key
  if (key.size() > kLongest) return {};
  std::string nearest;
  size_t least = std::max<size_t>(2, key.size() / 3) + 1;
  for (const std::string& known : keys) {
    // The right key in the wrong table counts as one edit.
    const size_t distance =
        LastPart(known) == LastPart(key) ? 1 : EditDistance(key, known);
    if (distance < least) {
      least = distance;
      nearest = known;
    }
  }
  return nearest;
}

// Removed keys and tables, and what replaces them.
struct GoneKey {
  const char* key;
  const char* instead;
};
constexpr GoneKey kGoneKeys[] = {
    {"tracking.confirm_hits",
     "use tracking.confirm_s, the time after the first hit: 3 hits at 25 Hz "
     "are 0.08"},
    {"tracking.max_age",
     "use tracking.max_age_s, in seconds: 10 frames at 25 Hz are 0.4"},
    {"tracking.max_gap",
     "use tracking.max_gap_s, in seconds: 10 frames at 25 Hz are 0.4"},
    {"gates.epipolar_m",
     "it is always 0.19 m, unless gates.units = \"pixels\" with "
     "reconstruction.alpha_epi"},
    {"gates.detector_px", "it is always 6 px"},
    {"gates.reach_m",
     "it is always 0.12 m; gates.speed_mps allows faster motion"},
    {"gates.motion_detector_px", "it is always 15 px"},
    {"gates.view_age_s",
     "it is always 0.12 s, unless gates.units = \"pixels\" with "
     "reconstruction.tau"},
    {"gates.affinity_decay",
     "it is always 75 / s, unless gates.units = \"pixels\" with "
     "association.lambda_a"},
    {"gates.view_decay",
     "it is always 125 / s, unless gates.units = \"pixels\" with "
     "reconstruction.lambda_t"},
    {"association.weight_2d", "it is always 0.4"},
    {"association.weight_3d", "it is always 0.6"},
    {"initialisation.veto_confidence", "it is always 0.5"},
    {"identity.continuity", "it is always 4 nats; see identity.min_margin"},
    {"identity.entry_penalty", "it is always 4 nats"},
    {"filters.kalman.acceleration_noise",
     "use filters.kalman.process_noise_scale, which multiplies half of "
     "graph.process_noise"},
    {"filters.kalman.jerk_noise",
     "use filters.kalman.process_noise_scale, which multiplies 25 times "
     "graph.process_noise"},
    {"filters.kalman.start_velocity_sigma", "it is always 3 m/s"},
    {"filters.kalman.start_acceleration_sigma", "it is always 30 m/s^2"},
    {"filters.one_euro.derivative_cutoff", "it is always 1 Hz"},
    {"filters.robust_triangulation.loss", "it is always Geman and McClure's"},
    {"filters.robust_triangulation.inlier_weight", "it is always 0.25"},
    {"graph.inlier_weight", "it is always 0.25"},
    {"graph.min_confidence", "it is always 0.05"},
    {"graph.confidence_from", "use graph.pixel_noise_from"},
    {"graph.stages", "the loss always narrows in two stages"},
    {"graph.min_sigma_px", "it is always 1 px; graph.sigma_px sets the errors"},
    {"graph.rival_starts", "it improved no recording"},
    {"graph.birth_position_sigma_m", "it is always 1 m"},
    {"graph.birth_velocity_sigma_mps", "it is always 3 m/s"},
    {"graph.bone_loss",
     "bone lengths have no robust loss; see graph.bone_sigma_from"},
    {"graph.bone_swing", "it is always on"},
    {"graph.start_from",
     "joints always start where the frame's own views place them"},
    {"noise.model", "specify the detector's errors in [noise]"},
    {"noise.hidden_confidence_factor", "it is always 0.9"},
    {"noise.outlier_confidence_factor", "it is always 0.8"},
    {"noise.false_life", "it is always 0.24 s"},
};

// A value given on the command line, and the flag that gave it ("--set").
struct OverrideValue {
  std::string text;
  std::string source;
};

}  // namespace

// ---- Keys that are set, and keys that are known ----

struct ConfigFile::Impl {
  // The file's value; nullptr if there is none.
  const toml::node* Find(const std::string& key) const {
    const toml::node* node = &table;
    for (const std::string& part : Split(key, '.')) {
      const toml::table* inside = node->as_table();
      node = inside == nullptr ? nullptr : inside->get(part);
      if (node == nullptr) return nullptr;
    }
    return node;
  }

  const OverrideValue* FindOverride(const std::string& key) const {
    const auto at = overrides.find(key);
    return at == overrides.end() ? nullptr : &at->second;
  }

  std::string PlaceOf(const toml::node& node) const {
    const auto line = node.source().begin.line;
    return line == 0 ? path : path + ":" + std::to_string(line);
  }
  [[noreturn]] void Fail(const toml::node& node, const std::string& key,
                         const std::string& message) const {
    throw InputError(PlaceOf(node), "key " + Quoted(key), message);
  }

  struct Unknown {
    std::string key;
    const toml::node* node;
  };

  bool IsKnownValue(const std::string& key) const {
    if (known.count(key) != 0) return true;
    for (size_t dot = key.find('.'); dot != std::string::npos;
         dot = key.find('.', dot + 1)) {
      if (open.count(key.substr(0, dot)) != 0) return true;
    }
    return false;
  }

  void CollectUnknown(const toml::table& from, const std::string& prefix,
                      std::vector<Unknown>* unknown) const {
    for (const auto& [name, node] : from) {
      const std::string key = prefix + std::string(name.str());
      if (name.str().find('.') != std::string_view::npos) {
        unknown->push_back({key, &node});  // "a.b" in quotes is one name
        continue;
      }
      if (open.count(key) != 0) continue;
      const toml::table* inner = node.as_table();
      if (inner == nullptr) {
        if (known.count(key) == 0) unknown->push_back({key, &node});
      } else if (inner->empty()) {
        const auto next = known.lower_bound(key + ".");
        const bool is_known =
            next != known.end() && next->rfind(key + ".", 0) == 0;
        if (!is_known) unknown->push_back({key, &node});
      } else {
        CollectUnknown(*inner, key + ".", unknown);
      }
    }
  }

  std::string UnknownMessage(const std::string& key) const {
    for (const GoneKey& gone : kGoneKeys) {
      const std::string name = gone.key;
      if (key == name || key.rfind(name + ".", 0) == 0) {
        return std::string("was removed: ") + gone.instead;
      }
    }
    if (known.count(key) != 0 || open.count(key) != 0) {
      return "is in quotes, expected it without";
    }
    std::set<std::string> all = known;
    all.insert(open.begin(), open.end());
    const std::string nearest = Nearest(key, all);
    return nearest.empty() ? "is not known"
                           : "is not known; did you mean '" + nearest + "'?";
  }

  std::string path;
  toml::table table;
  std::map<std::string, OverrideValue> overrides;
  std::set<std::string> known;
  std::set<std::string> open;  // any key below these tables is known
};

// ---- Reading values into options ----

class ConfigFile::Reader : public OptionVisitor {
 public:
  explicit Reader(Impl* config) : config_(config) {}

  void Enter(const std::string& name) override {
    const Setting setting = Start(name);
    tables_.push_back(name);
    if (setting.node != nullptr && !setting.node->is_table()) {
      setting.Fail("expected a table");
    }
  }
  void Leave() override { tables_.pop_back(); }

  void Number(const std::string& key, double* value, const Limits& limits,
              const std::string& unit, const std::string&) override {
    const Setting setting = StartValue(key);
    if (!setting.present()) return;
    const std::optional<double> number = setting.number();
    if (!number.has_value()) {
      setting.Fail("expected a number, " + Allowed(limits, unit));
    }
    if (!std::isfinite(*number) || !limits.Contains(*number)) {
      setting.Fail(Allowed(limits, unit));
    }
    *value = *number;
  }

  void Integer(const std::string& key, int64_t* value, const Limits& limits,
               const std::string& unit, const std::string&) override {
    const Setting setting = StartValue(key);
    if (!setting.present()) return;
    const std::optional<int64_t> integer =
        setting.text != nullptr
            ? ParseNumber<int64_t>(WithoutPlus(*setting.text))
            : setting.node->value_exact<int64_t>();
    if (!integer.has_value()) {
      setting.Fail("expected a whole number, " + Allowed(limits, unit));
    }
    if (!limits.Contains(static_cast<double>(*integer))) {
      setting.Fail(Allowed(limits, unit));
    }
    *value = *integer;
  }

  void Boolean(const std::string& key, bool* value,
               const std::string&) override {
    const Setting setting = StartValue(key);
    if (!setting.present()) return;
    std::optional<bool> boolean;
    if (setting.node != nullptr) {
      boolean = setting.node->value_exact<bool>();
    } else if (*setting.text == "true" || *setting.text == "false") {
      boolean = *setting.text == "true";
    }
    if (!boolean.has_value()) setting.Fail("expected true or false");
    *value = *boolean;
  }

  void Text(const std::string& key, std::string* value,
            const std::string&) override {
    const Setting setting = StartValue(key);
    if (setting.present()) *value = ToText(setting, "expected a text");
  }

  void ChoiceIndex(const std::string& key, int* value,
                   const std::vector<std::string>& names,
                   const std::string&) override {
    const Setting setting = StartValue(key);
    if (!setting.present()) return;
    const std::string allowed =
        fmt::format("allowed '{}'", fmt::join(names, "', '"));
    const std::string text = ToText(setting, allowed);
    const auto at = std::find(names.begin(), names.end(), text);
    if (at == names.end()) setting.Fail(allowed);
    *value = static_cast<int>(at - names.begin());
  }

  void TextList(const std::string& key, std::vector<std::string>* value,
                const std::string&) override {
    std::vector<std::string> texts;
    const bool present = ForEachElement(
        key, "expected a list of texts", [&texts](const Setting& element) {
          texts.push_back(ToText(element, "expected a text"));
        });
    if (present) *value = std::move(texts);
  }

  void NumberList(const std::string& key, std::vector<double>* value,
                  const Limits& limits, const std::string& unit,
                  const std::string&) override {
    std::vector<double> numbers;
    const bool present = ForEachElement(
        key, "expected a list of numbers", [&](const Setting& element) {
          const std::optional<double> number = element.number();
          if (!number.has_value() || !std::isfinite(*number) ||
              !limits.Contains(*number)) {
            element.Fail("expected a number, " + Allowed(limits, unit));
          }
          numbers.push_back(*number);
        });
    if (present) *value = std::move(numbers);
  }

  void NumberTable(const std::string& key, double* values,
                   const std::vector<std::string>& names, const Limits& limits,
                   const std::string& unit, const std::string& help) override {
    const Setting setting = StartValue(key);
    const bool is_table = setting.node != nullptr && setting.node->is_table();
    if (setting.present() && !is_table) {
      Number(key, values, limits, unit, help);
      std::fill_n(values, names.size(), *values);
    }
    tables_.push_back(key);
    for (const std::string& name : names) {
      // A single number on the command line overrides the file's table.
      const std::string path = JoinKey(tables_, name);
      config_->known.insert(path);
      if (setting.text == nullptr || config_->FindOverride(path) != nullptr) {
        Number(name, values, limits, unit, help);
      }
      ++values;
    }
    tables_.pop_back();
  }

  void TextMap(const std::string& key,
               std::map<std::string, std::string>* value,
               const std::string&) override {
    const Setting setting = Start(key);
    config_->open.insert(setting.key);
    if (setting.text != nullptr) {
      setting.Fail("expected " + setting.key + ".NAME=VALUE");
    }
    if (setting.node != nullptr) {
      const toml::table* table = setting.node->as_table();
      if (table == nullptr) setting.Fail("expected a table of texts");
      value->clear();
      for (const auto& [name, node] : *table) {
        const std::string inner(name.str());
        const Setting element{config_, setting.key + "." + inner, &node,
                              nullptr, ""};
        (*value)[inner] = ToTextOrNumber(element);
      }
    }
    const std::string prefix = setting.key + ".";
    for (const auto& [name, change] : config_->overrides) {
      if (name.rfind(prefix, 0) == 0) {
        (*value)[name.substr(prefix.size())] = WithoutQuotes(change.text);
      }
    }
  }

 private:
  // A key and its value, from the file (node) or the command line (text).
  struct Setting {
    const Impl* config;
    std::string key;
    const toml::node* node;
    const std::string* text;
    std::string source;

    bool present() const { return node != nullptr || text != nullptr; }
    std::optional<double> number() const {
      if (text != nullptr) return ParseNumber<double>(WithoutPlus(*text));
      if (const auto* integer = node->as_integer()) {
        return static_cast<double>(integer->get());
      }
      return node->value_exact<double>();
    }
    [[noreturn]] void Fail(const std::string& expected) const {
      if (node != nullptr) {
        config->Fail(*node, key, "found " + Found(*node) + ", " + expected);
      }
      throw InputError(source, "key " + Quoted(key),
                       "found " + Quoted(*text) + ", " + expected);
    }
  };

  Setting Start(const std::string& key) const {
    const std::string path = JoinKey(tables_, key);
    if (const OverrideValue* value = config_->FindOverride(path)) {
      return {config_, path, nullptr, &value->text, value->source};
    }
    return {config_, path, config_->Find(path), nullptr, ""};
  }

  Setting StartValue(const std::string& key) const {
    Setting setting = Start(key);
    config_->known.insert(setting.key);
    return setting;
  }

  static std::string ToText(const Setting& setting,
                            const std::string& expected) {
    if (setting.text != nullptr) return WithoutQuotes(*setting.text);
    const auto text = setting.node->value_exact<std::string>();
    if (!text.has_value()) setting.Fail(expected);
    return *text;
  }

  // A name, which may be a number: 1 is read as "1".
  static std::string ToTextOrNumber(const Setting& setting) {
    if (const auto whole = setting.node->value_exact<int64_t>()) {
      return std::to_string(*whole);
    }
    if (const auto number = setting.node->value_exact<double>()) {
      return fmt::format("{}", *number);
    }
    return ToText(setting, "expected a text or a number");
  }

  // Calls `visit` for each element of a list, which may be a text such as
  // "[360, 288]" on the command line; false if the key is not set.
  template <typename Visit>
  bool ForEachElement(const std::string& key, const std::string& expected,
                      const Visit& visit) const {
    const Setting setting = StartValue(key);
    if (!setting.present()) return false;
    size_t index = 0;
    const auto visit_next = [&](const toml::node* node,
                                const std::string* text) {
      visit(Setting{config_, setting.key + "[" + std::to_string(index++) + "]",
                    node, text, setting.source});
    };
    if (setting.text != nullptr) {
      const std::string& text = *setting.text;
      if (text.size() < 2 || text.front() != '[' || text.back() != ']') {
        setting.Fail(expected + " in brackets: [a, b]");
      }
      const std::string inside = Trimmed(text.substr(1, text.size() - 2));
      if (inside.empty()) return true;
      for (const std::string& raw : Split(inside, ',')) {
        const std::string part = Trimmed(raw);
        visit_next(nullptr, &part);
      }
      return true;
    }
    const toml::array* array = setting.node->as_array();
    if (array == nullptr) setting.Fail(expected);
    for (const toml::node& node : *array) visit_next(&node, nullptr);
    return true;
  }

  Impl* config_;
  std::vector<std::string> tables_;
};

// ---- Public interface ----

ConfigFile::ConfigFile(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ConfigFile::ConfigFile(ConfigFile&&) noexcept = default;
ConfigFile& ConfigFile::operator=(ConfigFile&&) noexcept = default;
ConfigFile::~ConfigFile() = default;

ConfigFile ConfigFile::Read(const std::string& path) {
  return Parse(ReadTextFile(path, kMaxSmallFileBytes), path);
}

ConfigFile ConfigFile::Parse(const std::string& text, const std::string& path) {
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  impl->table = ParseToml(text, path);
  return ConfigFile(std::move(impl));
}

ConfigFile ConfigFile::Empty() { return Parse("", "configuration"); }

void ConfigFile::Override(const std::string& assignments,
                          const std::string& source) {
  std::set<std::string> seen;
  for (const std::string& assignment : Split(assignments, ';')) {
    const std::string part = Trimmed(assignment);
    if (part.empty()) continue;
    const size_t equals = part.find('=');
    const std::string key =
        equals == std::string::npos ? "" : Trimmed(part.substr(0, equals));
    if (key.empty()) {
      throw InputError(
          source, "",
          "found " + Quoted(part) + ", expected key=value;key=value");
    }
    if (!seen.insert(key).second) {
      throw InputError(source, "key " + Quoted(key), "appears twice");
    }
    impl_->overrides[key] = {Trimmed(part.substr(equals + 1)), source};
  }
}

std::unique_ptr<OptionVisitor> ConfigFile::MakeReader() {
  return std::make_unique<Reader>(impl_.get());
}

void ConfigFile::RejectUnknown() const {
  std::vector<Impl::Unknown> unknown;
  impl_->CollectUnknown(impl_->table, "", &unknown);
  if (!unknown.empty()) {
    const Impl::Unknown& first = *std::min_element(
        unknown.begin(), unknown.end(), [](const auto& a, const auto& b) {
          return a.node->source().begin < b.node->source().begin;
        });
    impl_->Fail(*first.node, first.key, impl_->UnknownMessage(first.key));
  }
  for (const auto& [key, value] : impl_->overrides) {
    if (impl_->IsKnownValue(key)) continue;
    throw InputError(value.source, "key " + Quoted(key),
                     impl_->UnknownMessage(key));
  }
}

bool ConfigFile::Has(const std::string& key) const {
  return impl_->FindOverride(key) != nullptr || impl_->Find(key) != nullptr;
}

InputError ConfigFile::Locate(const OptionError& error) const {
  const std::string where = "key " + Quoted(error.key());
  if (const OverrideValue* value = impl_->FindOverride(error.key())) {
    return InputError(value->source, where, error.message());
  }
  const toml::node* node = impl_->Find(error.key());
  return InputError(node == nullptr ? impl_->path : impl_->PlaceOf(*node),
                    where, error.message());
}

// ---- Skeletons ----

namespace {

// Reads bones from the names of their ends, each of which must be a joint.
std::vector<Bone> ReadBones(const JsonField& field,
                            const std::vector<std::string>& joints) {
  std::vector<Bone> bones;
  for (const JsonField& bone : field.Elements(field.where() + ": bone")) {
    const auto index = [&](const JsonField& end) {
      const auto at = std::find(joints.begin(), joints.end(), end.Text());
      if (at == joints.end()) end.FailExpected("one of the joints");
      return static_cast<int>(at - joints.begin());
    };
    const std::vector<JsonField> ends = bone.Elements(bone.where() + ": end");
    if (ends.size() != 2) bone.FailExpected("the names of two joints");
    bones.push_back({index(ends[0]), index(ends[1])});
  }
  return bones;
}

Skeleton ReadSkeleton(const std::string& name, const JsonField& field) {
  if (FindSkeleton(name) != nullptr) {
    field.Fail("is the name of a built-in skeleton");
  }
  for (const auto& member : field.Members("key")) {
    if (member.key != "joints" && member.key != "bones") {
      field.Fail("key " + Quoted(member.key) +
                 " is not known; allowed are 'joints' and 'bones'");
    }
  }
  std::vector<std::string> joints;
  const JsonField names = field.At("joints");
  for (const JsonField& joint : names.Elements(names.where() + ": joint")) {
    joints.push_back(joint.Text());
  }
  std::vector<Bone> bones;
  if (const auto pairs = field.Find("bones")) bones = ReadBones(*pairs, joints);
  try {
    return Skeleton(name, joints, bones);
  } catch (const OptionError& error) {
    field.Fail(error.what());
  }
}

}  // namespace

std::vector<Skeleton> ConfigFile::ReadSkeletons() {
  static constexpr const char* kTable = "skeletons";
  impl_->open.insert(kTable);
  std::vector<Skeleton> skeletons;
  const toml::node* root = impl_->Find(kTable);
  if (root == nullptr) return skeletons;
  if (!root->is_table()) {
    impl_->Fail(*root, kTable, "found " + Found(*root) + ", expected tables");
  }
  for (const auto& [key, node] : *root->as_table()) {
    const std::string name(key.str());
    const Json json = ToJson(node);
    skeletons.push_back(ReadSkeleton(
        name, JsonField(json, impl_->PlaceOf(node),
                        "key " + Quoted(std::string(kTable) + "." + name))));
  }
  return skeletons;
}

Skeleton ResolveSkeleton(const std::string& name,
                         const std::vector<Skeleton>& user_skeletons) {
  if (const Skeleton* skeleton = FindSkeleton(name)) return *skeleton;
  std::string known = fmt::format("{}", fmt::join(SkeletonNames(), ", "));
  for (const Skeleton& skeleton : user_skeletons) {
    if (skeleton.name() == name) return skeleton;
    known += ", " + Printable(skeleton.name());
  }
  throw InputError("skeleton " + Quoted(name) + " is not known; known are " +
                   known);
}

}  // namespace kinegraph
