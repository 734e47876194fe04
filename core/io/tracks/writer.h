// Writing 3D tracks in our own format.
#ifndef KINEGRAPH_CORE_IO_TRACKS_WRITER_H_
#define KINEGRAPH_CORE_IO_TRACKS_WRITER_H_

#include <memory>
#include <string>

#include "core/data/identity_edit.h"
#include "core/data/pose.h"

namespace kinegraph {

struct TrackWriteOptions {
  // Writes score, matches and weights of each person too, and the view names
  // in the header.
  bool observations = false;
  PersonNames names = {};  // in the header
  // For adapters: what each person is called, in the header, and beside a
  // covariance the probability that the joint lies within so far [m].
  std::vector<std::string> titles = {};
  double within_m = 0.0;
};

// JSON Lines, one frame a line; numbers read back bit for bit. The file appears
// under its name in Commit(); without it nothing is left.
//
//   TrackWriter writer(path, header);
//   for (const TrackFrame& frame : frames) writer.Write(frame);
//   writer.Commit();
class TrackWriter {
 public:
  // Throws InputError when the file cannot be made, std::logic_error when
  // header.config_json is no JSON object.
  TrackWriter(const std::string& path, const TrackHeader& header,
              const TrackWriteOptions& options = {});
  ~TrackWriter();
  TrackWriter(const TrackWriter&) = delete;
  TrackWriter& operator=(const TrackWriter&) = delete;

  // Frames ascend. Throws std::logic_error when they do not, when a number is
  // not finite or when a person does not fit the header.
  void Write(const TrackFrame& frame);
  // Hands over what was written so far, to whoever reads the other end of a
  // pipe. A file appears in Commit() all the same.
  void Flush();
  void Commit();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// All frames at once.
void WriteTracks(const std::string& path, const TrackSequence& sequence,
                 const TrackWriteOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_WRITER_H_
