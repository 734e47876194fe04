// TOML configurations: reads them into options, writes effective values and
// lists keys. Defaults are defined in the options' structs, limits in their
// Describe (core/base/options.h). The only keys named here are those of
// [skeletons.NAME] and, for messages, removed ones.
#ifndef KINEGRAPH_CORE_IO_CONFIGURATION_CONFIG_H_
#define KINEGRAPH_CORE_IO_CONFIGURATION_CONFIG_H_

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/options.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// A configuration file together with the command line's changes. Errors about a
// key are InputErrors that name the key and where it is set: file and line, or
// the flag.
//
//   ConfigFile config = ConfigFile::Read(path);
//   config.Override("mode=graph;association.epsilon=9", "--set");
//   config.Apply(&options);        // for each struct of options
//   auto skeletons = config.ReadSkeletons();
//   config.RejectUnknown();        // after all keys were read
class ConfigFile {
 public:
  static ConfigFile Read(const std::string& path);
  // `path` names the text in messages.
  static ConfigFile Parse(const std::string& text, const std::string& path);
  static ConfigFile Empty();

  ConfigFile(ConfigFile&&) noexcept;
  ConfigFile& operator=(ConfigFile&&) noexcept;
  ~ConfigFile();

  // Sets keys by "key=value;key=value": dotted keys, values other than tables,
  // texts with or without quotes. Later calls override earlier ones, and all
  // override the file; `source` ("--set") replaces file and line in messages.
  // Throws InputError for an assignment without a key or "=", and for a key
  // that appears twice in one call.
  void Override(const std::string& assignments, const std::string& source);

  // Reads every key of `options` that is present, checks type and limits, and
  // marks the keys as known. An integer is accepted as a number but not vice
  // versa; NaN and infinities are rejected.
  template <typename Options>
  void Apply(Options* options) {
    const std::unique_ptr<OptionVisitor> reader = MakeReader();
    options->Describe(*reader);
  }

  // Reads the tables [skeletons.NAME] with joints = ["a", "b", ...] and bones =
  // [["a", "b"], ...], in the order of their names. Throws InputError for
  // anything invalid, such as the name of a built-in skeleton.
  std::vector<Skeleton> ReadSkeletons();

  // Throws InputError for the first key that was not read, suggesting the most
  // similar known key, or what replaces a removed key.
  void RejectUnknown() const;

  // Whether the file or an override sets this key ("cameras.unit").
  bool Has(const std::string& key) const;

  // The error with the place where its key is set, either file and line or the
  // flag of the override; with the file alone if the key is not set.
  InputError Locate(const OptionError& error) const;

 private:
  struct Impl;
  class Reader;

  explicit ConfigFile(std::unique_ptr<Impl> impl);
  std::unique_ptr<OptionVisitor> MakeReader();

  std::unique_ptr<Impl> impl_;
};

// The built-in skeleton or the user's skeleton of that name. Throws InputError
// listing the known names.
Skeleton ResolveSkeleton(const std::string& name,
                         const std::vector<Skeleton>& user_skeletons);

using DescribeOptions = std::function<void(OptionVisitor&)>;

// Effective values as JSON on one line, tables as nested objects, in the order
// of `describe`; numbers are read back to the same bits.
std::string ConfigJson(const DescribeOptions& describe);

// Effective values of several structs in one JSON object.
template <typename... Options>
std::string EffectiveConfigJson(Options... options) {
  return ConfigJson(
      [&](OptionVisitor& visitor) { (options.Describe(visitor), ...); });
}

// The documentation of a key.
struct ConfigKey {
  std::string table;  // "graph", "" for none
  std::string name;
  std::string value;  // in TOML syntax
  std::string unit;
  std::string allowed;
  std::string help;

  std::string path() const { return table.empty() ? name : table + "." + name; }
};
std::vector<ConfigKey> ListKeys(const DescribeOptions& describe);

// The keys of a struct with its current values.
template <typename Options>
std::vector<ConfigKey> KeysOf(Options options = {}) {
  return ListKeys([&](OptionVisitor& visitor) { options.Describe(visitor); });
}

// Keys with value, unit, allowed values and help as a Markdown table.
std::string KeyTable(const std::vector<ConfigKey>& keys);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CONFIGURATION_CONFIG_H_
