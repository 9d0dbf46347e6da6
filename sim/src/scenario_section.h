#pragma once

#include <dn/error.h>
#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// One map of a scenario file, read strictly: every fault is an InvalidConfig that names the key
/// and where it stands.
class ScenarioSection {
 public:
  /// `path` is the key as the user sees it ("plan.turbulence"), `parent` where the map or list that
  /// should hold it stands. Throws when node is no map or holds a key that is not among `known`.
  ScenarioSection(const YAML::Node& node, std::string path, const FileLocation& parent,
                  const std::vector<std::string>& known);

  /// Present and not null.
  bool Has(const std::string& key) const;

  /// A map below this one; an absent one is empty.
  ScenarioSection Sub(const std::string& key, const std::vector<std::string>& known) const;
  /// The maps of a list; empty when absent.
  std::vector<ScenarioSection> List(const std::string& key,
                                    const std::vector<std::string>& known) const;

  double Number(const std::string& key) const;  ///< required, finite
  double Number(const std::string& key, double fallback) const;
  double Positive(const std::string& key) const;
  double Positive(const std::string& key, double fallback) const;
  double NotNegative(const std::string& key, double fallback) const;
  long Count(const std::string& key, long fallback) const;  ///< a whole number >= 0
  bool Flag(const std::string& key, bool fallback) const;
  std::string Text(const std::string& key) const;
  std::vector<double> Numbers(const std::string& key) const;  ///< a list, or one number
  Eigen::Vector3d Vector(const std::string& key) const;
  Eigen::Vector3d Vector(const std::string& key, const Eigen::Vector3d& fallback) const;
  /// A list of lists of `columns` numbers.
  std::vector<std::vector<double>> Rows(const std::string& key, std::size_t columns) const;

  /// Where a key's value stands, or this map where the key is missing.
  FileLocation PlaceOf(const std::string& key) const;
  /// Where this map stands, or its parent where it is missing.
  const FileLocation& where() const { return where_; }

  /// An InvalidConfig about a key: "<path>.<key>: <what>", at its place, or that of the map where
  /// it is missing.
  [[noreturn]] void Fail(const std::string& key, const std::string& what) const;

 private:
  YAML::Node At(const std::string& key) const;
  std::string PathTo(const std::string& key) const;
  double ToNumber(const YAML::Node& node, const std::string& key) const;

  YAML::Node node_;
  std::string path_;
  FileLocation where_;
};

}  // namespace dn
