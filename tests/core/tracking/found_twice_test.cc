#include "core/tracking/found_twice.h"

#include <gtest/gtest.h>

#include <vector>

namespace kinegraph {
namespace {

// Joints on a diagonal of `size_px`, from (at_px, 0) on.
Observation Person(double at_px, double size_px, double confidence,
                   int joints = 11) {
  Observation person;
  for (int j = 0; j < joints; ++j) {
    const double along = size_px * j / 10.0;
    Keypoint joint;
    joint.px = {at_px + 0.6 * along, 0.8 * along};
    joint.confidence = confidence;
    joint.found = true;
    person.joints.push_back(joint);
  }
  person.found_count = joints;
  person.mean_confidence = confidence;
  return person;
}

TEST(FoundTwice, ATwentiethOfTheBoxIsOnePerson) {
  const Observation person = Person(100.0, 200.0, 0.8);
  EXPECT_TRUE(IsOnePerson(person, person));
  EXPECT_TRUE(IsOnePerson(person, Person(109.9, 200.0, 0.8)));
  EXPECT_FALSE(IsOnePerson(person, Person(110.1, 200.0, 0.8)));
  // It scales with the person: far away 5 px are two people.
  EXPECT_FALSE(IsOnePerson(Person(100.0, 60.0, 0.8), Person(105.0, 60.0, 0.8)));
}

TEST(FoundTwice, HalfOfTheJointsMustBeCommon) {
  const Observation whole = Person(100.0, 200.0, 0.8);
  Observation part = whole;
  for (size_t j = 0; j < 8; ++j) part.joints[j].found = false;
  EXPECT_TRUE(IsOnePerson(whole, part));  // three of its three joints
  Observation rest = whole;
  for (size_t j = 9; j < 11; ++j) rest.joints[j].found = false;
  EXPECT_FALSE(IsOnePerson(part, rest));  // one of three
  for (Keypoint& joint : part.joints) joint.found = false;
  EXPECT_FALSE(IsOnePerson(part, whole));
  EXPECT_FALSE(IsOnePerson(part, part));
}

TEST(FoundTwice, WhatHasMoreJointsStaysThenTheSurerOne) {
  std::vector<Observation> seen = {
      Person(100.0, 200.0, 0.5), Person(400.0, 200.0, 0.5),
      Person(101.0, 200.0, 0.9), Person(402.0, 200.0, 0.9)};
  seen[3].joints.back().found = false;
  seen[3].found_count = 10;
  ASSERT_EQ(DropFoundTwice(seen.size(), &seen), 2u);
  EXPECT_EQ(seen[0].joints[0].px.x(), 101.0);
  EXPECT_EQ(seen[1].joints[0].px.x(), 400.0);
}

TEST(FoundTwice, OnlyTheFirstAreLookedAt) {
  std::vector<Observation> seen = {Person(100.0, 200.0, 0.5),
                                   Person(300.0, 200.0, 0.5),
                                   Person(100.0, 200.0, 0.9)};
  EXPECT_EQ(DropFoundTwice(2, &seen), 2u);
  EXPECT_EQ(seen.size(), 3u);
  EXPECT_EQ(seen[0].joints[0].confidence, 0.5);
}

}  // namespace
}  // namespace kinegraph
