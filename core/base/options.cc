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

// Compares every field with its limits.
class OptionChecker : public OptionVisitor {
 public:
  void Enter(const std::string& name) override { tables_.push_back(name); }
  void Leave() override { tables_.pop_back(); }
  void Number(const std::string& key, double* value, const Limits& limits,
              const std::string&, const std::string&) override {
    Check(key, *value, limits);
  }
  void Integer(const std::string& key, int64_t* value, const Limits& limits,
               const std::string&, const std::string&) override {
    Check(key, static_cast<double>(*value), limits);
  }
  void Boolean(const std::string&, bool*, const std::string&) override {}
  void Text(const std::string&, std::string*, const std::string&) override {}
  void TextList(const std::string&, std::vector<std::string>*,
                const std::string&) override {}
  void NumberList(const std::string& key, std::vector<double>* value,
                  const Limits& limits, const std::string&,
                  const std::string&) override {
    for (const double number : *value) Check(key, number, limits);
  }
  void NumberTable(const std::string& key, double* values,
                   const std::vector<std::string>& names, const Limits& limits,
                   const std::string&, const std::string&) override {
    Enter(key);
    for (const std::string& name : names) Check(name, *values++, limits);
    Leave();
  }
  void TextMap(const std::string&, std::map<std::string, std::string>*,
               const std::string&) override {}
  void ChoiceIndex(const std::string& key, int* value,
                   const std::vector<std::string>& names,
                   const std::string&) override {
    Check(key, *value, Between(0.0, static_cast<double>(names.size()) - 1));
  }

 private:
  void Check(const std::string& key, double value, const Limits& limits) const {
    if (limits.Contains(value)) return;
    throw OptionError(
        JoinKey(tables_, key),
        "found " + Short(value) + ", allowed " + limits.ToString());
  }

  std::vector<std::string> tables_;
};

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

void CheckDescribed(const std::function<void(OptionVisitor&)>& describe) {
  OptionChecker checker;
  describe(checker);
}

}  // namespace kinegraph
