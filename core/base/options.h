// Declaration of the keys, units and limits of options structs.
//
// An options struct is plain: a default and a unit beside each field. Its `void
// Describe(OptionVisitor&)` names every field once. Visitors then read a TOML
// file into it, write its effective values into a result, list the keys for the
// documentation, or check it. Defaults are therefore defined only in the
// struct, keys and limits only in Describe.
#ifndef KINEGRAPH_CORE_BASE_OPTIONS_H_
#define KINEGRAPH_CORE_BASE_OPTIONS_H_

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace kinegraph {

// Closed range of a number; `above` excludes the lower end.
struct Limits {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool above = false;

  bool Contains(double value) const;  // false for NaN
  std::string ToString() const;       // "> 0", "0 .. 1"
};

inline Limits Positive() {
  return {0.0, std::numeric_limits<double>::max(), true};
}
inline Limits NonNegative() {
  return {0.0, std::numeric_limits<double>::max(), false};
}
inline Limits Between(double low, double high) { return {low, high, false}; }

class OptionVisitor {
 public:
  virtual ~OptionVisitor() = default;

  // Keys between Enter and Leave belong to the table `name`; tables nest.
  virtual void Enter(const std::string& name) = 0;
  virtual void Leave() = 0;

  // `unit` is empty for pure numbers; `help` is one short sentence.
  virtual void Number(const std::string& key, double* value,
                      const Limits& limits, const std::string& unit,
                      const std::string& help) = 0;
  virtual void Integer(const std::string& key, int64_t* value,
                       const Limits& limits, const std::string& unit,
                       const std::string& help) = 0;
  virtual void Boolean(const std::string& key, bool* value,
                       const std::string& help) = 0;
  virtual void Text(const std::string& key, std::string* value,
                    const std::string& help) = 0;
  virtual void TextList(const std::string& key, std::vector<std::string>* value,
                        const std::string& help) = 0;
  virtual void NumberList(const std::string& key, std::vector<double>* value,
                          const Limits& limits, const std::string& unit,
                          const std::string& help) = 0;
  // `values` has one number for each of `names`. A configuration gives one
  // number for all (key = 6) or a table with some names (key.wrist = 9).
  virtual void NumberTable(const std::string& key, double* values,
                           const std::vector<std::string>& names,
                           const Limits& limits, const std::string& unit,
                           const std::string& help) = 0;
  // A table of texts, such as [cameras.map].
  virtual void TextMap(const std::string& key,
                       std::map<std::string, std::string>* value,
                       const std::string& help) = 0;
  // `value` is an index into `names`.
  virtual void ChoiceIndex(const std::string& key, int* value,
                           const std::vector<std::string>& names,
                           const std::string& help) = 0;

  // An enum whose values are 0, 1, 2, ... in the order of `names`.
  template <typename Enum>
  void Choice(const std::string& key, Enum* value,
              const std::vector<std::string>& names, const std::string& help) {
    int index = static_cast<int>(*value);
    ChoiceIndex(key, &index, names, help);
    *value = static_cast<Enum>(index);
  }
  // The keys of an options struct, as a table.
  template <typename Options>
  void Table(const std::string& name, Options* options) {
    Enter(name);
    options->Describe(*this);
    Leave();
  }
};

// Throws OptionError naming key, value and allowed range when a field that
// `describe` passes to the visitor is outside its limits.
void CheckDescribed(const std::function<void(OptionVisitor&)>& describe);

// The same for an options struct that was filled in code.
template <typename Options>
void CheckOptions(Options options) {
  CheckDescribed([&](OptionVisitor& visitor) { options.Describe(visitor); });
}

// "a.b.key" of a key inside nested tables.
std::string JoinKey(const std::vector<std::string>& tables,
                    const std::string& key);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_OPTIONS_H_
