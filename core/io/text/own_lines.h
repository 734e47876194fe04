// The lines of our own formats, detections and tracks: a header, then a line a
// frame. Only sources include this header, as bulk_json.h.
#ifndef KINEGRAPH_CORE_IO_TEXT_OWN_LINES_H_
#define KINEGRAPH_CORE_IO_TEXT_OWN_LINES_H_

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/io/text/bulk_json.h"

namespace kinegraph {

class OwnLines {
 public:
  // Throws InputError when the file cannot be read.
  explicit OwnLines(const std::string& path) : lines_(path) {}

  // `read` gets the object that the next line holds; file and line stand in
  // front of what it throws. Throws InputError where there is no line.
  template <typename Read>
  void ReadHeader(const Read& read) {
    JsonValue line;
    if (!lines_.Next(&line)) {
      throw InputError(lines_.path(), "", "is empty, expected a header line");
    }
    Take(line, "the header", read);
  }

  // The same for the lines after it; false at the end.
  template <typename Read>
  bool ReadFrame(const Read& read) {
    JsonValue line;
    if (!lines_.Next(&line)) return false;
    Take(line, "the frame", read);
    return true;
  }

  // Throws InputError unless frames ascend.
  void CheckFrame(int64_t frame) {
    if (frame <= last_frame_) {
      throw InputError("frame: found " + std::to_string(frame) + " after " +
                       std::to_string(last_frame_) +
                       ", expected frames to ascend");
    }
    last_frame_ = frame;
  }

  // Text of the line that is being read.
  std::string_view line() const { return lines_.line(); }
  // Of the whole file, read once more; -1 when it is a pipe.
  int64_t CountFrames() const {
    const int64_t lines = lines_.CountLines();
    return lines < 0 ? -1 : lines - 1;
  }

 private:
  template <typename Read>
  void Take(JsonValue line, std::string_view what, const Read& read) const {
    Located(
        lines_.path(), [&] { return lines_.Place(); },
        [&] { read(AsObject(line, what)); });
  }

  JsonLineReader lines_;
  int64_t last_frame_ = -1;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_OWN_LINES_H_
