// kinegraph-convert: converts calibrations, detections and tracks between
// formats.
#include <gflags/gflags.h>

#include <cstdio>
#include <string>

#include "apps/common/adapter_flag.h"
#include "apps/common/app.h"
#include "apps/common/track_files.h"
#include "core/io/conversion.h"

DEFINE_string(from, "auto",
              "format of the input; auto recognises it by content");
DEFINE_string(to, "",
              "format of the result; empty: the format of tracks that has the "
              "extension of --out, such as .c3d");
DEFINE_string(in, "", "file or folder to read");
DEFINE_string(
    out, "",
    "file to write, or folder for formats of several files (TRC: one per "
    "person; NAME.trc writes one file and needs one person, see --person)");
DEFINE_string(skeleton, "", "skeleton of the input if it does not specify it");
DEFINE_double(frame_rate, 0.0,
              "frame rate [Hz] if the input does not specify it");
DEFINE_string(unit, "",
              "unit of a calibration, or of tracks whose format does not "
              "specify it (such as BVH): m, cm or mm");
DEFINE_string(image_size, "",
              "image size [px] of a calibration without one: W,H");
DEFINE_string(axes, "",
              "world axes that become the file's X,Y,Z, such as x,-z,y; used "
              "for those of input and output whose format has axes of its own "
              "(see --formats); if neither has any, for the input");
DEFINE_string(markers, "ours",
              "names of the joints in formats that name them: ours (l_hip), "
              "pose2sim (LHip, Hip) or opensim (LHip, midHip)");
DEFINE_string(person, "",
              "the only person to write: the number of the identity, or its "
              "name in the input or in NAME.identity.jsonl beside it");
DEFINE_string(
    set, "",
    "keys that control reading: cameras.KEY=value;detections.KEY=value;"
    "tracks.first_frame=N");
DEFINE_bool(formats, false, "list the formats and exit");

namespace kinegraph {
namespace {

ConversionOptions OptionsOfFlags() {
  ConversionOptions options;
  options.in = FLAGS_in;
  options.out = FLAGS_out;
  options.from = FLAGS_from;
  options.to = FLAGS_to;
  options.skeleton = FLAGS_skeleton;
  options.frame_rate_hz = FLAGS_frame_rate;
  options.unit = FLAGS_unit;
  options.image_size = FLAGS_image_size;
  options.axes = FLAGS_axes;
  options.markers = FLAGS_markers;
  options.person = FLAGS_person;
  options.set = FLAGS_set;
  return options;
}

void RunConvert() {
  UseAdapterFlag();
  if (FLAGS_formats) {
    std::fputs(FormatList().c_str(), stdout);
    return;
  }
  RequireFlag("from", FLAGS_from);
  RequireFlag("in", FLAGS_in);
  RequireFlag("out", FLAGS_out);
  const Conversion conversion = Convert(OptionsOfFlags());
  SayNotes(conversion.lost_fields, "kinegraph-convert: ");
  std::fprintf(SummaryStream(FLAGS_out), "%s -> %s\n", conversion.what.c_str(),
               FLAGS_out.c_str());
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::RunApp(
      argc, argv,
      {"convert",
       "converts calibrations, detections and tracks between formats",
       "--in=PATH --out=PATH [--to=FORMAT] [--from=FORMAT]",
       {"--in=take.jsonl --out=take.trc",
        "--in=calibration.json --to=pose2sim --out=calibration.toml"}},
      kinegraph::RunConvert);
}
