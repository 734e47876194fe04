#include "solvers/batch/person_recording.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "solvers/noise/person_noise.h"
#include "tests/support/solver_problem.h"

namespace kinegraph {
namespace {

// Nothing of what it says is asked here.
class SomeFactor final : public GeneralFactor {
 public:
  int residual_count() const override { return 1; }
  int state_count() const override { return 2; }
  bool Evaluate(double const* const*, double*, double**) const override {
    return false;
  }
};

void ExpectSame(const PixelMeasurement& a, const PixelMeasurement& b) {
  EXPECT_EQ(a.px, b.px);
  EXPECT_EQ(a.bias_px, b.bias_px);
  EXPECT_EQ(a.sigma_px, b.sigma_px);
  EXPECT_EQ(a.model_sigma_px, b.model_sigma_px);
  EXPECT_EQ(a.log_confidence, b.log_confidence);
  EXPECT_EQ(a.information, b.information);
  EXPECT_EQ(a.offset_s, b.offset_s);
  EXPECT_EQ(a.camera, b.camera);
  EXPECT_EQ(a.view_slot, b.view_slot);
  EXPECT_EQ(a.gated, b.gated);
  EXPECT_EQ(a.weight, b.weight);
}

void ExpectSame(const JointChain& a, const JointChain& b) {
  EXPECT_EQ(a.states, b.states);
  EXPECT_EQ(a.process_noise, b.process_noise);
  EXPECT_EQ(a.first, b.first);
  EXPECT_EQ(a.prior.A, b.prior.A);
  EXPECT_EQ(a.prior.x0, b.prior.x0);
  ASSERT_EQ(a.measurements.size(), b.measurements.size());
  for (size_t m = 0; m < a.measurements.size(); ++m) {
    ExpectSame(a.measurements[m], b.measurements[m]);
  }
}

void ExpectSame(const PersonProblem& a, const PersonProblem& b) {
  EXPECT_EQ(a.times, b.times);
  ASSERT_EQ(a.joints.size(), b.joints.size());
  for (size_t j = 0; j < b.joints.size(); ++j) {
    ExpectSame(a.joints[j], b.joints[j]);
  }
  ASSERT_EQ(a.user.size(), b.user.size());
  for (size_t i = 0; i < b.user.size(); ++i) {
    const std::vector<StateKey>& keys = b.user[i].keys;
    ASSERT_EQ(a.user[i].keys.size(), keys.size());
    for (size_t s = 0; s < keys.size(); ++s) {
      EXPECT_EQ(a.user[i].keys[s].frame, keys[s].frame);
      EXPECT_EQ(a.user[i].keys[s].joint, keys[s].joint);
    }
  }
}

PersonProblem Unpacked(const PersonRecording& recording) {
  PersonProblem problem = recording.Part(0, recording.frame_count());
  problem.user = recording.graph.user;
  return problem;
}

// Three pieces of 256 frames and a bit, in which each measurement's information
// depends on when its view saw it last.
class PersonRecordingTest : public testing::SolverProblemTest {
 protected:
  void SetUp() override {
    options_.correlation_time_s = 0.1;
    MakeRecording();
  }

  void MakeRecording() {
    testing::SimulatedNoise noise;
    noise.missing = 0.3;
    noise.outliers = 0.1;
    noise.confidence_low = 0.2;
    Rig rig;
    rig.frames = 800;
    rig.later_each_ns = 3'000'000;
    Make(rig, noise);
    Assembler direct(scene_, options_);  // without what Make has gated
    problem_ = direct.EmptyProblem();
    for (const EstimatorFrame& frame : recording_.frames) {
      direct.Append(frame, &problem_);
    }
  }

  PersonRecording Assemble() {
    PackedFrames frames;
    for (const EstimatorFrame& frame : recording_.frames) frames.Push(frame);
    Assembler assembler(scene_, options_);
    records_.clear();
    PersonRecording recording =
        AssembleRecording(&frames, &assembler, &records_);
    EXPECT_TRUE(frames.empty());
    return recording;
  }

