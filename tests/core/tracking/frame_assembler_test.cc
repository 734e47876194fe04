#include <gtest/gtest.h>

#include <vector>

#include "core/tracking/tracker.h"

namespace kinegraph {
namespace {

PersonPose Person(int64_t id) {
  PersonPose person;
  person.id = TrackId(id);
  person.joints.resize(1);
  return person;
}

std::vector<int64_t> Taken(FrameAssembler* assembler) {
  std::vector<TrackFrame> frames;
  assembler->ExtractComplete(&frames);
  std::vector<int64_t> numbers;
  for (const TrackFrame& frame : frames) numbers.push_back(frame.frame);
  return numbers;
}

TEST(FrameAssemblerTest, EmptyFramesLeaveAtOnce) {
  FrameAssembler assembler;
  assembler.BeginFrame(7, 0);
  EXPECT_EQ(Taken(&assembler), (std::vector<int64_t>{7}));
}

TEST(FrameAssemblerTest, AFrameWaitsForEveryTrackAndOrderIsKept) {
  FrameAssembler assembler;
  assembler.BeginFrame(1, 0);
  assembler.Join();
  assembler.Join();
  assembler.BeginFrame(2, 40);
  assembler.Join();
  PersonPose late = Person(5);
  assembler.Resolve(1, &late);
  PersonPose second = Person(5);
  assembler.Resolve(2, &second);
  EXPECT_TRUE(Taken(&assembler).empty()) << "frame 1 still waits";
  PersonPose early = Person(3);
  assembler.Resolve(1, &early);
  std::vector<TrackFrame> frames;
  assembler.ExtractComplete(&frames);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].people[0].id, TrackId(3)) << "by ascending id";
  EXPECT_EQ(frames[0].people[1].id, TrackId(5));
  EXPECT_EQ(frames[1].time, 40);
}

TEST(FrameAssemblerTest, APersonNotWrittenStillResolves) {
  FrameAssembler assembler;
  assembler.BeginFrame(1, 0);
  assembler.Join();
  assembler.Resolve(1, nullptr);
  std::vector<TrackFrame> frames;
  assembler.ExtractComplete(&frames);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_TRUE(frames[0].people.empty());
}

}  // namespace
}  // namespace kinegraph
