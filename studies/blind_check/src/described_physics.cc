#include <dn/blind_check/described_physics.h>
#include <dn/config/yaml_value.h>
#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <dn/names.h>
#include <fmt/format.h>

#include <algorithm>

#include "error_quantity.h"
#include "shape.h"

namespace dn {
namespace {

constexpr std::size_t kMostEntries = 100;
constexpr const char* kTime = "time_s";

template <class Named>
std::vector<std::pair<std::string, const Named*>> Choices(const std::vector<Named>& all) {
  std::vector<std::pair<std::string, const Named*>> choices;
  for (const Named& one : all) choices.emplace_back(one.name, &one);
  return choices;
}

std::string ReadPhysicsName(const YamlValue& value, const std::vector<DescribedPhysics>& before) {
  std::string name = ReadName(value);
  const bool is_word =
      !name.empty() &&
      name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos;
  if (!is_word) value.Fail("'" + name + "' is not a name of a-z, 0-9 and _");
  if (FindEffect(name)) value.Fail("the library has an effect '" + name + "'");
  const bool twice = HasName(UnlistedEffectNames(), name) ||
                     std::any_of(before.begin(), before.end(),
                                 [&](const DescribedPhysics& one) { return one.name == name; });
  if (twice) value.Fail("there is a second '" + name + "'");
  return name;
}

void ReadArgument(const YamlValue& entry, const ErrorQuantity& quantity, const Shape& shape,
                  DescribedPhysics* physics) {
  const YamlValue of = entry["of"];
  physics->of = of ? of.Text() : kTime;
  if (!HasName(quantity.known, physics->of)) {
    of.Fail(fmt::format("{} has no value for '{}'; possible: {}", quantity.name, physics->of,
                        fmt::join(quantity.known, ", ")));
  }
  if (shape.needs_time && physics->of != kTime) {
    of.Fail(fmt::format("the shape {} is a function of {} only", shape.name, kTime));
  }
}

// A period, a time constant and the like must be positive; a position may have any sign.
void ReadRange(const YamlValue& range, const Shape& shape, DescribedPhysics* physics) {
  const Eigen::VectorXd ends = ReadNumbers(range, 2);
  physics->lowest = ends(0);
  physics->highest = ends(1);
  const bool is_linear = std::string(shape.name) == "linear";
  if (physics->lowest > physics->highest || (is_linear && physics->lowest == physics->highest)) {
    range.Fail("the first number must be the smaller one");
  }
  const bool any_sign = is_linear || std::string(shape.name) == "step";
  if (!any_sign && physics->lowest <= 0.0) range.Fail("both numbers must be above 0");
}

DescribedPhysics ReadEntry(const YamlValue& entry, const std::vector<DescribedPhysics>& before) {
  const Shape& shape = *entry["shape"].Choice(Choices(Shapes()));
  std::vector<std::string> keys = {"name", "adds_to", "size", "shape", "of"};
  const std::string parameter = shape.parameter;
  if (!parameter.empty()) keys.push_back(parameter);
  entry.ExpectMap(keys);
  const ErrorQuantity& quantity = *entry["adds_to"].Choice(Choices(ErrorQuantities()));
  DescribedPhysics physics;
  physics.name = ReadPhysicsName(entry["name"], before);
  physics.adds_to = quantity.name;
  physics.size = ReadPositive(entry["size"]);
  physics.shape = shape.name;
  if (physics.shape == "step" && !quantity.steps) {
    entry["shape"].Fail(fmt::format("a step of {} would make the times go back", quantity.name));
  }
  ReadArgument(entry, quantity, shape, &physics);
  if (!parameter.empty()) ReadRange(entry[parameter], shape, &physics);
  return physics;
}

Eigen::Vector3d ReadAmplitude(const Json& parameters) {
  const auto values = parameters.at("amplitude").get<std::vector<double>>();
  Eigen::Vector3d amplitude = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < std::min<std::size_t>(values.size(), 3); ++i) {
    amplitude(static_cast<Eigen::Index>(i)) = values[i];
  }
  return amplitude;
}

}  // namespace

std::vector<DescribedPhysics> ParsePhysics(const std::string& text, const std::string& file) {
  const YamlValue root = ParseYaml(text, file);
  root.ExpectMap({"physics"});
  std::vector<DescribedPhysics> list;
  for (const YamlValue& entry : root["physics"].List(kMostEntries)) {
    list.push_back(ReadEntry(entry, list));
  }
  if (list.empty()) root["physics"].Fail("the list is empty");
  return list;
}

UnlistedEffect DrawDescribedPhysics(const DescribedPhysics& physics, const FlightTimes& times,
                                    Random& random) {
  const double size = LogUniform(physics.size, 10.0 * physics.size, random);
  const ErrorQuantity& quantity = FindErrorQuantity(physics.adds_to);
  Json parameters = {{"adds_to", physics.adds_to}, {"of", physics.of}};
  parameters["amplitude"] = DrawAxes(quantity.axes, size, random);
  parameters["begin_s"] = times.strips.front().t0_s;
  parameters["shape"] =
      FindShape(physics.shape).draw(physics.lowest, physics.highest, times, random);
  parameters["shape"]["name"] = physics.shape;
  return {physics.name, parameters};
}

bool IsDescribed(const Json& parameters) { return parameters.contains("adds_to"); }

OwnErrors MakeDescribedErrors(const Json& parameters, const Scenario& scenario) {
  const Json& shape = parameters.at("shape");
  const DrawnError error{
      ReadAmplitude(parameters), FindShape(shape.at("name").get<std::string>()).make(shape),
      parameters.at("of").get<std::string>(), parameters.at("begin_s").get<double>()};
  const auto name = parameters.at("adds_to").get<std::string>();
  return FindErrorQuantity(name).make(error, scenario);
}

}  // namespace dn
