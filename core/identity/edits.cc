#include "core/identity/edits.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace kinegraph {
namespace {

constexpr FrameSpan kAllFrames = {std::numeric_limits<int64_t>::min(),
                                  std::numeric_limits<int64_t>::max()};

std::string NameOf(TrackId id) {
  return "person " + std::to_string(id.value());
}

std::string NameOf(const FrameSpan& span) {
  return "frames " + std::to_string(span.first) + " to " +
         std::to_string(span.last);
}

PersonPose* Find(TrackFrame* frame, TrackId id) {
  const auto at =
      std::find_if(frame->people.begin(), frame->people.end(),
                   [&](const PersonPose& person) { return person.id == id; });
  return at == frame->people.end() ? nullptr : &*at;
}

bool IsThere(std::vector<TrackFrame>* frames, TrackId id,
             const FrameSpan& span) {
  return std::any_of(frames->begin(), frames->end(), [&](TrackFrame& frame) {
    return span.Contains(frame.frame) && Find(&frame, id) != nullptr;
  });
}

void SortPeople(TrackFrame* frame) {
  std::stable_sort(
      frame->people.begin(), frame->people.end(),
      [](const PersonPose& a, const PersonPose& b) { return a.id < b.id; });
}

TrackId NextFree(const std::vector<TrackFrame>& frames) {
  int64_t next = 0;
  for (const TrackFrame& frame : frames) {
    for (const PersonPose& person : frame.people) {
      next = std::max(next, person.id.value() + 1);
    }
  }
  return TrackId(next);
}

std::string CheckPersons(const IdentityEdit& edit,
                         std::vector<TrackFrame>* frames) {
  const bool two = edit.op == EditOp::kJoin || edit.op == EditOp::kSwap;
  const size_t most = two || edit.op == EditOp::kCut ? 2 : 1;
  if (edit.persons.size() < (two ? 2u : 1u) || edit.persons.size() > most) {
    return "persons: found " + std::to_string(edit.persons.size()) +
           ", expected " +
           (two         ? "two"
            : most == 2 ? "one or two"
                        : "one");
  }
  for (size_t i = 0; i < edit.persons.size(); ++i) {
    const bool known = IsThere(frames, edit.persons[i], kAllFrames);
    if (edit.op == EditOp::kCut && i == 1) {
      if (known) {
        return NameOf(edit.persons[1]) +
               " exists already, expected a new identity";
      }
      if (edit.persons[1].value() < 0) return "a person has a negative number";
    } else if (!known) {
      return NameOf(edit.persons[i]) + " is unknown";
    }
  }
  if (edit.persons.size() == 2 && edit.persons[0] == edit.persons[1]) {
    return NameOf(edit.persons[0]) + " twice, expected two people";
  }
  return "";
}

std::string CheckFrames(const IdentityEdit& edit,
                        std::vector<TrackFrame>* frames) {
  if (edit.op == EditOp::kJoin || edit.op == EditOp::kName) return "";
  if (!edit.frames.has_value()) return "frames: missing, expected [a, b]";
  if (edit.frames->last < edit.frames->first) {
    return "frames: " + std::to_string(edit.frames->first) + " to " +
           std::to_string(edit.frames->last) + " is an empty range";
  }
  // For an exchange one of the two suffices.
  const bool there = IsThere(frames, edit.persons[0], *edit.frames) ||
                     (edit.op == EditOp::kSwap &&
                      IsThere(frames, edit.persons[1], *edit.frames));
  if (!there) {
    return NameOf(edit.persons[0]) + " is not in " + NameOf(*edit.frames);
  }
  return "";
}

std::string Join(const IdentityEdit& edit, std::vector<TrackFrame>* frames) {
  for (TrackFrame& frame : *frames) {
    if (Find(&frame, edit.persons[0]) && Find(&frame, edit.persons[1])) {
      return NameOf(edit.persons[0]) + " and " + NameOf(edit.persons[1]) +
             " are both present in frame " + std::to_string(frame.frame);
    }
  }
  for (TrackFrame& frame : *frames) {
    PersonPose* person = Find(&frame, edit.persons[1]);
    if (person == nullptr) continue;
    person->id = edit.persons[0];
    SortPeople(&frame);
  }
  return "";
}

void Rename(const IdentityEdit& edit, TrackFrame* frame) {
  PersonPose* one = Find(frame, edit.persons[0]);
  PersonPose* other =
      edit.persons.size() > 1 ? Find(frame, edit.persons[1]) : nullptr;
  if (edit.op == EditOp::kDelete) {
    frame->people.erase(
        std::remove_if(
            frame->people.begin(), frame->people.end(),
            [&](const PersonPose& p) { return p.id == edit.persons[0]; }),
        frame->people.end());
    return;
  }
  if (one != nullptr) one->id = edit.persons[1];
  if (other != nullptr) other->id = edit.persons[0];
  SortPeople(frame);
}

}  // namespace

std::string ApplyEdit(IdentityEdit* edit, std::vector<TrackFrame>* frames) {
  if (edit->op == EditOp::kUndecided) return "";
  std::string wrong = CheckPersons(*edit, frames);
  if (wrong.empty()) wrong = CheckFrames(*edit, frames);
  if (!wrong.empty()) return wrong;
  switch (edit->op) {
    case EditOp::kJoin:
      return Join(*edit, frames);
    case EditOp::kCut:
      if (edit->persons.size() == 1) edit->persons.push_back(NextFree(*frames));
      break;
    case EditOp::kName:
      return edit->name.empty() ? "name: missing or empty" : "";
    default:
      break;
  }
  for (TrackFrame& frame : *frames) {
    if (edit->frames->Contains(frame.frame)) Rename(*edit, &frame);
  }
  return "";
}

std::vector<std::string> ApplyEdits(std::vector<IdentityEdit> edits,
                                    std::vector<TrackFrame>* frames,
                                    std::vector<IdentityEdit>* done) {
  std::vector<std::string> left_out;
  for (IdentityEdit& edit : edits) {
    const std::string wrong = ApplyEdit(&edit, frames);
    if (wrong.empty()) {
      done->push_back(std::move(edit));
      continue;
    }
    std::string asked = ToString(edit.op);
    for (const TrackId id : edit.persons) {
      asked += " " + std::to_string(id.value());
    }
    if (edit.frames.has_value()) asked += ", " + NameOf(*edit.frames);
    left_out.push_back(asked + ": " + wrong);
    if (edit.op != EditOp::kJoin) continue;
    edit.op = EditOp::kUndecided;
    done->push_back(std::move(edit));
  }
  return left_out;
}

bool SameEdit(const IdentityEdit& a, const IdentityEdit& b) {
  const auto same_span = [](const FrameSpan& one, const FrameSpan& other) {
    return one.first == other.first && one.last == other.last;
  };
  return a.op == b.op && a.persons == b.persons && a.name == b.name &&
         a.frames.has_value() == b.frames.has_value() &&
         (!a.frames.has_value() || same_span(*a.frames, *b.frames));
}

}  // namespace kinegraph
