#include "imu_choices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "inertial_units.h"
#include "lower_case.h"
#include "vector_columns.h"

namespace dn::files_internal {
namespace {

using ColumnTriple = std::array<std::size_t, 3>;
constexpr std::array<const char*, 6> kImuNames{"wx", "wy", "wz", "fx", "fy", "fz"};

/// Returns the column of an axis of the same sensor, else of any sensor.
std::optional<std::size_t> FindAxis(const std::vector<ColumnMeaning>& meanings,
                                    const std::string& name, const std::string& sensor) {
  for (std::size_t i = 0; i < meanings.size(); ++i) {
    if (meanings[i].name == name && meanings[i].sensor == sensor) return i;
  }
  const std::optional<NamedColumn> any = FindColumn(meanings, name);
  return any ? std::optional(any->at) : std::nullopt;
}

/// Returns the columns x, y, z of each sensor of a quantity, kRate or kForce.
std::vector<ColumnTriple> NamedTriples(const std::vector<ColumnMeaning>& meanings,
                                       const std::string& quantity) {
  std::vector<ColumnTriple> triples;
  std::set<std::string> sensors;
  for (std::size_t i = 0; i < meanings.size(); ++i) {
    if (meanings[i].name != quantity + "x" || !sensors.insert(meanings[i].sensor).second) continue;
    const auto y = FindAxis(meanings, quantity + "y", meanings[i].sensor);
    const auto z = FindAxis(meanings, quantity + "z", meanings[i].sensor);
    if (y && z) triples.push_back({i, *y, *z});
  }
  return triples;
}

/// Returns less than 1 for data that are not calibrated, or without gravity.
double SensorPrior(const std::string& sensor) {
  for (const char* word : {"uncomp", "uncal", "raw", "free", "user", "lin"}) {
    if (sensor.find(word) != sensor.npos) return 0.9;
  }
  return 1.0;
}

ImuChoice ChoiceFromTriples(const ColumnTriple& rates, const ColumnTriple& forces, double prior) {
  ImuChoice choice{{}, prior};
  for (std::size_t k = 0; k < 6; ++k) {
    choice.columns.push_back({kImuNames[k], k < 3 ? rates[k] : forces[k - 3]});
  }
  return choice;
}

std::vector<ColumnTriple> AdjacentTriples(const VectorColumns& vectors,
                                          const std::vector<ColumnMeaning>& meanings) {
  std::vector<ColumnTriple> triples;
  for (const std::size_t at : vectors.triples()) {
    const bool unnamed =
        IsUnnamed(meanings, at) && IsUnnamed(meanings, at + 1) && IsUnnamed(meanings, at + 2);
    if (unnamed) triples.push_back({at, at + 1, at + 2});
  }
  return triples;
}

bool Overlap(const ColumnTriple& a, const ColumnTriple& b) {
  return std::any_of(a.begin(), a.end(),
                     [&](std::size_t at) { return std::find(b.begin(), b.end(), at) != b.end(); });
}

/// Returns the prior of two triples by their places.
double PlacePrior(const VectorColumns& vectors, std::size_t w, std::size_t f) {
  const std::size_t least = std::min(w, f), most = std::max(w, f);
  const std::size_t before = least - std::min(least, vectors.begin());
  const std::size_t apart = most - std::min(most, least + 3);
  double prior = 1.0 - 0.01 * static_cast<double>(before) - 0.01 * static_cast<double>(apart);
  if (w > f) prior -= 0.02;
  // Vectors usually follow each other in steps of three columns.
  if (before % 3 != 0 || apart % 3 != 0) prior -= 0.1;
  return prior;
}

ImuChoice ChoiceByPlace(const VectorColumns& vectors, const ColumnTriple& w,
                        const ColumnTriple& f) {
  constexpr double kPerDecade = 0.05, kLeastPrior = 0.1;
  ImuChoice choice = ChoiceFromTriples(w, f, PlacePrior(vectors, w[0], f[0]));
  choice.is_usual = choice.prior == 1.0;
  choice.prior -= kPerDecade * (vectors.Unlikeness(w[0]) + vectors.Unlikeness(f[0]));
  choice.prior = std::max(kLeastPrior, choice.prior);
  return choice;
}

/// Returns "rates" or "accelerations" for the vector x, y, z of a phone or a small logger; empty
/// if nothing says so.
std::string BareVector(const TextSample& sample, const std::vector<ColumnMeaning>& meanings) {
  std::vector<NamedColumn> columns;
  for (const char* name : {"x", "y", "z"}) {
    const auto column = FindColumn(meanings, name);
    if (!column) return {};
    columns.push_back(*column);
  }
  for (const char* name : {"lat", "east", "qw", "roll", "heading", "h"}) {
    if (FindColumn(meanings, name)) return {};
  }
  const std::string& unit = meanings[columns[0].at].unit;
  if (RateUnitSize(unit)) return "rates";
  if (!unit.empty() && StatesForceUnit(unit)) return "accelerations";
  const std::string file = LowerCase(sample.table.file.stem().string());
  if (file.find("gyr") != file.npos) return "rates";
  return file.find("acc") != file.npos ? "accelerations" : "";
}

}  // namespace

std::vector<ImuChoice> NamedImuChoices(const TextSample& sample) {
  const std::vector<ColumnMeaning> meanings = FindMeanings(sample);
  std::vector<ImuChoice> choices;
  constexpr double kPerSensor = 0.01;
  double later = 1.0;
  for (const ColumnTriple& rates : NamedTriples(meanings, kRate)) {
    for (const ColumnTriple& forces : NamedTriples(meanings, kForce)) {
      const double prior =
          later * SensorPrior(meanings[rates[0]].sensor) * SensorPrior(meanings[forces[0]].sensor);
      choices.push_back(ChoiceFromTriples(rates, forces, prior));
      choices.back().is_named = true;
      later -= kPerSensor;
    }
  }
  return choices;
}

std::vector<ImuChoice> AllImuChoices(const TextSample& sample, const TimeColumn& time) {
  const std::vector<ColumnMeaning> meanings = FindMeanings(sample);
  const VectorColumns vectors(sample, time, std::max(time.at, time.week.value_or(0)) + 1);
  std::vector<ColumnTriple> rates = NamedTriples(meanings, kRate);
  std::vector<ColumnTriple> forces = NamedTriples(meanings, kForce);
  const std::vector<ColumnTriple> others = AdjacentTriples(vectors, meanings);
  const bool named_rates = !rates.empty(), named_forces = !forces.empty();
  if (!named_rates) rates = others;
  if (!named_forces) forces = others;
  std::vector<ImuChoice> choices;
  for (const ColumnTriple& w : rates) {
    if (!named_rates && vectors.IsIntegral(w[0])) continue;
    for (const ColumnTriple& f : forces) {
      if (Overlap(w, f)) continue;
      const bool named = named_rates || named_forces;
      choices.push_back(named ? ChoiceFromTriples(w, f, 1.0) : ChoiceByPlace(vectors, w, f));
    }
  }
  return choices;
}

std::string SingleSensorReason(const TextSample& sample) {
  const std::vector<ColumnMeaning> meanings = FindMeanings(sample);
  const bool rates = !NamedTriples(meanings, kRate).empty();
  const bool forces = !NamedTriples(meanings, kForce).empty();
  const bool position = FindColumn(meanings, "lat") && FindColumn(meanings, "lon");
  if (position || (rates && forces)) return {};
  std::string only = rates ? "rates" : forces ? "accelerations" : BareVector(sample, meanings);
  return only.empty() ? only : "only " + only + ": join both files by time into one";
}

}  // namespace dn::files_internal
