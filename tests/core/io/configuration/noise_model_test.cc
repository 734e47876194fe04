#include "core/io/configuration/noise_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using ::testing::HasSubstr;

// Figures made up for this test.
std::string ModelText() {
  return R"({
    "missing_joint": {"knee": {"p_missing_if_not": 0.03,
      "p_missing_if_other_person_in_front": 0.3, "p_stay_missing": 0.7}},
    "face_found_by_camera_azimuth": {"bins": "thirds", "nose": [0.1, 0.9, 0.2]},
    "missed_person": {"p_missed_if_not": 0.02, "run_length_mean": 6.0,
      "p_missed_if_mostly_hidden": 0.7},
    "left_right_swap": {"arm": {"p": 0.001, "run_length_mean": 1.0},
      "whole": {"p": 0.002, "run_length_mean": 2.0},
      "leg": {"p": 0.003, "run_length_mean": 3.0}},
    "noise": {"knee": {"sigma_m_per_axis": 0.028,
      "sigma_if_other_person_in_front": 0.056, "student_t_dof_of_core": 4.5,
      "static_share": 0.4, "slow_share": 0.5, "slow_rho_per_frame": 0.84,
      "p_outlier_over_4_sigma": 0.04, "outlier_median_in_sigma": 5.6,
      "p_outlier_stays": 0.56}},
    "false_positive_person": {"mean_per_image": 0.24},
    "fragment": {"mean_per_person_view": 0.03},
    "outlier_on_other_persons_same_joint": {"share": 0.32},
    "confidence": {"plain": {"mean": 0.77, "sd": 0.15},
      "other_person_in_front": {"mean": 0.71}, "outlier": {"mean": 0.6}}
  })";
}

// `text` with `from` replaced by `to`.
std::string Changed(const std::string& from, const std::string& to) {
  std::string text = ModelText();
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string MessageOf(const std::string& text) {
  const testing::TemporaryFolder folder;
  const std::string path = folder.Write("model.json", text);
  try {
    ReadNoiseModel(path);
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("model.json"));
    return error.what();
  }
  return "no error";
}

TEST(NoiseModel, ReadsEveryFigure) {
  const testing::TemporaryFolder folder;
  const NoiseModel model =
      ReadNoiseModel(folder.Write("model.json", ModelText()));
  ASSERT_EQ(model.groups.size(), 1u);
  const NoiseModelGroup& knee = model.groups.at("knee");
  EXPECT_EQ(knee.sigma_m, 0.028);
  EXPECT_EQ(knee.hidden_sigma_m, 0.056);
  EXPECT_EQ(knee.student_dof, 4.5);
  EXPECT_EQ(knee.static_share, 0.4);
  EXPECT_EQ(knee.slow_share, 0.5);
  EXPECT_EQ(knee.slow_rho, 0.84);
  EXPECT_EQ(knee.outlier_rate, 0.04);
  EXPECT_EQ(knee.outlier_median_sigma, 5.6);
  EXPECT_EQ(knee.outlier_stays, 0.56);
  EXPECT_EQ(knee.missing_rate, 0.03);
  EXPECT_EQ(knee.hidden_missing_rate, 0.3);
  EXPECT_EQ(knee.missing_stays, 0.7);
  EXPECT_THAT(model.found_by_azimuth.at("nose"),
              ::testing::ElementsAre(0.1, 0.9, 0.2));
  EXPECT_EQ(model.missed_person.rate, 0.02);
  EXPECT_EQ(model.missed_person.mean_frames, 6.0);
  EXPECT_EQ(model.hidden_missed_rate, 0.7);
  EXPECT_EQ(model.swap_arm.rate, 0.001);
  EXPECT_EQ(model.swap_whole.rate, 0.002);
  EXPECT_EQ(model.swap_leg.mean_frames, 3.0);
  EXPECT_EQ(model.false_people, 0.24);
  EXPECT_EQ(model.fragment_rate, 0.03);
  EXPECT_EQ(model.outlier_on_other, 0.32);
  EXPECT_EQ(model.confidence, 0.77);
  EXPECT_EQ(model.confidence_sigma, 0.15);
  EXPECT_EQ(model.hidden_confidence, 0.71);
  EXPECT_EQ(model.outlier_confidence, 0.6);
}

TEST(NoiseModel, NamesFileAndKeyOfWhatIsWrong) {
  EXPECT_THAT(MessageOf(Changed("\"student_t_dof_of_core\": 4.5",
                                "\"student_t_dof_of_core\": 1.5")),
              HasSubstr("student_t_dof_of_core"));
  EXPECT_THAT(
      MessageOf(Changed("\"p_stay_missing\": 0.7", "\"p_stay_missing\": 1.7")),
      HasSubstr("p_stay_missing"));
  EXPECT_THAT(MessageOf(Changed("\"static_share\": 0.4", "\"statik\": 0.4")),
              HasSubstr("static_share"));
  EXPECT_THAT(MessageOf(Changed("{\"knee\": {\"p_m", "{\"toe\": {\"p_m")),
              HasSubstr("knee"));
  EXPECT_THAT(MessageOf(Changed("[0.1, 0.9, 0.2]", "[0.1, 9, 0.2]")),
              HasSubstr("nose"));
  EXPECT_THAT(MessageOf(Changed("[0.1, 0.9, 0.2]", "[]")), HasSubstr("nose"));
  EXPECT_THAT(MessageOf("[1, 2]"), HasSubstr("missing_joint"));
  EXPECT_THAT(MessageOf(ModelText().substr(0, 300)), HasSubstr("model.json"));
  EXPECT_THROW(ReadNoiseModel("/nowhere/model.json"), InputError);
}

TEST(NoiseModel, ReadsTheMeasuredOne) {
  KINEGRAPH_DATA_OR_SKIP(path, "campus/detections_modelled/noise_model.json");
  const NoiseModel model = ReadNoiseModel(path);
  EXPECT_EQ(model.groups.size(), 7u);
  EXPECT_EQ(model.groups.at("ankle").outlier_rate, 0.0789);
  EXPECT_EQ(model.found_by_azimuth.size(), 5u);
  EXPECT_EQ(model.found_by_azimuth.at("l_ear").size(), 12u);
  EXPECT_EQ(model.false_people, 0.2425);
}

}  // namespace
}  // namespace kinegraph
