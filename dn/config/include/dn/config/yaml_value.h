#pragma once

#include <dn/eigen_alignment.h>
#include <dn/error.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace dn {

/// Value of a YAML file that knows its file, its line and its path of keys
/// ("imu.gyro.white_deg_sqrt_h"). Every error is an InvalidConfig that names file, line, column and
/// path. A missing key and a key with the value `~` are both absent. Everything below an absent
/// value is absent too; its location is that of the nearest existing map or list above it.
class YamlValue {
 public:
  bool absent() const;
  explicit operator bool() const { return !absent(); }
  const std::string& path() const { return path_; }

  /// Throws InvalidConfig "<path>: <message>" with the location of this value.
  [[noreturn]] void Fail(const std::string& message) const;
  /// Throws InvalidConfig "<path>: expected <wanted>, found ..." with what this value is.
  [[noreturn]] void FailType(const std::string& wanted) const;
  /// Location in the file; that of the nearest existing parent if this value is absent.
  FileLocation where() const;

  /// Throws InvalidConfig unless this is a map whose keys all belong to `known` and occur once.
  void ExpectMap(const std::vector<std::string>& known) const;
  bool IsMap() const;
  bool IsScalar() const;

  /// Returns the keys of this map in file order; empty if this is not a map.
  std::vector<std::string> Keys() const;

  /// Returns this value as YAML on one line.
  std::string Yaml() const;

  /// Returns the value of a key of this map; an absent value if the key is missing.
  YamlValue operator[](const std::string& key) const;

  /// Returns the number of elements of a list or of keys of a map; 0 for any other value.
  std::size_t size() const;

  /// Returns the elements of a list; a single value counts as a list of one. Throws InvalidConfig
  /// for more than `most` elements.
  std::vector<YamlValue> Items(std::size_t most = SIZE_MAX) const;
  /// Returns the elements of a list. Throws InvalidConfig for any other value and for more than
  /// `most` elements.
  std::vector<YamlValue> List(std::size_t most = SIZE_MAX) const;

  /// The conversions below throw InvalidConfig if the value has another type or is out of range.
  /// The message gives the expected type or range and the actual value.
  std::string Text() const;
  /// Returns a text of one line with at most `longest` characters.
  std::string Line(std::size_t longest) const;
  bool Bool() const;
  double Number() const;  ///< from -1e12 to 1e12
  /// Returns an integer of at least `lowest`.
  long long Integer(long long lowest) const;
  /// Returns the value that belongs to one of several words; throws InvalidConfig with the list of
  /// words otherwise.
  template <class T>
  T Choice(const std::vector<std::pair<std::string, T>>& choices) const {
    const std::string word = Text();
    for (const auto& [name, value] : choices) {
      if (name == word) return value;
    }
    std::vector<std::string> names;
    for (const auto& choice : choices) names.push_back(choice.first);
    FailChoice(word, names);
  }

 private:
  struct Node;
  friend YamlValue ParseYaml(const std::string& text, const std::string& file);

  YamlValue(Node node, std::string path, std::string file, FileLocation parent);
  [[noreturn]] void FailChoice(const std::string& word,
                               const std::vector<std::string>& names) const;
  std::string Found() const;
  const std::string& Scalar() const;  ///< its text; empty if this is not a scalar

  std::shared_ptr<const Node> node_;
  std::string path_;
  std::string file_;
  FileLocation parent_;  ///< location of the map or list above this value
};

/// The same as YamlValue::ExpectMap, but the section may be absent.
void ExpectMapOrAbsent(const YamlValue& value, const std::vector<std::string>& known);

/// Returns a text of one line, at most 100 characters, that is safe to show in messages.
std::string ReadName(const YamlValue& value);

/// These functions convert a value as YamlValue::Number does. The message gives the expected range.
double ReadPositive(const YamlValue& value);  ///< from 1e-12 to 1e12
double ReadNotNegative(const YamlValue& value);
/// Returns a list of exactly `size` numbers.
Eigen::VectorXd ReadNumbers(const YamlValue& value, Eigen::Index size);
Eigen::Vector3d ReadVector3(const YamlValue& value);
Eigen::Vector3d ReadPositiveVector3(const YamlValue& value);
/// Returns a 3 x 3 matrix, given as a list of three rows.
Eigen::Matrix3d ReadMatrix3(const YamlValue& value);
/// Returns a list of numbers of any length; a single number counts as a list of one.
std::vector<double> ReadNumberList(const YamlValue& value);

/// These functions convert in the same way, but return `otherwise` if the value is absent.
bool ReadBoolOr(const YamlValue& value, bool otherwise);
double ReadNumberOr(const YamlValue& value, double otherwise);
double ReadPositiveOr(const YamlValue& value, double otherwise);
double ReadNotNegativeOr(const YamlValue& value, double otherwise);
Eigen::Vector3d ReadVector3Or(const YamlValue& value, const Eigen::Vector3d& otherwise);

/// Parses a YAML text and returns its top level; messages name it `file`. Throws InvalidConfig with
/// the line for a syntax error, and for an empty text.
YamlValue ParseYaml(const std::string& text, const std::string& file);

/// Returns the YAML text with `value` (also YAML) set at a path of keys such as "plan.lines".
/// Missing maps along the path are added; comments are lost. Throws InvalidConfig if either text is
/// not YAML or the path is longer than 200 characters. Also throws if a key along the path has a
/// value other than a map.
std::string WithYamlValue(const std::string& text, const std::string& path,
                          const std::string& value);

/// Applies changes "key.of.keys=value" one after the other, as WithYamlValue does. Throws
/// InvalidConfig also for a change without '=' or key; the message shows `example` as a correct
/// one.
std::string WithYamlChanges(const std::string& text, const std::vector<std::string>& changes,
                            const std::string& example);

}  // namespace dn
