#include "shape.h"

#include <dn/error.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "random_walk.h"

namespace dn {
namespace {

using Function = std::function<double(double x)>;

constexpr double kTurn_rad = 2.0 * std::numbers::pi;
constexpr double kStepOfWalk_s = 1.0;

Json DrawSine(double lowest, double highest, const FlightTimes&, Random& random) {
  return {{"period", LogUniform(lowest, highest, random)},
          {"phase_rad", random.Uniform(0.0, kTurn_rad)}};
}

Function Sine(const Json& drawn) {
  const double rate = kTurn_rad / drawn.at("period").get<double>();
  const double phase_rad = drawn.at("phase_rad");
  return [=](double x) { return std::sin(rate * x + phase_rad); };
}

Json DrawStep(double lowest, double highest, const FlightTimes&, Random& random) {
  return {{"at", random.Uniform(lowest, highest)}};
}

Function Step(const Json& drawn) {
  const double at = drawn.at("at");
  return [=](double x) { return x < at ? 0.0 : 1.0; };
}

Json DrawLinear(double lowest, double highest, const FlightTimes&, Random&) {
  return {{"from", lowest}, {"to", highest}};
}

Function Linear(const Json& drawn) {
  const double from = drawn.at("from"), to = drawn.at("to");
  return [=](double x) { return std::clamp(2.0 * (x - from) / (to - from) - 1.0, -1.0, 1.0); };
}

Json DrawDecay(double lowest, double highest, const FlightTimes&, Random& random) {
  return {{"tau", LogUniform(lowest, highest, random)}};
}

Function Decay(const Json& drawn) {
  const double tau = drawn.at("tau");
  return [=](double x) { return std::exp(-std::max(x, 0.0) / tau); };
}

// The walk begins at zero, and the standard deviation at its end is 1.
Json DrawWalk(double, double, const FlightTimes& times, Random& random) {
  const double length_s = times.strips.back().t1_s - times.strips.front().t0_s;
  const auto steps = static_cast<int>(std::ceil(length_s / kStepOfWalk_s)) + 1;
  const double step_sigma = 1.0 / std::sqrt(static_cast<double>(steps));
  return {{"step_s", kStepOfWalk_s}, {"values", DrawRandomWalk(steps, step_sigma, random)}};
}

Function Walk(const Json& drawn) {
  const double step_s = drawn.at("step_s");
  const auto values = drawn.at("values").get<std::vector<double>>();
  return [=](double x) { return RandomWalkAt(values, x / step_s); };
}

Json DrawPerStrip(double, double, const FlightTimes& times, Random& random) {
  Json starts_s = Json::array(), values = Json::array();
  for (const StripInterval& strip : times.strips) {
    starts_s.push_back(strip.t0_s - times.strips.front().t0_s);
    values.push_back(random.Normal());
  }
  return {{"starts_s", starts_s}, {"values", values}};
}

// Each value holds from the start of its strip to that of the next one.
Function PerStrip(const Json& drawn) {
  const auto starts_s = drawn.at("starts_s").get<std::vector<double>>();
  const auto values = drawn.at("values").get<std::vector<double>>();
  return [=](double x) {
    const auto next = std::upper_bound(starts_s.begin(), starts_s.end(), x) - starts_s.begin();
    return values[static_cast<std::size_t>(std::max<std::ptrdiff_t>(next, 1) - 1)];
  };
}

}  // namespace

const std::vector<Shape>& Shapes() {
  static const std::vector<Shape> shapes = {
      {"sine", "period", false, &DrawSine, &Sine},
      {"step", "at", false, &DrawStep, &Step},
      {"linear", "over", false, &DrawLinear, &Linear},
      {"decay", "tau", false, &DrawDecay, &Decay},
      {"walk", "", true, &DrawWalk, &Walk},
      {"per_strip", "", true, &DrawPerStrip, &PerStrip},
  };
  return shapes;
}

const Shape& FindShape(const std::string& name) {
  for (const Shape& shape : Shapes()) {
    if (name == shape.name) return shape;
  }
  throw InvalidInput("unknown shape '" + name + "'");
}

}  // namespace dn
