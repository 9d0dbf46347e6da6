#include "imu_content.h"

#include <dn/geo/local_frame.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "imu_choices.h"
#include "inertial_units.h"
#include "lower_case.h"
#include "picked_columns.h"

namespace dn::files_internal {
namespace {

using Eigen::Vector3d;

constexpr StepRange kImuSteps{1e-5, 1.0, 5e-3};
// Limits of a mean specific force of 1 g, including the motion of a flight.
constexpr double kLeastForce = 7.0, kMostForce = 14.0;
// Averaged over a second, vibration vanishes and gravity stays: less than half of it means free
// fall. A force without gravity has a random length, below half of its mean in a tenth of the time.
constexpr double kMostFall = 0.05;
constexpr double kMostRmsRateRadps = 2.0;
constexpr double kMostRmsRateDegps = 400.0;
// Standard deviation of the length of a vector by its mean; 0.42 for white noise in three axes.
constexpr double kLeastSpread = 0.2;
// Rates at rest may have such a bias, but a magnetometer is more likely. In motion, it turns by
// several times the changes of its length; a bias with noise does not.
constexpr double kUnlikelyRates = 0.1, kFieldRates = 0.3, kLeastTurn = 3.0;
// Standard deviation of the length of gravity alone, by its mean and by the change of direction.
// Accelerometers have more noise.
constexpr double kMostGravitySpread = 1e-4, kMostGravityShare = 0.01;

/// Mean sizes of the values of a choice.
struct ImuSizes {
  double step_s = 0.0, mean_force = 0.0, rms_rate = 0.0, rate_spread = 0.0, fall_share = 0.0;
  bool is_gravity_alone = false;
  bool is_field = false;  ///< the rates turn with a constant length, like a magnetic field
};

/// Mean length of a vector, and the standard deviations of its length and of the vector.
struct VectorSpread {
  double mean_length, length, vector;
};

/// Measures the vector in columns `at` and the next two.
VectorSpread MeasureSpread(const TextTable& table, std::size_t at) {
  const double count = static_cast<double>(table.rows());
  const auto vector = [&](std::size_t i) { return Eigen::Map<const Vector3d>(table.row(i) + at); };
  Vector3d mean = Vector3d::Zero();
  double mean_length = 0.0, length2 = 0.0, vector2 = 0.0;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    mean += vector(i) / count;
    mean_length += vector(i).norm() / count;
  }
  for (std::size_t i = 0; i < table.rows(); ++i) {
    length2 += std::pow(vector(i).norm() - mean_length, 2) / count;
    vector2 += (vector(i) - mean).squaredNorm() / count;
  }
  return {mean_length, std::sqrt(length2), std::sqrt(vector2)};
}

/// Returns whether the vector is gravity without accelerations: it turns, but its length is
/// constant.
bool IsGravityAlone(const VectorSpread& force) {
  return force.length < kMostGravitySpread * force.mean_length &&
         force.length < kMostGravityShare * force.vector;
}

double FallShare(const TextTable& table, double step_s) {
  const auto block = static_cast<std::size_t>(std::clamp(std::round(1.0 / step_s), 1.0, 1e6));
  std::vector<double> lengths;
  double sum = 0.0;
  for (std::size_t i = 0; i + block <= table.rows(); i += block) {
    Vector3d mean = Vector3d::Zero();
    for (std::size_t k = i; k < i + block; ++k)
      mean += Eigen::Map<const Vector3d>(table.row(k) + 4);
    lengths.push_back(mean.norm() / static_cast<double>(block));
    sum += lengths.back();
  }
  if (lengths.empty()) return 0.0;
  const double half = 0.5 * sum / static_cast<double>(lengths.size());
  const auto falls =
      std::count_if(lengths.begin(), lengths.end(), [&](double x) { return x < half; });
  return static_cast<double>(falls) / static_cast<double>(lengths.size());
}

ImuSizes MeasureImu(const TextTable& table) {
  const VectorSpread rate = MeasureSpread(table, 1), force = MeasureSpread(table, 4);
  const double step_s = MedianTimeStep(table);
  ImuSizes sizes;
  sizes.step_s = step_s;
  sizes.mean_force = force.mean_length;
  sizes.rms_rate = std::hypot(rate.mean_length, rate.length);
  sizes.rate_spread = rate.length / std::max(rate.mean_length, 1e-300);
  sizes.fall_share = FallShare(table, step_s);
  sizes.is_gravity_alone = IsGravityAlone(force);
  sizes.is_field = sizes.rate_spread < kLeastSpread && rate.vector > kLeastTurn * rate.length;
  return sizes;
}

bool IsGravity(double mps2) { return mps2 > kLeastForce && mps2 < kMostForce; }

/// Sets format and unit of the forces by their size; returns false if no unit gives gravity.
bool FindForceUnit(const ImuSizes& sizes, FileContent* content) {
  content->imu_format = ImuFormat::kOdyn;
  if (IsGravity(sizes.mean_force)) return true;
  content->forces_in_g = IsGravity(kStandardGravityMps2 * sizes.mean_force);
  if (content->forces_in_g) return true;
  content->imu_format = ImuFormat::kIncrements;
  return IsGravity(sizes.mean_force / sizes.step_s);
}

/// Sets the unit that the header states, other than m/s^2 and g. Returns false if it gives gravity
/// neither for forces nor for increments.
bool SetForceUnit(double unit, const ImuSizes& sizes, FileContent* content) {
  content->force_unit = unit;
  if (IsGravity(unit * sizes.mean_force)) return true;
  content->imu_format = ImuFormat::kIncrements;
  return IsGravity(unit * sizes.mean_force / sizes.step_s);
}

/// Returns the unit of the first of three columns; empty if the header states none.
std::string StatedUnit(const std::vector<ColumnMeaning>& meanings, const NamedColumn& column) {
  return column.at < meanings.size() ? meanings[column.at].unit : std::string();
}

bool IsUsualForceUnit(double unit) { return unit == 1.0 || unit == kStandardGravityMps2; }

std::string ShortNumber(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

/// Returns whether the rows are those of a documented format, without names of columns.
bool IsPlainImu(const TextSample& sample, const TimeColumn& time, const ImuChoice& choice,
                ImuFormat format) {
  if (sample.needs_names || time.name != "t" || time.week || time.at != 0) return false;
  for (std::size_t k = 0; k < 6; ++k) {
    if (choice.columns[k].at != k + 1) return false;
  }
  const bool odometer = sample.table.columns == 8 && format == ImuFormat::kIncrements;
  return sample.table.columns == 7 || odometer;
}

/// Tests whether the forces contain gravity, and sets their unit and the format.
void TestForces(const ImuSizes& sizes, const std::string& stated, FileContent* content,
                FitTests* tests) {
  const std::optional<double> unit = ForceUnitSize(stated);
  const bool is_known = unit || !StatesForceUnit(stated);
  tests->Expect(is_known, "the unit of the accelerations, '" + stated + "', is not known");
  const bool has_gravity = unit && !IsUsualForceUnit(*unit) ? SetForceUnit(*unit, sizes, content)
                                                            : FindForceUnit(sizes, content);
  tests->Expect(has_gravity, "no three columns contain gravity (mean length " +
                                 ShortNumber(sizes.mean_force) + (unit ? " " + stated + ")" : ")"));
  tests->Expect(sizes.fall_share <= kMostFall,
                "gravity is removed from the accelerations: export the specific force");
  tests->Expect(!sizes.is_gravity_alone,
                "the vector of 1 g is gravity without accelerations: export the specific force");
}

/// Tests the size of the rates, and sets their unit.
void TestRates(const ImuSizes& sizes, const std::string& stated, FileContent* content,
               FitTests* tests) {
  const std::optional<double> unit = RateUnitSize(stated);
  const bool is_known = unit || !StatesRateUnit(stated);
  tests->Expect(is_known, "the unit of the angular rates, '" + stated + "', is not known");
  double rms_rate = sizes.rms_rate;
  if (content->imu_format == ImuFormat::kIncrements) rms_rate /= sizes.step_s;
  content->rates_in_deg = unit ? *unit == kRadPerDeg : rms_rate > kMostRmsRateRadps;
  if (unit && *unit != 1.0 && !content->rates_in_deg) content->rate_unit = *unit;
  const double most_radps =
      content->rates_in_deg || unit ? kMostRmsRateDegps * kRadPerDeg : kMostRmsRateRadps;
  const double assumed = content->rates_in_deg ? kRadPerDeg : 1.0;
  tests->Expect(rms_rate * unit.value_or(assumed) < most_radps,
                "the rates are too large (" + ShortNumber(rms_rate) + " " + stated + " rms)");
}

ContentFit FitImuChoice(const TextSample& sample, const TimeColumn& time, const ImuChoice& choice) {
  const TextTable table = PickRows(sample, time, choice.columns);
  FileContent content;
  content.kind = FileKind::kImu;
  content.time_offset_s = FindTimeOffset(table.rows() > 0 ? table.row(0)[0] : 0.0);
  FitTests tests(8.0);
  const bool numbers = AreNumbers(table, sample) && table.rows() > 1;
  if (!tests.Expect(numbers, "the columns contain text")) return tests.Result(content);
  const ImuSizes sizes = MeasureImu(table);
  const std::vector<ColumnMeaning> meanings = FindMeanings(sample);
  TestForces(sizes, StatedUnit(meanings, choice.columns[3]), &content, &tests);
  TestRates(sizes, StatedUnit(meanings, choice.columns[0]), &content, &tests);
  tests.Expect(choice.is_named || choice.is_usual || sizes.rate_spread > kLeastSpread,
               "no three columns are angular rates");
  ContentFit fit = tests.Result(content);
  const double unusual = content.forces_in_g                            ? 0.02
                         : content.imu_format == ImuFormat::kIncrements ? 0.03
                                                                        : 0.0;
  fit.score *= choice.prior * (1.0 - unusual);
  const double unlikely = sizes.is_field ? kFieldRates : kUnlikelyRates;
  if (sizes.rate_spread < kLeastSpread) fit.score *= 1.0 - unlikely;
  if (!IsPlainImu(sample, time, choice, content.imu_format)) {
    fit.content.columns = FormatNames(time, choice.columns);
  }
  return fit;
}

std::string ImuChoiceText(const ImuChoice& choice) {
  const auto triple = [&](std::size_t k) {
    const std::size_t at = choice.columns[k].at + 1;
    return std::to_string(at) + "-" + std::to_string(at + 2);
  };
  return "rates in columns " + triple(0) + " and forces in columns " + triple(3);
}

ContentFit BestImuChoice(const TextSample& sample, const TimeColumn& time,
                         const std::vector<ImuChoice>& choices) {
  ContentFit best;
  best.content.kind = FileKind::kImu;
  best.failed = "no two vectors of three columns";
  double second = 0.0;
  std::string first_text, second_text;
  for (const ImuChoice& choice : choices) {
    ContentFit fit = FitImuChoice(sample, time, choice);
    const bool better = fit.fits() != best.fits() ? fit.fits() : fit.score > best.score;
    if (better) {
      if (best.fits()) {
        second = best.score;
        second_text = first_text;
      }
      best = std::move(fit);
      first_text = choice.is_named ? "" : ImuChoiceText(choice);
    } else if (fit.fits() && fit.score > second) {
      second = fit.score;
      second_text = ImuChoiceText(choice);
    }
  }
  if (best.fits() && !best.content.columns.empty() && !first_text.empty()) {
    best.content.why = first_text;
    if (!second_text.empty()) best.content.why += "; second best: " + second_text;
  }
  return best;
}

bool NamesStrapdownIncrements(const TextSample& sample) {
  return std::any_of(sample.names.begin(), sample.names.end(),
                     [](const std::string& name) { return LowerCase(name).starts_with("oriinc"); });
}

/// Says why a file without a time is not inertial data.
std::string NoTimeReason(const TextSample& sample) {
  std::string reason = "no time that increases in steps of 1 s or less";
  for (const std::string& name : sample.names) {
    const std::string meaning = FindMeaning(name).name;
    if (meaning == kRowCount) {
      reason.append(" ('").append(name).append("' counts rows): export the time as well");
      return reason;
    }
    const bool is_time = LowerCase(name).find("time") != name.npos;
    if (meaning == kOtherQuantity && is_time) return "the unit of '" + name + "' is not known";
  }
  return reason;
}

}  // namespace

std::optional<TimeColumn> FindImuTime(const TextSample& sample) {
  return FindTime(sample, kImuSteps);
}

ContentFit FitImu(const TextSample& sample) {
  const std::optional<TimeColumn> time = FindImuTime(sample);
  ContentFit none;
  none.content.kind = FileKind::kImu;
  none.failed = NoTimeReason(sample);
  if (!time) return none;
  std::vector<ImuChoice> choices = NamedImuChoices(sample);
  if (choices.empty()) choices = AllImuChoices(sample, *time);
  ContentFit fit = BestImuChoice(sample, *time, choices);
  const std::string single = SingleSensorReason(sample);
  if (!fit.fits() && !single.empty()) fit.failed = single;
  if (!fit.fits() && NamesStrapdownIncrements(sample)) {
    fit.failed = "increments of the orientation (OriInc) are not supported: export Acc and Gyr";
  }
  if (fit.fits() && time->name == "t_100us") {
    fit.content.why += (fit.content.why.empty() ? "" : "; ");
    fit.content.why += "SampleTimeFine counts 0.1 ms";
  }
  return fit;
}

}  // namespace dn::files_internal
