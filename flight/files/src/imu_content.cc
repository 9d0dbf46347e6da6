#include "imu_content.h"

#include <dn/geo/local_frame.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "picked_columns.h"

namespace dn::files_internal {
namespace {

using Eigen::Vector3d;

constexpr StepRange kImuSteps{1e-5, 1.0};
// Limits of a mean specific force of 1 g, including the motion of a flight.
constexpr double kLeastForce = 7.0, kMostForce = 14.0;
// Averaged over a second, vibration vanishes and gravity stays: less than half of it means free
// fall. A force without gravity has a random length, below half of its mean in a tenth of the time.
constexpr double kMostFall = 0.05;
constexpr double kMostRmsRateRadps = 2.0;
constexpr double kMostRmsRateDegps = 400.0;
// Standard deviation of the length of a vector by its mean; 0.42 for white noise in three axes.
constexpr double kLeastSpread = 0.2;
// Rates at rest may have such a bias, but a magnetometer is more likely.
constexpr double kUnlikelyRates = 0.1;
constexpr std::array<const char*, 6> kImuNames{"wx", "wy", "wz", "fx", "fy", "fz"};

/// A choice of the columns; the last three are the forces.
struct ImuChoice {
  std::vector<NamedColumn> columns;
  double prior;  ///< 1 for the usual order, less for others
};

/// Mean sizes of the values of a choice.
struct ImuSizes {
  double step_s, mean_force, rms_rate, rate_spread, fall_share;
};

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
  const double count = static_cast<double>(table.rows());
  double force = 0.0, rate = 0.0, rate2 = 0.0;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double w2 = Eigen::Map<const Vector3d>(table.row(i) + 1).squaredNorm();
    rate += std::sqrt(w2) / count;
    rate2 += w2 / count;
    force += Eigen::Map<const Vector3d>(table.row(i) + 4).norm() / count;
  }
  const double step_s = MedianTimeStep(table);
  const double spread = std::sqrt(std::max(0.0, rate2 - rate * rate)) / std::max(rate, 1e-300);
  return {step_s, force, std::sqrt(rate2), spread, FallShare(table, step_s)};
}

bool IsGravity(double mps2) { return mps2 > kLeastForce && mps2 < kMostForce; }

/// Sets format and unit of the forces; returns false if no unit gives gravity.
bool FindForceUnit(const ImuSizes& sizes, FileContent* content) {
  content->imu_format = ImuFormat::kOdyn;
  if (IsGravity(sizes.mean_force)) return true;
  content->forces_in_g = IsGravity(kStandardGravityMps2 * sizes.mean_force);
  if (content->forces_in_g) return true;
  content->imu_format = ImuFormat::kIncrements;
  return IsGravity(sizes.mean_force / sizes.step_s);
}

std::string RateUnit(const std::vector<ColumnMeaning>& meanings, const ImuChoice& choice) {
  const std::size_t at = choice.columns[0].at;
  return at < meanings.size() ? meanings[at].unit : std::string();
}

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

ContentFit FitImuChoice(const TextSample& sample, const TimeColumn& time, const ImuChoice& choice) {
  const TextTable table = PickRows(sample, time, choice.columns);
  FileContent content;
  content.kind = FileKind::kImu;
  content.time_offset_s = FindTimeOffset(table.rows() > 0 ? table.row(0)[0] : 0.0);
  FitTests tests(5.0);
  const bool numbers = AreNumbers(table, sample) && table.rows() > 1;
  if (!tests.Expect(numbers, "the columns contain text")) return tests.Result(content);
  const ImuSizes sizes = MeasureImu(table);
  const bool has_gravity = FindForceUnit(sizes, &content);
  tests.Expect(has_gravity, "no three columns contain gravity (mean length " +
                                ShortNumber(sizes.mean_force) + ")");
  tests.Expect(sizes.fall_share <= kMostFall,
               "gravity is removed from the accelerations: export the specific force");
  double rms_rate = sizes.rms_rate;
  if (content.imu_format == ImuFormat::kIncrements) rms_rate /= sizes.step_s;
  const std::string unit = RateUnit(FindMeanings(sample), choice);
  const bool says_deg = unit.find("deg") != std::string::npos || unit == "dps";
  content.rates_in_deg = says_deg || (!unit.starts_with("rad") && rms_rate > kMostRmsRateRadps);
  tests.Expect(rms_rate < (content.rates_in_deg ? kMostRmsRateDegps : kMostRmsRateRadps),
               "the rates are too large (" + ShortNumber(rms_rate) + " rms)");
  tests.Expect(choice.prior == 1.0 || sizes.rate_spread > kLeastSpread,
               "no three columns are angular rates");
  ContentFit fit = tests.Result(content);
  const double unusual = content.forces_in_g                            ? 0.02
                         : content.imu_format == ImuFormat::kIncrements ? 0.03
                                                                        : 0.0;
  fit.score *= choice.prior * (1.0 - unusual);
  if (sizes.rate_spread < kLeastSpread) fit.score *= 1.0 - kUnlikelyRates;
  if (!IsPlainImu(sample, time, choice, content.imu_format)) {
    fit.content.columns = FormatNames(time, choice.columns);
  }
  return fit;
}

