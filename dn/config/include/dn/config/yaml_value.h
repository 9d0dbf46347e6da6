#pragma once

#include <dn/error.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace dn {

/// A value of a YAML file that knows its path of keys ("imu.gyro.white_deg_sqrt_h") and its file,
/// so that every complaint, an InvalidConfig, names both, line and column. A key that is missing
/// and one that is `~` are both absent; whatever stands below something absent is absent, too, and
/// has the place of the nearest map or list that is there.
class YamlValue {
 public:
  bool absent() const;
  explicit operator bool() const { return !absent(); }
  const std::string& path() const { return path_; }

  /// Throws InvalidConfig "<path>: <message>" at this value's place.
  [[noreturn]] void Fail(const std::string& message) const;
  FileLocation where() const;

  /// Throws unless this is a map with keys of `known`, none twice.
  void ExpectMap(const std::vector<std::string>& known) const;
  /// The same for a section that may be left out.
  void ExpectMapOrNothing(const std::vector<std::string>& known) const;
  bool IsMap() const;
  bool IsScalar() const;

  /// The keys of this map, in the order of the file; none where this is no map.
  std::vector<std::string> Keys() const;

  /// This value as YAML on one line.
  std::string Yaml() const;

  /// Value under a key of this map; absent when there is none.
  YamlValue operator[](const std::string& key) const;

  /// Number of elements of a list or keys of a map; 0 of anything else.
  std::size_t size() const;

  /// Elements of a list; a single value that is no list counts as a list of one. Throws where there
  /// are more than `most`.
  std::vector<YamlValue> Items(std::size_t most = SIZE_MAX) const;
  /// Elements of a list; anything else is an error, as are more than `most`.
  std::vector<YamlValue> List(std::size_t most = SIZE_MAX) const;

  /// Conversions; each throws naming the wanted type or range and what was found.
  std::string Text() const;
  std::string Name() const;  ///< a text that messages can show
  /// One line of at most so many characters.
  std::string Line(std::size_t longest) const;
  bool Bool() const;
  double Number() const;    ///< within -1e12 and 1e12
  double Positive() const;  ///< from 1e-12 on
  double NotNegative() const;
  long long Integer(long long lowest) const;
  Eigen::VectorXd Numbers(Eigen::Index size) const;
  Eigen::Vector3d Vector3() const { return Numbers(3); }
  Eigen::Vector3d PositiveVector3() const;
  Eigen::Matrix3d Matrix3() const;
  /// A list of numbers of any length, or one number.
  std::vector<double> NumberList() const;

  /// The same, or `otherwise` where this is absent.
  bool BoolOr(bool otherwise) const { return absent() ? otherwise : Bool(); }
  double NumberOr(double otherwise) const { return absent() ? otherwise : Number(); }
  double PositiveOr(double otherwise) const { return absent() ? otherwise : Positive(); }
  double NotNegativeOr(double otherwise) const { return absent() ? otherwise : NotNegative(); }
  Eigen::Vector3d Vector3Or(const Eigen::Vector3d& otherwise) const {
    return absent() ? otherwise : Vector3();
  }

  /// One of several words; throws listing them.
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
  [[noreturn]] void FailType(const std::string& wanted) const;
  [[noreturn]] void FailChoice(const std::string& word,
                               const std::vector<std::string>& names) const;
  std::string Found() const;
  const std::string& Scalar() const;  ///< its text; empty for what is no scalar

  std::shared_ptr<const Node> node_;
  std::string path_;
  std::string file_;
  FileLocation parent_;  ///< where the map or list that should hold this stands
};

/// The top level of a YAML text; `file` is what messages name. Throws InvalidConfig at the line of
/// a syntax error, or when it is empty.
YamlValue ParseYaml(const std::string& text, const std::string& file);

/// The YAML text with another value (YAML, too) under a path of keys such as "plan.lines"; maps that
/// are not there on the way are added, comments are lost. Throws InvalidConfig for what is not YAML,
/// for a path longer than 200 characters, and where a key on the way holds something else than a
/// map.
std::string WithYamlValue(const std::string& text, const std::string& path,
                          const std::string& value);

/// The same for changes "key.of.keys=value", one after the other. Throws InvalidConfig also for what
/// is none; `example` is what its message shows.
std::string WithYamlChanges(const std::string& text, const std::vector<std::string>& changes,
                            const std::string& example);

}  // namespace dn
