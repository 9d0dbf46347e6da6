#include <dn/config/yaml_value.h>
#include <dn/error.h>
#include <dn/names.h>
#include <dn/study/sweep.h>
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "base_scenario.h"

namespace dn {
namespace {

constexpr std::uint64_t kMostDesigns = 10000;
const char* const kEstimate = "estimate";

std::vector<SweepValue> ReadValues(const YamlValue& values) {
  std::vector<SweepValue> read;
  if (values.IsMap()) {
    for (const std::string& name : values.Keys()) read.push_back({name, values[name].Yaml()});
  } else {
    for (const YamlValue& value : values.List()) read.push_back({value.Yaml(), value.Yaml()});
  }
  return read;
}

SweepKey ReadKey(const YamlValue& values, const std::string& path) {
  SweepKey key{path, ReadValues(values)};
  if (key.values.empty()) values.Fail("has no values");
  std::set<std::string> labels;
  for (const SweepValue& value : key.values) {
    if (HasControls(value.label)) {
      values.Fail("the name '" + WithoutControls(value.label) +
                  "' contains a line break or another control character");
    }
    if (!labels.insert(value.label).second) {
      values.Fail("the value '" + value.label + "' is given twice");
    }
  }
  return key;
}

/// Throws InvalidConfig for too many designs, before any of their values is read.
void ExpectFewDesigns(const YamlValue& keys) {
  std::uint64_t size = 1;
  for (const std::string& path : keys.Keys()) {
    size *= std::max<std::uint64_t>(keys[path].size(), 1);
    if (size > kMostDesigns) keys.Fail(fmt::format("makes more than {} designs", kMostDesigns));
  }
}

}  // namespace

Sweep Sweep::Parse(const std::string& yaml_text, const std::string& where) {
  const YamlValue root = ParseYaml(yaml_text, where);
  root.ExpectMap({"base", kEstimate, "sweep"});
  Sweep sweep;
  sweep.where_ = where;
  BaseScenario base = ReadBaseScenario(root["base"], where);
  sweep.base_ = std::move(base.path);
  sweep.base_text_ = std::move(base.text);
  if (root[kEstimate]) sweep.estimate_ = ReadEstimateList(root[kEstimate]);
  const YamlValue keys = root["sweep"];
  if (!keys.IsMap()) keys.Fail("expected a map from keys of the scenario to their values");
  ExpectFewDesigns(keys);
  for (const std::string& path : keys.Keys()) sweep.keys_.push_back(ReadKey(keys[path], path));
  sweep.ExpectScenarios();
  return sweep;
}

void Sweep::ExpectScenarios() const {
  for (std::uint64_t number = 1; number <= size(); ++number) {
    try {
      ParseEstimate(DesignEstimate(number));
      const Scenario scenario = DesignScenario(number);
      const bool swept = std::any_of(keys_.begin(), keys_.end(),
                                     [](const SweepKey& key) { return key.path == "imu.preset"; });
      if (swept && !scenario.imu.preset) {
        throw InvalidConfig(
            "imu.gyro and imu.accel of the base override its preset; give a base with the preset "
            "alone (such as lar3_rest), or sweep 'imu' as a whole");
      }
    } catch (const InvalidConfig& error) {
      std::string design;
      for (const std::string& label : Labels(number))
        design += (design.empty() ? "" : ", ") + label;
      throw InvalidConfig(fmt::format("design {} ({}): {}", number, design, error.what()),
                          {where_, 0, 0});
    }
  }
}

std::uint64_t Sweep::size() const {
  std::uint64_t size = 1;
  for (const SweepKey& key : keys_) size *= key.values.size();
  return size;
}

std::vector<std::size_t> Sweep::Choice(std::uint64_t number) const {
  if (number < 1 || number > size()) {
    throw InvalidInput(fmt::format("sweep: design {} is not in the range 1 to {}", number, size()));
  }
  std::vector<std::size_t> choice(keys_.size());
  std::uint64_t left = number - 1;
  for (std::size_t k = keys_.size(); k-- > 0;) {
    choice[k] = left % keys_[k].values.size();
    left /= keys_[k].values.size();
  }
  return choice;
}

std::vector<std::string> Sweep::Labels(std::uint64_t number) const {
  const std::vector<std::size_t> choice = Choice(number);
  std::vector<std::string> labels;
  for (std::size_t k = 0; k < keys_.size(); ++k) {
    labels.push_back(keys_[k].values[choice[k]].label);
  }
  return labels;
}

Scenario Sweep::DesignScenario(std::uint64_t number) const {
  const std::vector<std::size_t> choice = Choice(number);
  std::string text = base_text_;
  for (std::size_t k = 0; k < keys_.size(); ++k) {
    if (keys_[k].path == kEstimate) continue;
    text = WithYamlValue(text, keys_[k].path, keys_[k].values[choice[k]].yaml);
  }
  Scenario scenario = ParseScenario(text, base_);
  scenario.name += fmt::format("_{}", number);
  return scenario;
}

std::string Sweep::DesignEstimate(std::uint64_t number) const {
  const std::vector<std::size_t> choice = Choice(number);
  for (std::size_t k = 0; k < keys_.size(); ++k) {
    if (keys_[k].path != kEstimate) continue;
    return JoinedYaml(ParseYaml(keys_[k].values[choice[k]].yaml, where_));
  }
  return estimate_;
}

SweepRecord StudySweepDesign(const Sweep& sweep, std::uint64_t number,
                             const DesignOptions& options) {
  SweepRecord record;
  record.number = number;
  record.labels = sweep.Labels(number);
  StudyOptions study_options{options, false};
  study_options.design.estimate = sweep.DesignEstimate(number);
  try {
    const StudyResult study = Study(sweep.DesignScenario(number), study_options);
    if (!study.observable()) {
      record.failure = UnobservableWords(study).front();
      return record;
    }
    const Eigen::Matrix3d correlation = study.boresight.correlation();
    record.sigma_rad = study.boresight.sigma_rad();
    record.condition_number = study.boresight.condition_number;
    record.correlation_angles = std::max(
        {std::abs(correlation(0, 1)), std::abs(correlation(0, 2)), std::abs(correlation(1, 2))});
    record.correlation_biases =
        std::max(study.boresight.accel_bias.max_abs, study.boresight.gyro_bias.max_abs);
    record.strips = study.strips;
  } catch (const RankDeficient& error) {
    record.failure = error.what();
  } catch (const InvalidConfig& error) {
    record.failure = std::string("cannot be flown: ") + error.what();
  }
  return record;
}

}  // namespace dn
