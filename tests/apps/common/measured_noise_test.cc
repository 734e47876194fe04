#include "apps/common/measured_noise.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/core/io/input_error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Made-up values, the same for all groups.
std::string ModelText() {
  std::string noise;
  std::string missing;
  for (const char* group :
       {"face", "shoulder", "elbow", "wrist", "hip", "knee", "ankle"}) {
    const std::string begin =
        (noise.empty() ? "\"" : ", \"") + std::string(group) + "\": ";
    missing += begin + R"({"p_missing_if_not": 0.03,
      "p_missing_if_other_person_in_front": 0.3, "p_stay_missing": 0.75})";
    noise += begin + R"({"sigma_m_per_axis": 0.025,
      "sigma_if_other_person_in_front": 0.05, "student_t_dof_of_core": 4,
      "static_share": 0.5, "slow_share": 0.25, "slow_rho_per_frame": 0.84,
      "p_outlier_over_4_sigma": 0.04, "outlier_median_in_sigma": 5.5,
      "p_outlier_stays": 0.5})";
  }
  return "{\"missing_joint\": {" + missing + "}, \"noise\": {" + noise + R"(},
    "face_found_by_camera_azimuth": {"bins": "thirds", "nose": [0.1, 0.9, 0.2]},
    "missed_person": {"p_missed_if_not": 0.02, "run_length_mean": 6.0,
      "p_missed_if_mostly_hidden": 0.7},
    "left_right_swap": {"arm": {"p": 0.001, "run_length_mean": 1.0},
      "whole": {"p": 0.002, "run_length_mean": 2.0},
      "leg": {"p": 0.003, "run_length_mean": 3.0}},
    "false_positive_person": {"mean_per_image": 0.24},
    "fragment": {"mean_per_person_view": 0.03},
    "outlier_on_other_persons_same_joint": {"share": 0.32},
    "confidence": {"plain": {"mean": 0.8, "sd": 0.15},
      "other_person_in_front": {"mean": 0.6}, "outlier": {"mean": 0.4}}
  })";
}

// `text` with `from` replaced by `to`.
std::string Changed(const std::string& from, const std::string& to) {
  std::string text = ModelText();
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

NoiseOptions NoiseOf(const std::string& text) {
  const testing::TemporaryFolder folder;
  NoiseOptions noise;
  ApplyNoiseModel(folder.Write("model.json", text), NoiseModelOptions(),
                  /*focal_px=*/1000.0, &noise);
  return noise;
}

std::string MessageOf(const std::string& text) {
  return testing::InputErrorOf([&] { NoiseOf(text); });
}

TEST(MeasuredNoise, EveryFigureCounts) {
  const NoiseOptions noise = NoiseOf(ModelText());
  ASSERT_EQ(noise.by_class.size(), static_cast<size_t>(kJointClassCount));
  const JointNoise& knee = noise.by_class.at(JointClass::kKnee);
  // A core of 25 px, half of it static: Student's tails of 4 degrees of freedom
  // double the variance of the rest, which makes 1.5 in all.
  EXPECT_NEAR(knee.sigma_px, 25.0 * std::sqrt(1.5), 1e-12);
  EXPECT_NEAR(knee.static_share, 0.5 / 1.5, 1e-15);
  EXPECT_NEAR(knee.white_share, 0.25 * 2.0 / 1.5, 1e-15);
  EXPECT_NEAR(knee.correlation_time_s, -0.04 / std::log(0.84), 1e-15);
  EXPECT_THAT(
      (std::vector<double>{knee.student_dof, knee.outlier_rate,
                           knee.outlier_burst_s, knee.outlier_min_px,
                           knee.outlier_max_px, knee.outlier_on_other,
                           knee.missing_rate, knee.missing_burst_s,
                           knee.hidden_missing_rate, knee.hidden_noise_factor}),
      ElementsAre(4.0, 0.04, 0.08, 100.0, 175.0, 0.32, 0.03, 0.16, 0.3, 2.0));
  EXPECT_THAT(noise.found_by_azimuth.at("nose"),
              ElementsAre(DoubleNear(0.1, 1e-15), DoubleNear(0.9, 1e-15),
                          DoubleNear(0.2, 1e-15)));
  EXPECT_THAT(
      (std::vector<double>{
          noise.missed_rate, noise.missed_burst_s, noise.hidden_missed_rate,
          noise.swap_arm_rate, noise.swap_whole_rate, noise.swap_leg_rate,
          noise.swap_burst_s, noise.false_people, noise.fragment_rate,
          noise.confidence, noise.confidence_sigma}),
      ElementsAre(0.02, 0.24, 0.7, 0.001, 0.002, 0.003, 0.08, 0.24, 0.03, 0.8,
                  0.15));
  EXPECT_NEAR(noise.hidden_confidence_factor, 0.75, 1e-15);
  EXPECT_NEAR(noise.outlier_confidence_factor, 0.5, 1e-15);
}

TEST(MeasuredNoise, NamesFileAndKeyOfWhatIsWrong) {
  const struct {
    const char *from, *to, *key;
  } changes[] = {
      {"student_t_dof_of_core\": 4", "student_t_dof_of_core\": 1.5",
       "student_t_dof_of_core"},
      {"p_stay_missing\": 0.75", "p_stay_missing\": 1.7", "p_stay_missing"},
      {"\"static_share\"", "\"statik\"", "static_share"},
      {"\"knee\": {\"p_m", "\"toe\": {\"p_m", "knee"},
      {"[0.1, 0.9, 0.2]", "[0.1, 9, 0.2]", "nose"},
      {"[0.1, 0.9, 0.2]", "[]", "nose"}};
  for (const auto& [from, to, key] : changes) {
    const std::string message = MessageOf(Changed(from, to));
    EXPECT_THAT(message, HasSubstr("model.json"));
    EXPECT_THAT(message, HasSubstr(key));
  }
  EXPECT_THAT(MessageOf("[1, 2]"), HasSubstr("missing_joint"));
  EXPECT_THAT(MessageOf(ModelText().substr(0, 300)), HasSubstr("model.json"));
  NoiseOptions noise;
  EXPECT_THROW(
      ApplyNoiseModel("/nowhere/model.json", NoiseModelOptions(), 1.0, &noise),
      InputError);
}

}  // namespace
}  // namespace kinegraph
