#include "core/base/options.h"

#include <cmath>
#include <cstdio>

#include "core/base/error.h"

namespace kinegraph {
namespace {

std::string Short(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g", value);
  return text;
}

void Check(const std::string& key, double value, const Limits& limits) {
  if (!limits.Contains(value)) {
    throw OptionError(
        key, "found " + Short(value) + ", allowed " + limits.ToString());
  }
}

}  // namespace

bool Limits::Contains(double value) const {
  if (std::isnan(value)) return false;
  return (above ? value > low : value >= low) && value <= high;
}

std::string Limits::ToString() const {
  const bool bounded_below = std::isfinite(low);
  const bool bounded_above =
      std::isfinite(high) && high < std::numeric_limits<double>::max();
  if (bounded_below && bounded_above) {
    return above ? "> " + Short(low) + ", <= " + Short(high)
                 : Short(low) + " .. " + Short(high);
  }
  if (bounded_below) return (above ? "> " : ">= ") + Short(low);
  if (bounded_above) return "<= " + Short(high);
  return "any number";
}

std::string JoinKey(const std::vector<std::string>& tables,
                    const std::string& key) {
  std::string path;
  for (const std::string& table : tables) path += table + ".";
  return path + key;
}

std::string OptionChecker::Path(const std::string& key) const {
  return JoinKey(tables_, key);
}

void OptionChecker::Enter(const std::string& name) { tables_.push_back(name); }

void OptionChecker::Leave() { tables_.pop_back(); }

void OptionChecker::Number(const std::string& key, double* value,
                           const Limits& limits, const std::string&,
                           const std::string&) {
  Check(Path(key), *value, limits);
}

void OptionChecker::Integer(const std::string& key, int64_t* value,
                            const Limits& limits, const std::string&,
                            const std::string&) {
  Check(Path(key), static_cast<double>(*value), limits);
}

void OptionChecker::NumberList(const std::string& key,
                               std::vector<double>* value, const Limits& limits,
                               const std::string&, const std::string&) {
  for (const double number : *value) Check(Path(key), number, limits);
}

void OptionChecker::NumberTable(const std::string& key, double* values,
                                const std::vector<std::string>& names,
                                const Limits& limits, const std::string& unit,
                                const std::string& help) {
  Enter(key);
  for (const std::string& name : names) {
    Number(name, values++, limits, unit, help);
  }
  Leave();
}

void OptionChecker::ChoiceIndex(const std::string& key, int* value,
                                const std::vector<std::string>& names,
                                const std::string&) {
  Check(Path(key), *value, Between(0.0, static_cast<double>(names.size()) - 1));
}

}  // namespace kinegraph
