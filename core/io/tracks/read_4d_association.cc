// 4D association's gt.txt and skel.txt: "JOINTS FRAMES", then for each frame
// the number of people and for each person its id and four rows of JOINTS
// numbers: x, y, z [m] and weight.
#include <charconv>
#include <cmath>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/ids.h"
#include "core/io/tracks/export.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/formats.h"

namespace kinegraph {
namespace {

// Numbers separated by white space.
class Tokens {
 public:
  Tokens(const std::string& path, const std::string& text)
      : path_(path), rest_(text) {}

  int64_t Integer(const char* what, int64_t low, int64_t high) {
    int64_t value = 0;
    const std::string_view token = Next(what);
    if (!Parse(token, &value) || value < low || value > high) {
      Fail(what, token,
           "an integer of " + std::to_string(low) + " .. " +
               std::to_string(high));
    }
    return value;
  }

  double Number(const char* what) {
    double value = 0.0;
    const std::string_view token = Next(what);
    if (!Parse(token, &value) || !std::isfinite(value)) {
      Fail(what, token, "a finite number");
    }
    return value;
  }

  void ExpectEnd() {
    SkipSpace();
    if (!rest_.empty()) {
      throw InputError(path_, Place(), "text after the last frame");
    }
  }

  std::string Place() const { return "line " + std::to_string(line_); }

 private:
  template <typename T>
  static bool Parse(std::string_view token, T* value) {
    const char* end = token.data() + token.size();
    const auto [stop, error] = std::from_chars(token.data(), end, *value);
    return error == std::errc() && stop == end;
  }

  static bool IsSpace(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
  }

  void SkipSpace() {
    size_t length = 0;
    while (length < rest_.size() && IsSpace(rest_[length])) {
      if (rest_[length] == '\n') ++line_;
      ++length;
    }
    rest_.remove_prefix(length);
  }

  std::string_view Next(const char* what) {
    SkipSpace();
    size_t length = 0;
    while (length < rest_.size() && !IsSpace(rest_[length])) ++length;
    if (length == 0) {
      throw InputError(path_, Place(),
                       std::string("ends here, expected ") + what);
    }
    const std::string_view token = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return token;
  }

  [[noreturn]] void Fail(const char* what, std::string_view token,
                         const std::string& expected) const {
    throw InputError(path_, Place(),
                     std::string(what) + ": found '" +
                         Printable(std::string(token)) + "', expected " +
                         expected);
  }

  const std::string path_;
  std::string_view rest_;
  int64_t line_ = 1;
};

Skeleton FourDAssociationSkeleton(int64_t joint_count,
                                  const TrackReadOptions& options) {
  if (options.skeleton && options.skeleton->joint_count() == joint_count) {
    return *options.skeleton;
  }
  if (joint_count == 15) return Tum15();
  if (joint_count == 19) return FourDA19();
  throw InputError("found " + std::to_string(joint_count) +
                   " joints, expected 15 (gt.txt) or 19 (skel.txt)");
}

void ReadPose(Tokens* tokens, StoredZeros stored_zeros, Pose3d* pose) {
  std::vector<double> numbers(4 * pose->size());
  for (double& number : numbers) number = tokens->Number("x, y, z or weight");
  const size_t count = pose->size();
  for (size_t j = 0; j < count; ++j) {
    if (numbers[3 * count + j] > 0.0 || stored_zeros == StoredZeros::kKeep) {
      (*pose)[j] =
          ObservedJoint(numbers[j], numbers[count + j], numbers[2 * count + j]);
    }
  }
}

}  // namespace

TrackSequence ReadFourDAssociation(const std::string& path,
                                   const TrackReadOptions& options) {
  // Limits only keep a broken file from asking for all memory.
  constexpr int64_t kMaxJoints = 1000;
  constexpr int64_t kMaxFrames = 1 << 30;
  const std::string text = ReadTextFile(path);
  Tokens tokens(path, text);
  const int64_t joint_count = tokens.Integer("number of joints", 1, kMaxJoints);
  TrackHeader header;
  header.mode = "4d_association";
  header.frame_rate_hz = options.frame_rate_hz;
  header.skeleton = Located(
      path, [&] { return tokens.Place(); },
      [&] { return FourDAssociationSkeleton(joint_count, options); });
  TrackCollector collector(std::move(header));
  const int64_t frame_count = tokens.Integer("number of frames", 0, kMaxFrames);
  for (int64_t i = 0; i < frame_count; ++i) {
    const int64_t frame = options.first_frame + i;
    collector.Touch(frame);
    const int64_t people = tokens.Integer("number of people", 0, kMaxFrames);
    for (int64_t p = 0; p < people; ++p) {
      const TrackId id(tokens.Integer("id of a person", 0, kMaxId));
      PersonPose* person = Located(
          path, [&] { return tokens.Place(); },
          [&] { return collector.Add(frame, id); });
      ReadPose(&tokens, options.stored_zeros, &person->joints);
    }
  }
  tokens.ExpectEnd();
  return collector.Finish();
}

TrackFormat FourDAssociationTrackFormat() {
  TrackFormat format;
  format.name = "4da";
  format.layout = "4D association's gt.txt, skel.txt";
  format.unit_m = 1.0;
  format.is_unmistakable = false;
  format.recognise = [](const TrackHead& head) {
    return head.kind >= '0' && head.kind <= '9';
  };
  format.read = ReadFourDAssociation;
  format.write = [](const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions&, LostFields* lost_fields) {
    WriteTracks4dAssociation(path, tracks, lost_fields);
  };
  format.kept = "frame, identity, positions";
  format.lost =
      "times, status, covariances; the first frame and the frame rate must be "
      "named";
  return format;
}

}  // namespace kinegraph
