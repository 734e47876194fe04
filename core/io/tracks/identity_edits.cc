#include "core/io/tracks/identity_edits.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/side_files.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json.h"

namespace kinegraph {
namespace {

constexpr int64_t kMaxEditedId = int64_t{1} << 50;
constexpr size_t kMaxName = 100;  // bytes

std::vector<TrackId> ReadPersons(const JsonField& field) {
  std::vector<TrackId> persons;
  for (const JsonField& person : field.Elements(field.where() + ", entry")) {
    const int64_t id = person.Integer();
    if (id < 0 || id > kMaxEditedId)
      person.FailExpected("an identity, 0 .. 2^50");
    persons.emplace_back(id);
  }
  if (persons.empty()) field.FailExpected("one or two identities");
  return persons;
}

FrameSpan ReadSpan(const JsonField& field) {
  const std::vector<JsonField> ends = field.Elements(field.where() + ", entry");
  if (ends.size() != 2) field.FailExpected("[first, last]");
  return {ends[0].Integer(), ends[1].Integer()};
}

void ReadMember(const JsonField::Member& member, IdentityEdit* edit) {
  const JsonField& field = member.field;
  if (member.key == "op") {
    const std::optional<EditOp> op = EditOpByName(field.Text());
    if (!op) field.FailExpected("join, cut, swap, delete, name or undecided");
    edit->op = *op;
  } else if (member.key == "persons") {
    edit->persons = ReadPersons(field);
  } else if (member.key == "frames") {
    edit->frames = ReadSpan(field);
  } else if (member.key == "name") {
    edit->name = field.Text();
    if (edit->name.size() > kMaxName ||
        std::any_of(edit->name.begin(), edit->name.end(),
                    [](unsigned char c) { return c < ' ' || c == 0x7f; })) {
      field.FailExpected("a name of one line, up to 100 bytes");
    }
  } else if (member.key == "margin") {
    edit->margin = field.Number();
  } else if (member.key == "evidence") {
    for (const JsonField::Member& one : field.Members(field.where())) {
      edit->evidence.emplace_back(one.key, one.field.Number());
    }
  } else {
    field.Fail("is not a key of an identity edit");
  }
}

IdentityEdit ReadEdit(const std::string& line, const std::string& path,
                      int number) {
  const std::string place = "line " + std::to_string(number);
  IdentityEdit edit;
  edit.place = path + ": " + place;
  // edit.place instead of the path: syntax errors also name their line within
  // the text, which is always the first.
  const Json json = ParseJson(line, edit.place);
  const JsonField field(json, path, place);
  field.At("op");
  field.At("persons");
  for (const JsonField::Member& member : field.Members("key")) {
    ReadMember({member.key, member.field.Named(place + ": " + member.key)},
               &edit);
  }
  const bool joins = edit.op == EditOp::kJoin || edit.op == EditOp::kUndecided;
  if (!joins && edit.frames.has_value() &&
      edit.frames->last < edit.frames->first) {
    throw InputError(path, place,
                     "frames: " + std::to_string(edit.frames->first) + " to " +
                         std::to_string(edit.frames->last) +
                         " is an empty range");
  }
  return edit;
}

Json ToJson(const IdentityEdit& edit) {
  Json json;
  json["op"] = ToString(edit.op);
  json["persons"] = Json::array();
  for (const TrackId person : edit.persons) {
    json["persons"].push_back(person.value());
  }
  if (edit.frames.has_value()) {
    json["frames"] = {edit.frames->first, edit.frames->last};
  }
  if (!edit.name.empty()) json["name"] = edit.name;
  for (const auto& [key, value] : edit.evidence) json["evidence"][key] = value;
  if (edit.margin.has_value()) json["margin"] = *edit.margin;
  return json;
}

}  // namespace

std::vector<IdentityEdit> ReadIdentityEdits(const std::string& path) {
  std::istringstream text(ReadTextFile(path, kMaxSmallFileBytes));
  std::vector<IdentityEdit> edits;
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    if (number == 1 && IsFingerprintLine(line)) continue;
    edits.push_back(ReadEdit(line, path, number));
  }
  return edits;
}

void WriteIdentityEdits(const std::string& path,
                        const std::vector<IdentityEdit>& edits,
                        const std::string& tracks) {
  AtomicFile file(path);
  if (!tracks.empty()) file.Write(WithFingerprint("{}", tracks) + "\n");
  for (const IdentityEdit& edit : edits) {
    file.Write(DumpJson(ToJson(edit)) + "\n");
  }
  file.Commit();
}

}  // namespace kinegraph