std::optional<ImuChoice> NamedImuChoice(const TextSample& sample) {
  const std::vector<ColumnMeaning> meanings = FindMeanings(sample);
  ImuChoice choice{{}, 1.0};
  for (const char* name : kImuNames) {
    const std::optional<NamedColumn> column = FindColumn(meanings, name);
    if (!column) return std::nullopt;
    choice.columns.push_back(*column);
  }
  return choice;
}

/// Returns every choice of three adjacent columns for rates and for forces after the time.
std::vector<ImuChoice> AllImuChoices(const TextSample& sample, const TimeColumn& time) {
  constexpr std::size_t kMostColumns = 16;
  const std::size_t first = std::max(time.at, time.week.value_or(0)) + 1;
  const std::size_t end = std::min(sample.table.columns, first + kMostColumns);
  std::vector<ImuChoice> choices;
  for (std::size_t w = first; w + 3 <= end; ++w) {
    for (std::size_t f = first; f + 3 <= end; ++f) {
      if (w < f + 3 && f < w + 3) continue;
      const std::size_t least = std::min(w, f), apart = std::max(w, f) - least - 3;
      ImuChoice choice{{}, 1.0};
      if (w > f) choice.prior -= 0.02;
      choice.prior -= 0.01 * static_cast<double>(least - first) + 0.01 * static_cast<double>(apart);
      // Vectors usually follow each other in steps of three columns.
      if ((least - first) % 3 != 0 || apart % 3 != 0) choice.prior -= 0.1;
      for (std::size_t k = 0; k < 6; ++k)
        choice.columns.push_back({kImuNames[k], k < 3 ? w + k : f + k - 3});
      choices.push_back(std::move(choice));
    }
  }
  return choices;
}

std::string ImuChoiceText(const ImuChoice& choice) {
  const auto triple = [&](std::size_t k) {
    const std::size_t at = choice.columns[k].at + 1;
    return std::to_string(at) + "-" + std::to_string(at + 2);
  };
  return "rates in columns " + triple(0) + " and forces in columns " + triple(3);
}

ContentFit BestImuChoice(const TextSample& sample, const TimeColumn& time) {
  ContentFit best;
  best.failed = "fewer than 7 columns";
  double second = 0.0;
  std::string first_text, second_text;
  for (const ImuChoice& choice : AllImuChoices(sample, time)) {
    ContentFit fit = FitImuChoice(sample, time, choice);
    const bool better = fit.fits() != best.fits() ? fit.fits() : fit.score > best.score;
    if (better) {
      if (best.fits()) {
        second = best.score;
        second_text = first_text;
      }
      best = std::move(fit);
      first_text = ImuChoiceText(choice);
    } else if (fit.fits() && fit.score > second) {
      second = fit.score;
      second_text = ImuChoiceText(choice);
    }
  }
  if (best.fits() && !best.content.columns.empty()) {
    best.content.why = first_text;
    if (!second_text.empty()) best.content.why += "; second best: " + second_text;
  }
  return best;
}

}  // namespace

ContentFit FitImu(const TextSample& sample) {
  const std::optional<TimeColumn> time = FindTime(sample, kImuSteps);
  ContentFit none;
  none.content.kind = FileKind::kImu;
  none.failed = "no time that increases in steps of 1 s or less";
  if (!time) return none;
  if (const std::optional<ImuChoice> choice = NamedImuChoice(sample))
    return FitImuChoice(sample, *time, *choice);
  return BestImuChoice(sample, *time);
}

}  // namespace dn::files_internal
