#include "core/io/tracks/force_plates.h"

#include "core/base/error.h"
#include "core/io/text/bulk_json.h"
#include "core/io/tracks/c3d_file.h"
#include "core/io/tracks/read_c3d.h"

namespace kinegraph {
namespace {

constexpr const char* kGroup = "FORCE_PLATFORM:";

double NumberOr(const C3dValues& values, const std::string& name, size_t index,
                double otherwise) {
  return values.Number(name, index).value_or(otherwise);
}

// Weights of the plate's channels whose sum is the load across it.
std::vector<double> LoadWeights(const C3dValues& values, size_t plate) {
  const std::string group = kGroup;
  switch (static_cast<int>(NumberOr(values, group + "TYPE", plate, 0.0))) {
    case 1:
    case 2:
      return {0.0, 0.0, 1.0, 0.0, 0.0, 0.0};
    case 3:  // four corners
      return {0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0};
    case 4: {  // by columns: the row of the third force
      std::vector<double> weights;
      for (size_t c = 0; c < 6; ++c) {
        weights.push_back(NumberOr(values, group + "CAL_MATRIX",
                                   36 * plate + 6 * c + 2, c == 2 ? 1.0 : 0.0));
      }
      return weights;
    }
    default:
      return {};
  }
}

ForcePlate ReadPlate(const C3dFile& file, size_t plate, size_t row_length,
                     const std::vector<double>& weights) {
  const C3dValues& values = file.values();
  const std::string group = kGroup;
  ForcePlate result;
  for (size_t corner = 0; corner < 4; ++corner) {
    for (size_t axis = 0; axis < 3; ++axis) {
      result.centre_m[static_cast<Eigen::Index>(axis)] +=
          0.25 * file.unit_m() *
          NumberOr(values, group + "CORNERS", 12 * plate + 3 * corner + axis,
                   0.0);
    }
  }
  result.centre_m = C3dAxes().Invert(result.centre_m);
  const C3dAnalog& analog = file.analog();
  std::vector<size_t> channels;
  for (size_t c = 0; c < weights.size(); ++c) {
    const double channel =
        NumberOr(values, group + "CHANNEL", row_length * plate + c, 0.0);
    if (!(channel >= 1.0 && channel <= static_cast<double>(analog.channels))) {
      throw InputError(group + "CHANNEL: plate " + std::to_string(plate + 1) +
                       " has no channel " + std::to_string(c + 1) +
                       " among the " + std::to_string(analog.channels) +
                       " analog ones");
    }
    channels.push_back(static_cast<size_t>(channel) - 1);
  }
  const C3dFrames& points = file.points();
  result.rate_hz = points.rate_hz * static_cast<double>(analog.per_frame);
  result.first_s = static_cast<double>(points.first) / points.rate_hz;
  double mean = 0.0;
  for (int64_t frame = 0; frame < points.count; ++frame) {
    for (size_t sample = 0; sample < analog.per_frame; ++sample) {
      double load_n = 0.0;
      for (size_t c = 0; c < channels.size(); ++c) {
        if (weights[c] == 0.0) continue;
        load_n += weights[c] * file.Analog(frame, sample, channels[c]);
      }
      result.load_n.push_back(load_n);
      mean += load_n;
    }
  }
  // Its own axes point up or down, and force or reaction is meant.
  if (mean < 0.0) {
    for (double& load_n : result.load_n) load_n = -load_n;
  }
  return result;
}

}  // namespace

std::vector<ForcePlate> ReadForcePlates(const std::string& path) {
  return Located(path, [&] {
    const C3dFile file(path);
    const double used =
        NumberOr(file.values(), std::string(kGroup) + "USED", 0, 0.0);
    std::vector<std::vector<double>> weights;
    for (size_t plate = 0; static_cast<double>(plate) < used; ++plate) {
      weights.push_back(LoadWeights(file.values(), plate));
    }
    // As long as the longest plate's, of this file or of what wrote it.
    const size_t row_length =
        file.values().RowLength(std::string(kGroup) + "CHANNEL");
    std::vector<ForcePlate> plates;
    for (size_t plate = 0; plate < weights.size(); ++plate) {
      if (weights[plate].empty()) continue;
      plates.push_back(ReadPlate(file, plate, row_length, weights[plate]));
    }
    if (plates.empty() || file.analog().per_frame == 0) {
      throw InputError("has no force plates of types 1 to 4 with samples");
    }
    return plates;
  });
}

}  // namespace kinegraph
