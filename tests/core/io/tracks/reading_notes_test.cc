// Units that formats do not specify, and people who are not upright.
#include "core/io/tracks/reading_notes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <string>

#include "core/base/constants.h"
#include "tests/core/io/input_error.h"
#include "tests/core/io/tracks/recordings.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::PosedPerson;
using testing::TemporaryFolder;
using testing::Walk;

// The rotation by an angle about a unit vector.
Eigen::Matrix3d Turned(double deg, const Vector3d& axis) {
  return Eigen::AngleAxisd(deg * kPi / 180.0, axis).toRotationMatrix();
}

std::optional<AxesNote> NoteOf(const TrackSequence& tracks,
                               const std::string& format,
                               const std::optional<AxisMap>& axes = {},
                               const CameraRig& cameras = {}) {
  return FindAxesNote(StanceOf(tracks), cameras, *FindTrackFormat(format),
                      axes);
}

TEST(ReadingNotes, RotatedWorldsAreNotedWithCorrectingAxes) {
  EXPECT_FALSE(NoteOf(Walk(), "trc").has_value());
  EXPECT_FALSE(NoteOf(Walk(), "c3d").has_value());
  struct World {
    Eigen::Matrix3d from_upright;
    std::string up;
    std::string y_up_axes;
  };
  const Vector3d x = Vector3d::UnitX();
  const Vector3d y = Vector3d::UnitY();
  for (const World& world : {World{Turned(90, x), "-y", "x,-y,-z"},
                             {Turned(-90, x), "y", "x,y,z"},
                             {Turned(180, x), "-z", "x,-z,y"},
                             {Turned(90, y), "x", "y,x,-z"},
                             {Turned(-90, y), "-x", "y,-x,z"}}) {
    const TrackSequence tracks = Walk(world.from_upright);
    for (const std::string format : {"trc", "bvh", "gltf", "c3d"}) {
      const auto note = NoteOf(tracks, format);
      ASSERT_TRUE(note.has_value()) << world.up << " in " << format;
      EXPECT_THAT(note->text, HasSubstr("people stand along " + world.up +
                                        " of the world, not along z"));
      if (format != "c3d") {
        EXPECT_EQ(note->axes, world.y_up_axes);
      }
      // The recommended flag corrects the axes and removes the note.
      const AxisMap axes = AxisMap::Parse(note->axes);
      const Vector3d shown = axes.Apply(world.from_upright * Vector3d::UnitZ());
      const Vector3d expected =
          format == "c3d" ? Vector3d::UnitZ() : Vector3d::UnitY();
      EXPECT_LT((shown - expected).norm(), 1e-12);
      EXPECT_FALSE(NoteOf(tracks, format, axes).has_value());
    }
    EXPECT_FALSE(NoteOf(tracks, "csv").has_value()) << "has no upward axis";
  }
}

TEST(ReadingNotes, SmallTiltIsNotNotedAndObliqueTiltHasNoAxes) {
  const Vector3d axis = Vector3d(1.0, 0.5, 0.0).normalized();
  EXPECT_FALSE(NoteOf(Walk(Turned(15, axis)), "trc").has_value());
  const auto note =
      NoteOf(Walk(Turned(55, Vector3d(1.0, 1.0, 0.0).normalized())), "trc");
  ASSERT_TRUE(note.has_value());
  EXPECT_EQ(note->axes, "") << "tilted away from every axis";
}

TEST(ReadingNotes, LyingAndHandstandAreNotRotatedWorlds) {
  // On the back, on the floor and on a bed.
  for (const double height_m : {0.1, 0.7}) {
    TrackSequence lying = Walk();
    for (TrackFrame& frame : lying.frames) {
      for (Joint3d& joint : frame.people[0].joints) {
        Vector3d& at = joint.position_m;
        at = {at.z(), at.y(), height_m + 0.1 * (at.x() > 1.0 ? 1.0 : 0.0)};
      }
    }
    EXPECT_FALSE(NoteOf(lying, "trc").has_value()) << height_m;
  }
  const auto handstand = [](PosedPerson* person) {
    for (const std::string side : {"l_", "r_"}) {
      person->Put(side + "wrist",
                  person->At(side + "shoulder") + Vector3d(0.0, 0.0, 0.55));
    }
  };
  EXPECT_FALSE(NoteOf(Walk(Turned(180, Vector3d::UnitX()), handstand), "trc")
                   .has_value());
  // Two of three stand, one lies.
  TrackSequence mixed = Walk();
  for (TrackFrame& frame : mixed.frames) {
    for (int64_t id = 1; id < 3; ++id) {
      PersonPose other = frame.people[0];
      other.id = TrackId(id);
      for (Joint3d& joint : other.joints) {
        if (id == 2) std::swap(joint.position_m.x(), joint.position_m.z());
      }
      frame.people.push_back(other);
    }
  }
  EXPECT_FALSE(NoteOf(mixed, "trc").has_value());
}

