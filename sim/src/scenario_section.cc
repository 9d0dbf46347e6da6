#include "scenario_section.h"

#include <dn/error.h>
#include <dn/geo/text_table.h>
#include <dn/names.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace dn {
namespace {

/// No quantity of a scenario, in the units of its keys, is beyond these; squares and inverses of
/// what lies within stay numbers.
constexpr double kLargest = 1e12;
constexpr double kSmallestPositive = 1e-12;

constexpr std::size_t kLongestText = 1000;

/// Where a node stands; that of its parent for one that is not there.
FileLocation Where(const YAML::Node& node, const FileLocation& parent) {
  if (!node.IsDefined() || node.Mark().is_null()) return parent;
  return {parent.file, node.Mark().line + 1, node.Mark().column + 1};
}

}  // namespace

ScenarioSection::ScenarioSection(const YAML::Node& node, std::string path,
                                 const FileLocation& parent, const std::vector<std::string>& known)
    : node_(node), path_(std::move(path)), where_(Where(node, parent)) {
  if (!node_ || node_.IsNull()) return;
  if (!node_.IsMap()) {
    throw InvalidConfig(
        (path_.empty() ? "a scenario" : path_) + " must be a map of keys and values", where_);
  }
  for (const auto& entry : node_) {
    const std::string key = entry.first.as<std::string>("");
    bool found = false;
    for (const std::string& name : known) found = found || name == key;
    if (!found) {
      throw InvalidConfig("unknown key '" + PathTo(key) + "'; the nearest known one is '" +
                              PathTo(NearestName(key, known)) + "'",
                          Where(entry.first, where_));
    }
  }
}

std::string ScenarioSection::PathTo(const std::string& key) const {
  return path_.empty() ? key : path_ + "." + key;
}

YAML::Node ScenarioSection::At(const std::string& key) const {
  if (!node_ || !node_.IsMap()) return YAML::Node(YAML::NodeType::Undefined);
  const YAML::Node& map = node_;  // looking up in a const node adds nothing
  return map[key];
}

bool ScenarioSection::Has(const std::string& key) const {
  const YAML::Node node = At(key);
  return node.IsDefined() && !node.IsNull();
}

void ScenarioSection::Fail(const std::string& key, const std::string& what) const {
  throw InvalidConfig(PathTo(key) + ": " + what, PlaceOf(key));
}

FileLocation ScenarioSection::PlaceOf(const std::string& key) const {
  return Where(At(key), where_);
}

ScenarioSection ScenarioSection::Sub(const std::string& key,
                                     const std::vector<std::string>& known) const {
  return {At(key), PathTo(key), where_, known};
}

std::vector<ScenarioSection> ScenarioSection::List(const std::string& key,
                                                   const std::vector<std::string>& known) const {
  std::vector<ScenarioSection> sections;
  if (!Has(key)) return sections;
  const YAML::Node list = At(key);
  if (!list.IsSequence()) Fail(key, "must be a list");
  for (std::size_t i = 0; i < list.size(); ++i) {
    sections.push_back(
        {list[i], PathTo(key) + "[" + std::to_string(i) + "]", Where(list, where_), known});
  }
  return sections;
}

double ScenarioSection::ToNumber(const YAML::Node& node, const std::string& key) const {
  double value = 0.0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value)) {
    Fail(key, "must be a finite number");
  }
  if (std::abs(value) > kLargest) {
    Fail(key, "must be within -1e12 and 1e12, got " + FormatDouble(value));
  }
  return value;
}

double ScenarioSection::Number(const std::string& key) const {
  if (!Has(key)) Fail(key, "is required");
  return ToNumber(At(key), key);
}

double ScenarioSection::Number(const std::string& key, double fallback) const {
  return Has(key) ? Number(key) : fallback;
}

double ScenarioSection::Positive(const std::string& key) const {
  const double value = Number(key);
  if (!(value > 0.0)) Fail(key, "must be positive, got " + FormatDouble(value));
  if (value < kSmallestPositive) Fail(key, "must be at least 1e-12, got " + FormatDouble(value));
  return value;
}

double ScenarioSection::Positive(const std::string& key, double fallback) const {
  return Has(key) ? Positive(key) : fallback;
}

double ScenarioSection::NotNegative(const std::string& key, double fallback) const {
  const double value = Number(key, fallback);
  if (!(value >= 0.0)) Fail(key, "must not be negative, got " + FormatDouble(value));
  return value;
}

long ScenarioSection::Count(const std::string& key, long fallback) const {
  if (!Has(key)) return fallback;
  constexpr double kMost = 1e9;
  const double value = Number(key);
  if (value < 0.0 || value > kMost || value != std::floor(value)) {
    Fail(key, "must be a whole number from 0 to 1e9, got " + FormatDouble(value));
  }
  return static_cast<long>(value);
}

bool ScenarioSection::Flag(const std::string& key, bool fallback) const {
  if (!Has(key)) return fallback;
  bool value = false;
  const YAML::Node node = At(key);
  if (!node.IsScalar() || !YAML::convert<bool>::decode(node, value)) {
    Fail(key, "must be true or false");
  }
  return value;
}

std::string ScenarioSection::Text(const std::string& key) const {
  if (!Has(key)) Fail(key, "is required");
  const YAML::Node node = At(key);
  if (!node.IsScalar() || node.Scalar().empty()) Fail(key, "must be a text");
  const std::string& text = node.Scalar();
  if (HasControls(text)) Fail(key, "holds a line break or another control character");
  if (text.size() > kLongestText) Fail(key, "must be one line of up to 1000 characters");
  return text;
}

std::vector<double> ScenarioSection::Numbers(const std::string& key) const {
  if (!Has(key)) Fail(key, "is required");
  const YAML::Node list = At(key);
  if (!list.IsSequence()) return {ToNumber(list, key)};
  std::vector<double> values;
  for (const auto& item : list) values.push_back(ToNumber(item, key));
  return values;
}

Eigen::Vector3d ScenarioSection::Vector(const std::string& key) const {
  const std::vector<double> values = Numbers(key);
  if (values.size() != 3) Fail(key, "must be a list of 3 numbers");
  return {values[0], values[1], values[2]};
}

Eigen::Vector3d ScenarioSection::Vector(const std::string& key,
                                        const Eigen::Vector3d& fallback) const {
  return Has(key) ? Vector(key) : fallback;
}

std::vector<std::vector<double>> ScenarioSection::Rows(const std::string& key,
                                                       std::size_t columns) const {
  std::vector<std::vector<double>> rows;
  if (!Has(key)) return rows;
  const YAML::Node list = At(key);
  if (!list.IsSequence()) Fail(key, "must be a list of lists");
  for (const auto& item : list) {
    if (!item.IsSequence() || item.size() != columns) {
      Fail(key, "every entry must be a list of " + std::to_string(columns) + " numbers");
    }
    rows.emplace_back();
    for (const auto& number : item) rows.back().push_back(ToNumber(number, key));
  }
  return rows;
}

}  // namespace dn
