#include "apps/report/view_images.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>

#include "apps/report/pairing.h"
#include "apps/report/picture.h"
#include "core/base/error.h"
#include "core/evaluation/correspondence.h"
#include "core/io/detections/video_times.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"

namespace kinegraph {
namespace {

int64_t FirstFrame(const PageInput& input) {
  const auto& frames = input.results.front().tracks.frames;
  return frames.empty() ? 0 : frames.front().frame;
}

// Takes the number from the end of "cam1.mp4@100"; 0 where there is none.
int64_t ExtractFirst(std::string* path) {
  const size_t at = path->rfind('@');
  if (at == std::string::npos || !IsVideoName(path->substr(0, at))) return 0;
  const std::string number = path->substr(at + 1);
  const size_t digits = number.find_first_not_of('-');
  if (digits > 1 || number.size() - digits > 15 ||
      number.find_first_not_of("0123456789", digits) != std::string::npos) {
    throw InputError("--images: found '" + Printable(*path) +
                     "', expected the number of the video's first picture "
                     "behind @");
  }
  path->resize(at);
  return std::stoll(number);
}

// Each picture's beginning and the end of the last one.
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
            " among them (--images=VIEW=VIDEO@N: its first picture is frame "
            "N)");
  }
  return video;
}

// Whether the name ends like a video's of which browsers know nothing.
bool IsForeignVideo(const std::string& path) {
  std::string ending;
  for (const char c : path.substr(std::min(path.rfind('.'), path.size()))) {
    ending += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  for (const char* known : {".avi", ".mpg", ".mpeg", ".wmv", ".mts", ".m2ts",
                            ".ts", ".flv", ".3gp"}) {
    if (ending == known) return true;
  }
  return false;
}

void CheckPattern(const std::string& pattern, int64_t first) {
  if (IsForeignVideo(pattern)) {
    throw InputError(pattern, "",
                     "is a video that browsers do not play; make one that they "
                     "do: ffmpeg -i IN -pix_fmt yuv420p OUT.mp4");
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
  std::string rest = images;
  while (!rest.empty()) {
    const std::string part = rest.substr(0, rest.find(';'));
    rest = part.size() < rest.size() ? rest.substr(part.size() + 1) : "";
    const size_t equals = part.find('=');
    const std::string view = part.substr(0, equals);
    const auto at = std::find(views.begin(), views.end(), view);
    if (equals == std::string::npos || at == views.end()) {
      throw InputError("--images: no view '" + Printable(view) +
                       "', expected VIEW=PATTERN or VIEW=VIDEO with one of " +
                       KnownViews(input));
    }
    const auto v = static_cast<size_t>(at - views.begin());
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
    // A third more as Base64.
    const size_t room = (max_bytes - std::min(bytes, max_bytes)) / 4 * 3;
    try {
      shown.bytes = ReadBytes(path, room);
    } catch (const InputError&) {
      if (!IsFile(path)) throw;
      throw InputError(path, "",
                       "does not fit into the page (--embed_megabytes); leave "
                       "the flag out, or make it smaller: ffmpeg -i IN -vf "
                       "scale=480:-2 -crf 30 OUT.mp4");
    }
    bytes += (shown.bytes.size() + 2) / 3 * 4;
  }
  return bytes;
}

// ---- Pictures into the page, and a series of its own ----

namespace {

constexpr int kQuality = 70;                // of pictures inside the page
constexpr int kQualityOfFrames = 88;        // of those that are written
constexpr double kTextOfBytes = 4.0 / 3.0;  // Base64
constexpr std::array<int, 4> kWidths = {640, 480, 320, 240};  // px

// As the page's.
constexpr std::array<Colour, 8> kPalette = {{{0x00, 0x72, 0xb2},
                                             {0xe6, 0x9f, 0x00},
                                             {0x00, 0x9e, 0x73},
                                             {0xd5, 0x5e, 0x00},
                                             {0x56, 0xb4, 0xe9},
                                             {0xcc, 0x79, 0xa7},
                                             {0x88, 0x33, 0xff},
                                             {0x77, 0x44, 0x22}}};
constexpr Colour kGround = {0xe9, 0xed, 0xf2};
constexpr Colour kInk = {0x1b, 0x24, 0x30};
constexpr Colour kWhite = {0xff, 0xff, 0xff};

std::vector<int64_t> FramesOf(const PageInput& input) {
  std::vector<int64_t> frames;
  for (const TrackFrame& frame : input.results.front().tracks.frames) {
    frames.push_back(frame.frame);
  }
  return frames;
}

// What all pictures would take at a width, by the first, middle and last frame
// of each view [bytes of text].
double EstimateBytes(const std::vector<std::string>& patterns,
                     const std::vector<int64_t>& frames, int width) {
  double bytes = 0.0;
  int samples = 0;
  size_t pictures = 0;
  for (const std::string& pattern : patterns) {
    if (pattern.empty()) continue;
    pictures += frames.size();
    for (const size_t at : {size_t{0}, frames.size() / 2, frames.size() - 1}) {
      const std::string path = PicturePath(pattern, frames[at]);
      if (!IsFile(path)) continue;
      bytes += kTextOfBytes *
               static_cast<double>(
                   EncodeJpeg(ScaledDown(ReadPicture(path), width), kQuality)
                       .size());
      ++samples;
    }
  }
  return samples == 0 ? 0.0 : bytes / samples * static_cast<double>(pictures);
}

// How many pictures the page has, and the text that they are.
void CountPictures(const PageInput& input, EmbeddedPictures* embedded) {
  embedded->bytes = embedded->count = 0;
  for (const auto& pictures : input.pictures) {
    embedded->count += pictures.size();
    for (const auto& [frame, jpeg] : pictures) {
      embedded->bytes +=
          static_cast<size_t>(kTextOfBytes * static_cast<double>(jpeg.size()));
    }
  }
}

class FrameArtist {
 public:
  explicit FrameArtist(const PageInput& input)
      : input_(input),
        colours_(input.results.front().tracks, nullptr, nullptr) {}

  Picture Draw(const std::string& pattern, size_t view, int64_t frame) const {
    Picture picture = Ground(pattern, view, frame);
    // A picture may be a smaller copy of what the camera saw.
    const int width = input_.cameras[view].width_px();
    const Canvas canvas = {view, frame,
                           width > 0 ? picture.width / double(width) : 1.0,
                           std::max(1.0, picture.width / 960.0)};
    Pen pen(&picture);
    for (size_t r = 0; r < input_.results.size(); ++r) {
      DrawPoses(r, canvas, &pen);
    }
    DrawDetections(canvas, &pen);
    return picture;
  }

 private:
  struct Canvas {
    size_t view = 0;
    int64_t frame = 0;
    double scale = 1.0;  // picture pixels in a camera's pixel
    double unit = 1.0;   // px, of lines
  };

  std::optional<Eigen::Vector2d> Project(const Canvas& canvas,
                                         const Joint3d& joint) const {
    if (!joint.present()) return std::nullopt;
    const auto px = input_.cameras[canvas.view].Project(joint.position_m);
    if (!px.has_value()) return std::nullopt;
    return Eigen::Vector2d(canvas.scale * *px);
  }

  Picture Ground(const std::string& pattern, size_t view, int64_t frame) const {
    const std::string path = pattern.empty() ? "" : PicturePath(pattern, frame);
    if (!path.empty() && IsFile(path)) return ReadPicture(path);
    const Camera& camera = input_.cameras[view];
    const CameraParameters& own = camera.parameters();
    const auto side = [](int told, double middle) {
      return told > 0 ? told
                      : std::clamp(static_cast<int>(std::lround(2.0 * middle)),
                                   16, 8000);
    };
    return MakePicture(side(camera.width_px(), own.K(0, 2)),
                       side(camera.height_px(), own.K(1, 2)), kGround);
  }

  Colour ColourOf(TrackId id) const {
    const std::optional<int> colour = colours_.Find(id);
    if (!colour.has_value()) return kInk;
    return kPalette[static_cast<size_t>(*colour) % kPalette.size()];
  }

  void DrawPoses(size_t result, const Canvas& canvas, Pen* pen) const {
    const PageResult& shown = input_.results[result];
    const TrackFrame* at = FindFrame(shown.tracks, canvas.frame);
    if (at == nullptr) return;
    const bool truth = shown.role == ResultRole::kGroundTruth;
    for (const PersonPose& person : at->people) {
      const Colour colour = truth ? kInk : ColourOf(person.id);
      const double width_px = (result == 0 ? 4.0 : 1.8) * canvas.unit;
      DrawPose(shown.tracks.header.skeleton, person, canvas,
               {colour, width_px, 0.85}, pen);
      if (result == 0) DrawName(person, canvas, pen);
    }
  }

  void DrawPose(const Skeleton& skeleton, const PersonPose& person,
                const Canvas& canvas, const Stroke& stroke, Pen* pen) const {
    for (const Bone& bone : skeleton.bones()) {
      const Joint3d& a = person.joints[static_cast<size_t>(bone.a)];
      const Joint3d& b = person.joints[static_cast<size_t>(bone.b)];
      const auto from = Project(canvas, a);
      const auto to = Project(canvas, b);
      if (!from.has_value() || !to.has_value()) continue;
      Stroke own = stroke;
      if (a.status == JointStatus::kInferred ||
          b.status == JointStatus::kInferred) {
        own.opacity *= 0.4;
      }
      pen->Line(*from, *to, own);
    }
    for (int j = 0; j < skeleton.joint_count(); ++j) {
      const auto touches = [j](const Bone& bone) {
        return bone.a == j || bone.b == j;
      };
      const std::vector<Bone>& bones = skeleton.bones();
      if (std::any_of(bones.begin(), bones.end(), touches)) continue;
      const auto px = Project(canvas, person.joints[static_cast<size_t>(j)]);
      if (px.has_value()) pen->Disc(*px, stroke.width_px, stroke.colour);
    }
  }

  void DrawName(const PersonPose& person, const Canvas& canvas,
                Pen* pen) const {
    std::optional<Eigen::Vector2d> top;
    for (const Joint3d& joint : person.joints) {
      const auto px = Project(canvas, joint);
      if (px.has_value() && (!top.has_value() || px->y() < top->y())) top = px;
    }
    if (!top.has_value()) return;
    const Eigen::Vector2d above(0.0, -10.0 * canvas.unit);
    pen->Number(person.id.value(), *top + above, 15.0 * canvas.unit, kWhite,
                ColourOf(person.id));
  }

  void DrawDetections(const Canvas& canvas, Pen* pen) const {
    const DetectionFrame* seen =
        FindDetectionFrame(*input_.detections, canvas.frame);
    if (seen == nullptr) return;
    const Skeleton& skeleton = input_.detections->header.skeleton;
    const Stroke thin = {kInk, 1.2 * canvas.unit, 0.8};
    for (const Detection& detection : seen->views[canvas.view].detections) {
      for (const Bone& bone : skeleton.bones()) {
        const Keypoint& a = detection.joints[static_cast<size_t>(bone.a)];
        const Keypoint& b = detection.joints[static_cast<size_t>(bone.b)];
        if (!a.found || !b.found) continue;
        pen->Line(canvas.scale * a.px, canvas.scale * b.px, thin);
      }
      for (const Keypoint& joint : detection.joints) {
        if (!joint.found) continue;
        pen->Disc(canvas.scale * joint.px, 2.0 * canvas.unit, kInk);
      }
    }
  }

  const PageInput& input_;
  const Colours colours_;
};

}  // namespace

std::string PicturePath(const std::string& pattern, int64_t frame) {
  const size_t begin = pattern.find('%');
  size_t end = begin == std::string::npos ? begin : begin + 1;
  while (end < pattern.size() && std::isdigit(pattern[end]) != 0) ++end;
  const bool is_number = end < pattern.size() && pattern[end] == 'd' &&
                         pattern.find('%', end) == std::string::npos;
  if (!is_number) {
    throw InputError("--images: found '" + Printable(pattern) +
                     "', expected one number such as %06d in it, or a video "
                     "(.mp4, .mov, .webm, .mkv)");
  }
  std::string number = std::to_string(frame);
  const size_t width = std::strtoul(pattern.c_str() + begin + 1, nullptr, 10);
  if (number.size() < width && width < 30) {
    number.insert(0, width - number.size(), '0');
  }
  return pattern.substr(0, begin) + number + pattern.substr(end + 1);
}

EmbeddedPictures EmbedPictures(const std::vector<std::string>& patterns,
                               size_t max_bytes,
                               const std::function<void()>& step,
                               PageInput* input) {
  EmbeddedPictures embedded;
  input->pictures.assign(input->cameras.size(), {});
  const std::vector<int64_t> frames = FramesOf(*input);
  if (frames.empty()) return embedded;
  double expected = 0.0;
  for (const int width : kWidths) {
    embedded.width = width;
    expected = EstimateBytes(patterns, frames, width);
    if (expected <= static_cast<double>(max_bytes)) break;
  }
  embedded.stride = std::max(1, static_cast<int>(std::ceil(std::min(
                                    expected / static_cast<double>(max_bytes),
                                    static_cast<double>(frames.size())))));
  for (size_t f = 0; f < frames.size();
       f += static_cast<size_t>(embedded.stride)) {
    for (size_t view = 0; view < patterns.size(); ++view) {
      if (patterns[view].empty()) continue;
      const std::string path = PicturePath(patterns[view], frames[f]);
      if (!IsFile(path)) continue;
      input->pictures[view][frames[f]] =
          EncodeJpeg(ScaledDown(ReadPicture(path), embedded.width), kQuality);
    }
    step();
  }
  CountPictures(*input, &embedded);
  // Of the frames that are left every second goes until the text is small
  // enough.
  while (embedded.bytes > max_bytes &&
         embedded.stride <= static_cast<int>(frames.size())) {
    embedded.stride *= 2;
    for (size_t f = 0; f < frames.size(); ++f) {
      if (f % static_cast<size_t>(embedded.stride) == 0) continue;
      for (auto& pictures : input->pictures) pictures.erase(frames[f]);
    }
    CountPictures(*input, &embedded);
  }
  return embedded;
}

size_t WriteAnnotatedFrames(const PageInput& input,
                            const std::vector<std::string>& patterns,
                            const std::string& folder,
                            const std::function<void()>& step) {
  const std::vector<std::string>& views = input.detections->header.view_names;
  AtomicFolder whole(folder);
  for (const std::string& view : views) {
    CheckFileName(view, "view");
    MakeFolder(whole.PathOf(view));
  }
  const FrameArtist artist(input);
  size_t files = 0;
  for (const int64_t frame : FramesOf(input)) {
    for (size_t view = 0; view < views.size(); ++view) {
      const std::string pattern =
          view < patterns.size() ? patterns[view] : std::string();
      AtomicFile file(
          whole.PathOf(views[view] + "/" + PicturePath("%06d.jpg", frame)));
      file.Write(
          EncodeJpeg(artist.Draw(pattern, view, frame), kQualityOfFrames));
      file.Commit();
      ++files;
    }
    step();
  }
  whole.Commit();
  return files;
}

}  // namespace kinegraph
