// Writing 3D tracks in kinegraph's own format.
#ifndef KINEGRAPH_CORE_IO_TRACKS_WRITER_H_
#define KINEGRAPH_CORE_IO_TRACKS_WRITER_H_

#include <memory>
#include <string>

#include "core/data/identity_edit.h"
#include "core/data/pose.h"

namespace kinegraph {

struct TrackWriteOptions {
  // Writes score, matches and weights of each person, and the view names in the
  // header.
  bool observations = false;
  PersonNames names = {};  // for the header
  // For adapters: the title of each person (PersonTitles), for the header.
  std::vector<std::string> titles = {};
  // For adapters: with each covariance, also writes the probability that the
  // true joint lies within this distance of the estimate; 0: does not.
  double within_m = 0.0;
};

// JSON Lines: a header, then one frame per line; numbers are read back as the
// same bits.
// Commit() makes the file appear; without it, the file is discarded.
//
//   TrackWriter writer(path, header);
//   for (const TrackFrame& frame : frames) writer.Write(frame);
//   writer.Commit();
class TrackWriter {
 public:
  // Throws InputError if the file cannot be created or the header's frame rate
  // is out of range, std::logic_error if header.config_json is not a JSON
  // object.
  TrackWriter(const std::string& path, const TrackHeader& header,
              const TrackWriteOptions& options = {});
  ~TrackWriter();
  TrackWriter(const TrackWriter&) = delete;
  TrackWriter& operator=(const TrackWriter&) = delete;

  // Frame numbers must ascend. Throws std::logic_error if they do not, if a
  // number is not finite or if a person does not match the header; InputError
  // for a frame number above 2^50.
  void Write(const TrackFrame& frame);
  // Passes what was written so far to the reader of a pipe. A file appears only
  // in Commit().
  void Flush();
  void Commit();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// Writes all frames.
void WriteTracks(const std::string& path, const TrackSequence& sequence,
                 const TrackWriteOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_WRITER_H_
