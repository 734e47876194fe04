#include "core/io/text/skeleton_json.h"

#include <fmt/format.h>

#include <limits>
#include <utility>
#include <vector>

#include "core/io/text/joint_names.h"
#include "core/io/text/json.h"

namespace kinegraph {

std::vector<Bone> ReadBones(JsonValue value, std::string_view key, int first,
                            int last) {
  std::vector<Bone> bones;
  for (const JsonValue bone : AsArray(value, key)) {
    const JsonArray ends = AsArray(bone, key);
    if (ends.size() != 2) {
      throw InputError(std::string(key) + ": expected pairs of joint indices");
    }
    const auto end = [&](size_t side) {
      return static_cast<int>(
                 AsInteger(ends.at(side).value_unsafe(), key, first, last)) -
             first;
    };
    bones.push_back({end(0), end(1)});
  }
  return bones;
}

namespace {

std::vector<std::string> ReadJoints(const JsonObject& skeleton) {
  std::vector<std::string> joints;
  for (const JsonValue joint :
       AsArray(Required(skeleton, "joints"), "skeleton.joints")) {
    joints.emplace_back(AsText(joint, "skeleton.joints"));
  }
  return joints;
}

}  // namespace

Skeleton ReadSkeleton(JsonValue value) {
  const JsonObject object = AsObject(value, "skeleton");
  const std::string name(AsText(Required(object, "name"), "skeleton.name"));
  std::vector<std::string> joints = ReadJoints(object);
  std::vector<Bone> bones =
      ReadBones(Required(object, "bones"), "skeleton.bones", 0,
                std::numeric_limits<int>::max());
  try {
    return Skeleton(name, std::move(joints), std::move(bones));
  } catch (const OptionError& error) {
    throw InputError(std::string("skeleton.") + error.what());
  }
}

Skeleton ReadStatedSkeleton(JsonValue value) {
  if (value.is_string()) {
    const std::string name(AsText(value, "skeleton"));
    if (const Skeleton* known = FindSkeleton(name)) return *known;
    throw InputError(fmt::format("skeleton: found '{}', expected one of {}",
                                 Printable(name),
                                 fmt::join(SkeletonNames(), ", ")));
  }
  const JsonObject object = AsObject(value, "skeleton");
  const std::vector<std::string> labels = ReadJoints(object);
  std::string_view name;
  Get(object, "name", &name);
  std::vector<Bone> bones;
  JsonValue pairs;
  if (Get(object, "bones", &pairs)) {
    bones = ReadBones(pairs, "skeleton.bones", 0,
                      static_cast<int>(labels.size()) - 1);
  }
  return SkeletonOfLabels(labels, bones, std::string(name));
}

std::string SkeletonJson(const Skeleton& skeleton) {
  std::vector<std::string> joints;
  for (const std::string& joint : skeleton.joints()) {
    joints.push_back(JsonText(joint));
  }
  std::vector<std::string> bones;
  for (const Bone& bone : skeleton.bones()) {
    bones.push_back(fmt::format("[{}, {}]", bone.a, bone.b));
  }
  return fmt::format("{{\"name\": {}, \"joints\": [{}], \"bones\": [{}]}}",
                     JsonText(skeleton.name()), fmt::join(joints, ", "),
                     fmt::join(bones, ", "));
}

}  // namespace kinegraph