  std::vector<FrameRecord> records_;
};

TEST_F(PersonRecordingTest, IsWhatTheAssemblerMakesBitByBit) {
  ExpectSame(Unpacked(Assemble()), problem_);
  ASSERT_EQ(records_.size(), 800u);
  Assembler direct(scene_, options_);
  PersonProblem ignored = direct.EmptyProblem();
  for (size_t k = 0; k < records_.size(); ++k) {
    const FrameRecord record = direct.Append(recording_.frames[k], &ignored);
    EXPECT_EQ(records_[k].frame, record.frame);
    EXPECT_EQ(records_[k].score, record.score);
    EXPECT_EQ(records_[k].views.size(), record.views.size());
    EXPECT_EQ(records_[k].triangulated, record.triangulated);
  }
}

TEST_F(PersonRecordingTest, KeepsAUsersFactorsInTheirFrames) {
  options_.user_factors = [](const UserFrame& frame) {
    std::vector<UserFactor> factors;
    if (!frame.has_previous || frame.frame % 3 != 0) return factors;
    UserFactor factor;
    factor.factor = std::make_shared<SomeFactor>();
    factor.states = {{1, 1}, {1, 0}};
    factors.push_back(factor);
    return factors;
  };
  MakeRecording();
  ASSERT_GE(problem_.user.size(), 260u);  // every third of 800 frames
  ExpectSame(Unpacked(Assemble()), problem_);
}

TEST_F(PersonRecordingTest, PartsAreThoseOfTheWhole) {
  const PersonRecording recording = Assemble();
  for (const size_t begin : {size_t{0}, size_t{255}, size_t{256}}) {
    for (const size_t end : {size_t{257}, size_t{512}, size_t{800}}) {
      const PersonProblem part = recording.Part(begin, end);
      ASSERT_EQ(part.times.size(), end - begin);
      for (size_t j = 0; j < part.joints.size(); ++j) {
        const JointChain& cut = part.joints[j];
        const JointChain& whole = problem_.joints[j];
        ASSERT_EQ(cut.states.size(), end - begin);
        ASSERT_EQ(cut.process_noise.size(), end - begin - 1);
        ASSERT_EQ(cut.first.size(), end - begin + 1);
        const int32_t before = whole.first[begin];
        for (size_t k = begin; k <= end; ++k) {
          ASSERT_EQ(cut.first[k - begin], whole.first[k] - before);
        }
        ASSERT_EQ(static_cast<int32_t>(cut.measurements.size()),
                  cut.first.back());
        for (size_t m = 0; m < cut.measurements.size(); ++m) {
          ExpectSame(cut.measurements[m],
                     whole.measurements[static_cast<size_t>(before) + m]);
        }
      }
    }
  }
}

TEST_F(PersonRecordingTest, PiecesAreAllFramesOnceWithTheNextOne) {
  const PersonRecording recording = Assemble();
  size_t next = 0;
  recording.ForEachPiece([&](const PersonRecording::Piece& piece) {
    EXPECT_EQ(piece.begin, next);
    next = piece.end;
    EXPECT_EQ(piece.part.times.size(),
              std::min<size_t>(piece.end + 1, 800) - piece.begin);
  });
  EXPECT_EQ(next, 800u);
  PersonRecording().ForEachPiece([](const PersonRecording::Piece&) { FAIL(); });
}

TEST_F(PersonRecordingTest, ClearedMeasurementsAreNone) {
  PersonRecording recording = Assemble();
  recording.measurements.Clear();
  const PersonProblem part = recording.Part(100, 300);
  for (const JointChain& chain : part.joints) {
    EXPECT_EQ(chain.first, std::vector<int32_t>(201, 0));
    EXPECT_TRUE(chain.measurements.empty());
  }
}

// What is learnt piece by piece, and then forgotten, leaves the same problem.
TEST_F(PersonRecordingTest, NoiseLearntInPiecesIsThatOfTheWhole) {
  options_ = GraphOptions();  // learns all there is
  MakeRecording();
  PersonRecording recording = Assemble();
  PersonNoise whole(scene_, options_);
  whole.LearnRecording([&](const PersonNoise::FrameVisitor& visit) {
    for (size_t k = 0; k < problem_.times.size(); ++k) visit(problem_, k);
  });
  whole.Apply(&problem_);
  PersonNoise pieces(scene_, options_);
  pieces.LearnRecording([&](const PersonNoise::FrameVisitor& visit) {
    recording.ForEachPiece([&](const PersonRecording::Piece& piece) {
      for (size_t k = piece.begin; k < piece.end; ++k) {
        visit(piece.part, k - piece.begin);
      }
    });
  });
  pieces.ApplyProcessNoise(&recording.graph);
  recording.ChangeNoise([&](PersonRecording::Piece* piece) {
    pieces.ApplyPixelNoise(piece->begin, piece->end, &piece->part);
  });
  EXPECT_EQ(ToString(pieces.Learnt()), ToString(whole.Learnt()));
  ExpectSame(Unpacked(recording), problem_);
  recording.measurements.SettleNoise();
  for (JointChain& chain : problem_.joints) {
    for (PixelMeasurement& measurement : chain.measurements) {
      ASSERT_NE(measurement.model_sigma_px, measurement.sigma_px);
      measurement.model_sigma_px = measurement.sigma_px;
      measurement.log_confidence = 0.0f;
    }
  }
  ExpectSame(Unpacked(recording), problem_);
}

// Views may weigh a joint differently, too.
TEST_F(PersonRecordingTest, SettledNoiseKeepsTheInformationOfEachView) {
  PersonRecording recording = Assemble();
  recording.measurements.SettleNoise();
  const PersonProblem settled = Unpacked(recording);
  bool differ = false;
  for (size_t j = 0; j < problem_.joints.size(); ++j) {
    const auto& measurements = problem_.joints[j].measurements;
    for (size_t m = 0; m < measurements.size(); ++m) {
      EXPECT_EQ(settled.joints[j].measurements[m].information,
                measurements[m].information);
      differ |= measurements[m].information != measurements[0].information;
    }
  }
  EXPECT_TRUE(differ);
}

}  // namespace
}  // namespace kinegraph
