// Reads detections from texts, and compares detections.
#ifndef KINEGRAPH_TESTS_CORE_IO_DETECTIONS_DETECTION_FILES_H_
#define KINEGRAPH_TESTS_CORE_IO_DETECTIONS_DETECTION_FILES_H_

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/io/detections/source.h"
#include "tests/core/io/input_error.h"
#include "tests/support/test_data.h"

namespace kinegraph::testing {

// A recording in memory as a source.
class SequenceSource final : public DetectionSource {
 public:
  explicit SequenceSource(const DetectionSequence& sequence)
      : sequence_(sequence) {}
  const DetectionHeader& header() const override { return sequence_.header; }
  bool Next(DetectionFrame* frame) override {
    if (next_ == sequence_.frames.size()) return false;
    *frame = sequence_.frames[next_++];
    return true;
  }

 private:
  const DetectionSequence& sequence_;
  size_t next_ = 0;
};

// Reads the recording in a file of this name and content.
inline DetectionSequence RecordingIn(const std::string& name,
                                     const std::string& text,
                                     const DetectionReadOptions& options = {}) {
  const TemporaryFolder folder;
  return ReadDetections(folder.Write(name, text), options);
}

// The message with which that file is rejected.
inline std::string FaultOf(const std::string& name, const std::string& text,
                           const DetectionReadOptions& options = {}) {
  return FaultIn(name, text, [&](const std::string& path) {
    ReadDetections(path, options);
  });
}

// Expects each text to be rejected with a message that contains the text given
// with it.
inline void ExpectFaults(const std::string& name, const Faults& faults,
                         const DetectionReadOptions& options = {}) {
  ExpectFaultsIn(name, faults, [&](const std::string& path) {
    ReadDetections(path, options);
  });
}

inline const Keypoint& JointOf(const DetectionSequence& recording, size_t frame,
                               size_t view, size_t person, size_t joint) {
  return recording.frames.at(frame)
      .views.at(view)
      .detections.at(person)
      .joints.at(joint);
}

// Expects bit-identical detections, except for their times.
inline void ExpectSameDetections(const DetectionSequence& a,
                                 const DetectionSequence& b) {
  EXPECT_EQ(a.header.skeleton.joints(), b.header.skeleton.joints());
  EXPECT_EQ(a.header.view_names, b.header.view_names);
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (size_t f = 0; f < a.frames.size(); ++f) {
    EXPECT_EQ(a.frames[f].frame, b.frames[f].frame);
    ASSERT_EQ(a.frames[f].views.size(), b.frames[f].views.size());
    for (size_t v = 0; v < a.frames[f].views.size(); ++v) {
      const auto& people_a = a.frames[f].views[v].detections;
      const auto& people_b = b.frames[f].views[v].detections;
      ASSERT_EQ(people_a.size(), people_b.size()) << a.frames[f].frame;
      for (size_t p = 0; p < people_a.size(); ++p) {
        EXPECT_EQ(people_a[p].index_in_file, people_b[p].index_in_file);
        ASSERT_EQ(people_a[p].joints.size(), people_b[p].joints.size());
        for (size_t j = 0; j < people_a[p].joints.size(); ++j) {
          const Keypoint& joint_a = people_a[p].joints[j];
          const Keypoint& joint_b = people_b[p].joints[j];
          ASSERT_EQ(joint_a.found, joint_b.found);
          if (!joint_a.found) continue;
          EXPECT_EQ(joint_a.px, joint_b.px);
          EXPECT_EQ(joint_a.confidence, joint_b.confidence);
        }
      }
    }
  }
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_CORE_IO_DETECTIONS_DETECTION_FILES_H_
