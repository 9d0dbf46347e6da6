#include "scenario_section.h"

#include <dn/error.h>
#include <dn/geo/text_table.h>
#include <dn/names.h>

#include <cmath>
#include <utility>

namespace dn {
namespace {

FileLocation Where(const std::string& file, const YAML::Node& node) {
  const YAML::Mark mark = node.Mark();
  if (mark.is_null()) return {file};
  return {file, mark.line + 1, mark.column + 1};
}

}  // namespace

ScenarioSection::ScenarioSection(const YAML::Node& node, std::string path, std::string file,
                                 const std::vector<std::string>& known)
    : node_(node), path_(std::move(path)), file_(std::move(file)) {
  if (!node_ || node_.IsNull()) return;
  if (!node_.IsMap()) {
    throw InvalidConfig(
        (path_.empty() ? "a scenario" : path_) + " must be a map of keys and values",
        Where(file_, node_));
  }
  for (const auto& entry : node_) {
    const std::string key = entry.first.as<std::string>("");
    bool found = false;
    for (const std::string& name : known) found = found || name == key;
    if (!found) {
      throw InvalidConfig("unknown key '" + PathTo(key) + "'; the nearest known one is '" +
                              PathTo(NearestName(key, known)) + "'",
                          Where(file_, entry.first));
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
  const YAML::Node node = At(key);
  const bool at_key = node.IsDefined();
  FileLocation where{file_};
  if (at_key) {
    where = Where(file_, node);
  } else if (node_.IsDefined() && !node_.IsNull()) {
    where = Where(file_, node_);
  }
  throw InvalidConfig(PathTo(key) + ": " + what, where);
}

ScenarioSection ScenarioSection::Sub(const std::string& key,
                                     const std::vector<std::string>& known) const {
  return {At(key), PathTo(key), file_, known};
}

std::vector<ScenarioSection> ScenarioSection::List(const std::string& key,
                                                   const std::vector<std::string>& known) const {
  std::vector<ScenarioSection> sections;
  if (!Has(key)) return sections;
  const YAML::Node list = At(key);
  if (!list.IsSequence()) Fail(key, "must be a list");
  for (std::size_t i = 0; i < list.size(); ++i) {
    sections.push_back({list[i], PathTo(key) + "[" + std::to_string(i) + "]", file_, known});
  }
  return sections;
}

double ScenarioSection::ToNumber(const YAML::Node& node, const std::string& key) const {
  double value = 0.0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value)) {
    Fail(key, "must be a finite number");
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
  return node.Scalar();
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
