#include "apps/report/view_images.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/detections/video_times.h"
#include "core/io/files/text_file.h"
#include "core/system/file.h"

namespace kinegraph {
namespace {

size_t Base64Size(size_t bytes) { return (bytes + 2) / 3 * 4; }

int64_t FirstFrame(const PageInput& input) {
  const auto& frames = input.results.front().tracks.frames;
  return frames.empty() ? 0 : frames.front().frame;
}

// Removes "@100" from the end of "cam1.mp4@100" and returns the number; 0 if
// there is none.
int64_t ExtractFirst(std::string* path) {
  const size_t at = path->rfind('@');
  if (at == std::string::npos || !IsVideoName(path->substr(0, at))) return 0;
  const std::string number = path->substr(at + 1);
  const size_t digits = number.find_first_not_of('-');
  if (digits > 1 || number.size() - digits > 15 ||
      number.find_first_not_of("0123456789", digits) != std::string::npos) {
    throw InputError("--images: found '" + Printable(*path) +
                     "', expected the frame number of the video's first "
                     "image after @");
  }
  path->resize(at);
  return std::stoll(number);
}

// The start of each image and the end of the last one [s].
std::vector<double> TimesOf(const std::string& path, const PageInput& input) {
  std::vector<double> times_s = ReadVideoTimes(path);
  if (times_s.empty()) {
    const TrackSequence& tracks = input.results.front().tracks;
    const double rate_hz = tracks.header.frame_rate_hz > 0.0
                               ? tracks.header.frame_rate_hz
                               : kFallbackRateHz;
    const int64_t last = tracks.frames.empty()
                             ? 0
                             : std::max<int64_t>(0, tracks.frames.back().frame);
    for (int64_t i = 0; i <= last; ++i) {
      times_s.push_back(static_cast<double>(i) / rate_hz);
    }
  }
  const size_t count = times_s.size();
  const double last_s = count < 2 ? 1.0 / kFallbackRateHz
                                  : times_s[count - 1] - times_s[count - 2];
  times_s.push_back(times_s.back() + last_s);
  return times_s;
}

ViewImages::Video ReadVideo(std::string path, const PageInput& input) {
  ViewImages::Video video;
  video.shown.first_frame = ExtractFirst(&path);
  video.path = path;
  if (!IsFile(path)) {
    throw InputError(path, "", "is not there, expected a video (--images)");
  }
  video.shown.type = VideoType(path);
  video.shown.times_s = TimesOf(path, input);
  const int64_t first = FirstFrame(input);
  const auto pictures = static_cast<int64_t>(video.shown.times_s.size()) - 1;
  const int64_t last = video.shown.first_frame + pictures - 1;
  if (first < video.shown.first_frame || first > last) {
    throw InputError(
        path, "",
        "has the frames " + std::to_string(video.shown.first_frame) + ".." +
            std::to_string(last) + ", expected frame " + std::to_string(first) +
            " among them (--images=VIEW=VIDEO@N: its first image is frame N)");
  }
  return video;
}

// Whether the extension is that of a video format that browsers cannot play.
bool IsForeignVideo(const std::string& path) {
  constexpr const char* kForeign[] = {".avi",  ".mpg", ".mpeg", ".wmv", ".mts",
                                      ".m2ts", ".ts",  ".flv",  ".3gp"};
  return std::any_of(
      std::begin(kForeign), std::end(kForeign),
      [&path](const char* end) { return EndsInAnyCase(path, end); });
}

void CheckPattern(const std::string& pattern, int64_t first) {
  if (IsForeignVideo(pattern)) {
    throw InputError(pattern, "",
                     "is a video that browsers do not play; convert it: ffmpeg "
                     "-i IN -pix_fmt yuv420p OUT.mp4");
  }
  const std::string picture = PicturePath(pattern, first);
  if (!IsFile(picture)) {
    throw InputError(picture, "",
                     "is not there, expected the picture of frame " +
                         std::to_string(first) + " (--images)");
  }
}

std::string KnownViews(const PageInput& input) {
  std::string names;
  for (const std::string& name : input.detections->header.view_names) {
    names += (names.empty() ? "" : ", ") + name;
  }
  return names;
}

bool IsVideo(const std::string& value) {
  const std::string path = value.substr(0, value.rfind('@'));
  return value.find('%') == std::string::npos &&
         (IsVideoName(value) || IsVideoName(path));
}

}  // namespace

bool ViewImages::has_patterns() const {
  return std::any_of(patterns.begin(), patterns.end(),
                     [](const std::string& one) { return !one.empty(); });
}

ViewImages ReadViewImages(const std::string& images, const PageInput& input) {
  const std::vector<std::string>& views = input.detections->header.view_names;
  ViewImages read;
  read.patterns.resize(views.size());
  read.videos.resize(views.size());
  std::vector<std::string> parts = Split(images, ';');
  if (parts.back().empty()) parts.pop_back();  // a last semicolon
  for (const std::string& part : parts) {
    const size_t equals = part.find('=');
    const std::string view = part.substr(0, equals);
    if (equals == std::string::npos) {
      throw InputError("--images: '" + Printable(part) +
                       "' has no '=', expected VIEW=PATTERN or VIEW=VIDEO");
    }
    const auto at = std::find(views.begin(), views.end(), view);
    if (at == views.end()) {
      throw InputError("--images: no view '" + Printable(view) +
                       "', expected VIEW=PATTERN or VIEW=VIDEO with one of " +
                       KnownViews(input));
    }
    const auto v = static_cast<size_t>(at - views.begin());
    if (!read.patterns[v].empty() || read.videos[v].has_value()) {
      throw InputError("--images: view '" + Printable(view) +
                       "' is given twice");
    }
    const std::string value = part.substr(equals + 1);
    if (IsVideo(value)) {
      read.videos[v] = ReadVideo(value, input);
      continue;
    }
    CheckPattern(value, FirstFrame(input));
    read.patterns[v] = value;
  }
  return read;
}

size_t FramesWithout(const ViewImages::Video& video, const PageInput& input) {
  const int64_t begin = video.shown.first_frame;
  const auto pictures = static_cast<int64_t>(video.shown.times_s.size()) - 1;
  const auto& frames = input.results.front().tracks.frames;
  return static_cast<size_t>(
      std::count_if(frames.begin(), frames.end(), [&](const TrackFrame& frame) {
        return frame.frame < begin || frame.frame >= begin + pictures;
      }));
}

size_t AddVideos(const ViewImages& images, const std::string& page_path,
                 size_t max_bytes, PageInput* input) {
  input->videos.assign(images.videos.size(), std::nullopt);
  size_t bytes = 0;
  for (size_t v = 0; v < images.videos.size(); ++v) {
    if (!images.videos[v].has_value()) continue;
    const std::string& path = images.videos[v]->path;
    PageVideo& shown = input->videos[v].emplace(images.videos[v]->shown);
    if (max_bytes == 0) {
      shown.source = RelativeToFile(path, page_path);
      continue;
    }
    // Base64 adds a third.
    const size_t room = (max_bytes - std::min(bytes, max_bytes)) / 4 * 3;
    try {
      shown.bytes = ReadBytes(path, room);
    } catch (const InputError&) {
      if (!IsFile(path)) throw;
      throw InputError(path, "",
                       "does not fit into the page (--embed_megabytes); omit "
                       "the flag, or make the video smaller: ffmpeg -i IN -vf "
                       "scale=480:-2 -crf 30 OUT.mp4");
    }
    bytes += Base64Size(shown.bytes.size());
  }
  return bytes;
}

// ---- Images ----

std::string PicturePath(const std::string& pattern, int64_t frame) {
  const size_t begin = pattern.find('%');
  size_t end = begin == std::string::npos ? begin : begin + 1;
  while (end < pattern.size() && pattern[end] >= '0' && pattern[end] <= '9')
    ++end;
  const bool is_number = end < pattern.size() && pattern[end] == 'd' &&
                         pattern.find('%', end) == std::string::npos;
  if (!is_number) {
    throw InputError("--images: found '" + Printable(pattern) +
                     "', expected one number such as %06d in it, or a video "
                     "(.mp4, .m4v, .mov, .webm, .mkv)");
  }
  std::string number = std::to_string(frame);
  const size_t width = std::strtoul(pattern.c_str() + begin + 1, nullptr, 10);
  if (number.size() < width && width < 30) {
    number.insert(0, width - number.size(), '0');
  }
  return pattern.substr(0, begin) + number + pattern.substr(end + 1);
}

namespace {

std::string ReadPicture(const std::string& path) {
  constexpr size_t kMaxBytes = size_t{200} << 20;
  std::string bytes = ReadBytes(path, kMaxBytes);
  if (bytes.rfind("\xff\xd8\xff", 0) != 0 &&
      bytes.rfind("\x89PNG\r\n\x1a\n", 0) != 0) {
    throw InputError(path, "", "is neither JPEG nor PNG");
  }
  return bytes;
}

}  // namespace

EmbeddedPictures EmbedPictures(const std::vector<std::string>& patterns,
                               size_t max_bytes,
                               const std::function<void(int64_t frames)>& step,
                               PageInput* input) {
  EmbeddedPictures embedded;
  input->pictures.assign(input->cameras.size(), {});
  const auto& frames = input->results.front().tracks.frames;
  if (frames.empty()) return embedded;
  size_t all = 0;
  for (const TrackFrame& frame : frames) {
    for (const std::string& pattern : patterns) {
      if (pattern.empty()) continue;
      const auto file = StatusOf(PicturePath(pattern, frame.frame));
      if (file.has_value()) all += Base64Size(static_cast<size_t>(file->size));
    }
  }
  const size_t stride = std::min(
      frames.size(), std::max<size_t>(1, (all + max_bytes - 1) / max_bytes));
  embedded.stride = static_cast<int>(stride);
  size_t taken = 0;
  for (size_t f = 0; f < frames.size(); f += stride) {
    const int64_t number = frames[f].frame;
    for (size_t view = 0; view < patterns.size(); ++view) {
      if (patterns[view].empty()) continue;
      const std::string path = PicturePath(patterns[view], number);
      if (!IsFile(path)) continue;
      std::string bytes = ReadPicture(path);
      if (taken + Base64Size(bytes.size()) > max_bytes) continue;
      taken += Base64Size(bytes.size());
      ++embedded.count;
      input->pictures[view][number] = std::move(bytes);
    }
    step(static_cast<int64_t>(std::min(f + stride, frames.size())));
  }
  return embedded;
}

}  // namespace kinegraph