TEST(ReadingNotes, CamerasMustAgree) {
  // One rig in which the camera's downward image axis is the world's -z, and
  // one in which it is the world's y.
  CameraParameters parameters;
  parameters.name = "a";
  parameters.K << 900, 0, 640, 0, 900, 360, 0, 0, 1;
  parameters.R << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  const CameraRig z_up = {Camera(parameters)};
  parameters.R = Eigen::Matrix3d::Identity();
  const CameraRig y_down = {Camera(parameters)};
  const TrackSequence tracks = Walk(Turned(90, Vector3d::UnitX()));
  EXPECT_TRUE(NoteOf(tracks, "trc", {}, y_down).has_value());
  EXPECT_FALSE(NoteOf(tracks, "trc", {}, z_up).has_value());
}

TEST(ReadingNotes, AnimalsGiveNoNote) {
  TrackSequence tracks = Walk(Turned(90, Vector3d::UnitX()));
  std::vector<std::string> joints = Body25().joints();
  joints[0] = "tail_tip";
  tracks.header.skeleton = Skeleton("dog", joints, {});
  EXPECT_FALSE(NoteOf(tracks, "trc").has_value());
}

// A person of 1.4 m from neck to ankle, as Blender writes it.
std::string Bvh(double unit_m) {
  const auto number = [unit_m](double m) { return std::to_string(m / unit_m); };
  const auto joint = [&](const std::string& name, double x, double y,
                         const std::string& inside) {
    return "JOINT " + name + " {\nOFFSET " + number(x) + " " + number(y) +
           " 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n" + inside + "}\n";
  };
  const std::string end = "End Site\n{\nOFFSET 0 0.1 0\n}\n";
  std::string legs;
  for (const double side : {1.0, -1.0}) {
    const std::string s = side > 0.0 ? "Left" : "Right";
    legs +=
        joint(s + "UpLeg", 0.1 * side, 0.0,
              joint(s + "Leg", 0.0, -0.45, joint(s + "Foot", 0.0, -0.45, end)));
  }
  return "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 6 Xposition "
         "Yposition "
         "Zposition Zrotation Xrotation Yrotation\n" +
         joint("Neck", 0.0, 0.5, end) + legs +
         "}\nMOTION\nFrames: 1\nFrame Time: 0.04\n" + number(0.0) + " " +
         number(1.0) + " 0" +
         [] {
           std::string zeros;
           for (int i = 0; i < 3 * 8; ++i) zeros += " 0";
           return zeros;
         }() +
         "\n";
}

TEST(ReadingNotes, ImplausibleSizesAreNotedWithFittingUnits) {
  const TemporaryFolder folder;
  const std::string cm = folder.Write("cm.bvh", Bvh(0.01));
  const std::string m = folder.Write("m.bvh", Bvh(1.0));
  const TrackSequence right = ReadTracks(cm);
  EXPECT_EQ(UnitNote(cm, {}, right), "");
  EXPECT_THAT(UnitNote(m, {}, ReadTracks(m)),
              HasSubstr("people read from bvh in cm have an extent of "
                        "0.0141 m: --unit=m makes that 1.4 m"));
  TrackReadOptions metres;
  metres.unit_m = ParseLengthUnit("m");
  const TrackSequence scaled = ReadTracks(m, metres);
  EXPECT_EQ(UnitNote(m, metres, scaled), "");
  for (size_t j = 0; j < 8; ++j) {
    // The file in metres has six decimals, and a foot is the sum of four
    // offsets: at most 4 * 5e-7 m.
    EXPECT_LT((scaled.frames[0].people[0].joints[j].position_m -
               right.frames[0].people[0].joints[j].position_m)
                  .norm(),
              2e-6);
  }
  EXPECT_THAT(UnitNote(cm, metres, ReadTracks(cm, metres)),
              HasSubstr("people read from bvh in m have an extent of 141 m: "
                        "--unit=cm"));
  EXPECT_TRUE(LeavesUnitOpen(cm));
  EXPECT_THAT(InputErrorOf([] { ParseLengthUnit("inch"); }),
              HasSubstr("--unit: found 'inch', expected m, cm or mm"));
  const std::string csv =
      folder.Write("a.csv", "frame,time_s,id,joint,x_m,y_m,z_m,status\n");
  EXPECT_THAT(
      InputErrorOf([&] { ReadTracks(csv, metres); }),
      HasSubstr("a.csv: is csv, which specifies its unit; --unit applies "
                "to tracks of npz, bvh"));
}

}  // namespace
}  // namespace kinegraph
