#include "core/io/configuration/noise_model.h"

#include <nlohmann/json.hpp>

#include "core/io/files/text_file.h"
#include "core/io/text/json.h"

namespace kinegraph {
namespace {

double NumberWithin(const JsonField& parent, const std::string& key, double low,
                    double high) {
  const JsonField field = parent.At(key);
  const double value = field.Number();
  if (value < low || value > high) {
    field.FailExpected("a number from " + std::to_string(low) + " to " +
                       std::to_string(high));
  }
  return value;
}

double Share(const JsonField& parent, const std::string& key) {
  return NumberWithin(parent, key, 0.0, 1.0);
}

double Size(const JsonField& parent, const std::string& key) {
  return NumberWithin(parent, key, 0.0, 1e6);
}

NoiseModelGroup ReadGroup(const JsonField& noise, const JsonField& missing) {
  NoiseModelGroup group;
  group.sigma_m = Size(noise, "sigma_m_per_axis");
  group.hidden_sigma_m = Size(noise, "sigma_if_other_person_in_front");
  group.student_dof = NumberWithin(noise, "student_t_dof_of_core", 2.01, 1e6);
  group.static_share = Share(noise, "static_share");
  group.slow_share = Share(noise, "slow_share");
  group.slow_rho = Share(noise, "slow_rho_per_frame");
  group.outlier_rate = Share(noise, "p_outlier_over_4_sigma");
  group.outlier_median_sigma =
      NumberWithin(noise, "outlier_median_in_sigma", 4.0, 1e3);
  group.outlier_stays = Share(noise, "p_outlier_stays");
  group.missing_rate = Share(missing, "p_missing_if_not");
  group.hidden_missing_rate =
      Share(missing, "p_missing_if_other_person_in_front");
  group.missing_stays = Share(missing, "p_stay_missing");
  return group;
}

NoiseModelEvent ReadSwap(const JsonField& swaps, const std::string& key) {
  const JsonField swap = swaps.At(key);
  return {Share(swap, "p"), Size(swap, "run_length_mean")};
}

// The entry "bins" explains the others.
std::map<std::string, std::vector<double>> ReadAzimuths(
    const JsonField& table) {
  std::map<std::string, std::vector<double>> found;
  for (const auto& [joint, field] : table.Members("joint")) {
    if (joint == "bins") continue;
    const std::vector<double> shares = field.Numbers();
    if (shares.empty()) field.FailExpected("at least one share");
    for (const double share : shares) {
      if (share < 0.0 || share > 1.0) field.FailExpected("shares from 0 to 1");
    }
    found[joint] = shares;
  }
  return found;
}

}  // namespace

NoiseModel ReadNoiseModel(const std::string& path) {
  const Json json = ParseJson(ReadTextFile(path, kMaxSmallFileBytes), path);
  const JsonField root(json, path);
  NoiseModel model;
  const JsonField missing = root.At("missing_joint");
  for (const auto& [name, noise] : root.At("noise").Members("group")) {
    model.groups[name] = ReadGroup(noise, missing.At(name));
  }
  model.found_by_azimuth =
      ReadAzimuths(root.At("face_found_by_camera_azimuth"));
  const JsonField missed = root.At("missed_person");
  model.missed_person = {Share(missed, "p_missed_if_not"),
                         Size(missed, "run_length_mean")};
  model.hidden_missed_rate = Share(missed, "p_missed_if_mostly_hidden");
  const JsonField swaps = root.At("left_right_swap");
  model.swap_whole = ReadSwap(swaps, "whole");
  model.swap_arm = ReadSwap(swaps, "arm");
  model.swap_leg = ReadSwap(swaps, "leg");
  model.false_people = Size(root.At("false_positive_person"), "mean_per_image");
  model.fragment_rate = Share(root.At("fragment"), "mean_per_person_view");
  model.outlier_on_other =
      Share(root.At("outlier_on_other_persons_same_joint"), "share");
  const JsonField confidence = root.At("confidence");
  model.confidence = Share(confidence.At("plain"), "mean");
  model.confidence_sigma = Share(confidence.At("plain"), "sd");
  model.hidden_confidence =
      Share(confidence.At("other_person_in_front"), "mean");
  model.outlier_confidence = Share(confidence.At("outlier"), "mean");
  return model;
}

}  // namespace kinegraph
