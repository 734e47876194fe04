#include "solvers/graph/solve_counts.h"

namespace kinegraph {
namespace {

void Append(int64_t count, const char* what, std::string* text) {
  if (count == 0) return;
  if (!text->empty()) *text += ", ";
  *text += std::to_string(count) + " " + what;
}

}  // namespace

bool SolveCounts::AllWell() const {
  return not_converged + not_finite + bones_dropped + positions_in_doubt +
             no_covariance ==
         0;
}

SolveCounts& SolveCounts::operator+=(const SolveCounts& other) {
  for (const auto count : kSolveCounts) this->*count += other.*count;
  return *this;
}

std::string DescribeTroubles(const SolveCounts& counts,
                             const std::string& where) {
  if (counts.AllWell()) return "";
  std::string text;
  Append(counts.not_converged, "did not converge", &text);
  if (counts.not_converged > 0 && !where.empty()) text += " (" + where + ")";
  Append(counts.not_finite, "without finite solution", &text);
  Append(counts.bones_dropped, "continued without bones", &text);
  Append(counts.no_covariance, "without covariance", &text);
  Append(counts.positions_in_doubt, "joint position(s) uncertain", &text);
  text = "solves: " + std::to_string(counts.solves) + "; " + text;
  if (counts.not_converged > 0) {
    text +=
        "; a solve that did not converge reached graph.max_iterations steps or "
        "found none that lowers its cost; joints whose last step was 5 cm or "
        "more along an axis count as unseen "
        "(--set=graph.max_iterations=1000 may help)";
  }
  return text;
}

void SolveLedger::Add(const SolveCounts& counts, int64_t first_frame,
                      int64_t last_frame) {
  const std::lock_guard<std::mutex> lock(mutex_);
  total_ += counts;
  if (counts.not_converged > 0) {
    not_converged_.emplace(first_frame, last_frame);
  }
}

SolveCounts SolveLedger::Total() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return total_;
}

std::string SolveLedger::NotConverged() const {
  constexpr size_t kMost = 3;
  const std::lock_guard<std::mutex> lock(mutex_);
  std::string text;
  size_t count = 0;
  for (const auto& [first, last] : not_converged_) {
    if (++count > kMost) break;
    text += (text.empty() ? "a person in frames " : ", one in ") +
            std::to_string(first) + " to " + std::to_string(last);
  }
  if (not_converged_.size() > kMost) {
    text += ", " + std::to_string(not_converged_.size() - kMost) + " more";
  }
  return text;
}

}  // namespace kinegraph
