#include "apps/compare/cutoffs.h"

#include <fmt/format.h>

#include <map>
#include <utility>

#include "apps/common/table.h"
#include "core/base/parallel.h"
#include "core/evaluation/statistics.h"
#include "solvers/filters/classical.h"
#include "solvers/filters/cutoff.h"

namespace kinegraph {
namespace {

// Positions of a joint in the longest interval of consecutive frames, and in
// the current one.
struct LongestPiece {
  std::vector<Eigen::Vector3d> longest, current;
  int64_t last_frame = 0;

  void Add(int64_t frame, const Eigen::Vector3d& position_m) {
    if (frame != last_frame + 1) End();
    current.push_back(position_m);
    last_frame = frame;
  }
  // Ends the current interval. Must also be called after the last frame.
  void End() {
    if (current.size() > longest.size()) std::swap(longest, current);
    current.clear();
  }
};

}  // namespace

std::vector<ChosenCutoff> ChooseCutoffs(const CompareResult& result) {
  const Comparison& comparison = result.comparison;
  std::map<std::pair<TrackId, int>, LongestPiece> pieces;
  for (const TrackFrame& frame : result.points.frames) {
    for (const PersonPose& person : frame.people) {
      for (size_t j = 0; j < person.joints.size(); ++j) {
        if (!person.joints[j].present()) continue;
        pieces[{person.id, static_cast<int>(j)}].Add(
            frame.frame, person.joints[j].position_m);
      }
    }
  }
  for (auto& [key, piece] : pieces) piece.End();
  ButterworthOptions options =
      comparison.options.estimators.filters.butterworth;
  options.on = FilterSignal::kPosition;
  const LowPass low_pass = ZeroPhaseButterworth(options, comparison.rate_hz());
  std::vector<ChosenCutoff> chosen;
  std::vector<const std::vector<Eigen::Vector3d>*> points;
  for (const auto& [key, piece] : pieces) {
    // The rules need at least one second of data.
    if (static_cast<double>(piece.longest.size()) < comparison.rate_hz()) {
      continue;
    }
    for (int rule = 0; rule < static_cast<int>(CutoffRules().size()); ++rule) {
      chosen.push_back({key.first, key.second, rule, {}});
      points.push_back(&piece.longest);
    }
  }
  ParallelFor(comparison.threads, static_cast<int>(chosen.size()), [&](int i) {
    ChosenCutoff& one = chosen[static_cast<size_t>(i)];
    const auto& positions_m = *points[static_cast<size_t>(i)];
    Samples values(static_cast<Eigen::Index>(positions_m.size()), 3);
    for (size_t k = 0; k < positions_m.size(); ++k) {
      values.row(static_cast<Eigen::Index>(k)) = positions_m[k].transpose();
    }
    const CutoffChoice rule = CutoffRules()[one.rule_idx].second;
    one.cutoffs_hz = ChooseCutoffs(rule, CutoffPer::kAxis, low_pass, values);
    one.cutoffs_hz.push_back(ChooseCutoff(rule, low_pass, values));
  });
  return chosen;
}

std::string CutoffsCsv(const CompareResult& result,
                       const std::vector<ChosenCutoff>& chosen) {
  const std::vector<std::string> axes = {"x", "y", "z", "all"};
  Table table({"person", "joint", "axis", "rule", "cutoff_hz"});
  const Skeleton& skeleton = result.comparison.scene().skeleton;
  for (const ChosenCutoff& one : chosen) {
    for (size_t axis = 0; axis < axes.size(); ++axis) {
      table.AddRow({std::to_string(one.person.value()),
                    skeleton.joints()[one.joint_idx], axes[axis],
                    CutoffRules()[one.rule_idx].first,
                    fmt::format("{:.6g}", one.cutoffs_hz[axis])});
    }
  }
  return table.ToString(TableStyle::kCsv);
}

std::string CutoffsTable(const CompareResult& result,
                         const std::vector<ChosenCutoff>& chosen) {
  const auto name = [](const auto& rule) { return rule.first; };
  Table table(RowOf("joint", CellsOf(CutoffRules(), name)));
  const Skeleton& skeleton = result.comparison.scene().skeleton;
  for (size_t j = 0; j < skeleton.joints().size(); ++j) {
    Cells cells = {skeleton.joints()[j]};
    for (size_t rule = 0; rule < CutoffRules().size(); ++rule) {
      Cells medians;
      for (size_t axis = 0; axis < 3; ++axis) {
        std::vector<double> of_people_hz;
        for (const ChosenCutoff& one : chosen) {
          if (one.joint_idx != static_cast<int>(j) ||
              one.rule_idx != static_cast<int>(rule)) {
            continue;
          }
          of_people_hz.push_back(one.cutoffs_hz[axis]);
        }
        medians.push_back(Fixed(Quantile(std::move(of_people_hz), 0.5), 1));
      }
      cells.push_back(fmt::format("{}", fmt::join(medians, " / ")));
    }
    if (cells[1] != "- / - / -") table.AddRow(std::move(cells));
  }
  return table.ToString(TableStyle::kMarkdown);
}

}  // namespace kinegraph
