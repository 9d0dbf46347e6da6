#include <dn/adjustment/result.h>
#include <dn/adjustment/unknown_noise.h>
#include <dn/builder/gnss_factors.h>
#include <dn/imu/unknown_imu.h>
#include <dn/imu/white_rows.h>
#include <dn/navigation/slow_gnss_errors.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/prediction.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "gnss_clock.h"
#include "readjust.h"

namespace dn {
namespace {

constexpr const char* kGnssSigmaScale = "gnss.sigma_scale";
constexpr int kMostRounds = 20, kMostScreenings = 3;
constexpr double kSmallestChange = 0.03;
// Degrees of freedom of the prior of a variance.
constexpr double kPriorDof = 1.0;
// Sensors that contradict each other at the start sizes are tried with sizes twice as large, at
// most this often.
constexpr int kMostDoublings = 3;

/// Redundancy and sum of squares of some residuals.
struct Misfit {
  double redundancy = 0.0;
  double squares = 0.0;
};

/// Returns the misfit of each channel of an adjusted flight.
std::map<std::string, Misfit> ChannelMisfits(const Adjustment& adjustment, int threads) {
  Marginals marginals(adjustment.network->net(),
                      {.threads = threads, .analysis = adjustment.analysis});
  marginals.ComputeSelectedInverse();
  const Eigen::VectorXd redundancy = RedundancyNumbers(marginals);
  const LinearizedNetwork& linearized = marginals.linearized();
  std::map<std::string, Misfit> misfits;
  for (const LinearizedNetwork::FactorRows& rows : linearized.factors()) {
    const FactorGroup& group = linearized.group(rows.factor);
    if (!group.measured()) continue;
    for (int k = 0; k < rows.count; ++k) {
      Misfit& misfit = misfits[group.Channel(k)];
      misfit.redundancy += redundancy[rows.first + k];
      misfit.squares += std::pow(linearized.residual()[rows.first + k], 2);
    }
  }
  return misfits;
}

/// Makes the GNSS clock an unknown of a flight for as long as this object lives.
class UnknownClock {
 public:
  explicit UnknownClock(FlightConfig* config) : config_(config), stated_(config->estimate) {}
  ~UnknownClock() { config_->estimate = stated_; }
  UnknownClock(const UnknownClock&) = delete;
  UnknownClock& operator=(const UnknownClock&) = delete;

  void Free() { adjustment_internal::EstimateGnssClock(config_); }

 private:
  FlightConfig* config_;
  std::vector<EstimateEntry> stated_;
};

/// Adjusts one flight with changing noise. Alignment and screening need most of the time and hardly
/// depend on the noise, so that they are not repeated with every size.
class NoiseRounds {
 public:
  NoiseRounds(const Flight& flight, const AdjustOptions& options, UnknownClock* clock)
      : flight_(flight), options_(options), clock_(*clock) {}

  /// Makes the first adjustment, with all stages.
  void Start() { Take(Adjust(flight_, options_)); }

  /// Adjusts with the present noise and the same measurements.
  void Repeat() {
    last_ = options_.stages.empty()
                ? adjustment_internal::Readjust(flight_, options_, std::move(last_))
                : Adjust(flight_, options_);
  }

  /// Adjusts with an unknown clock from now on: larger errors of the positions may hide one.
  void FreeClock() {
    clock_.Free();
    Repeat();
  }

  /// Adjusts with the present noise and screens the measurements again.
  void Screen() { Take(ScreenAgain()); }

  std::map<std::string, Misfit> Misfits() const { return ChannelMisfits(last_, options_.threads); }

  /// Returns the slow part of the errors of the GNSS positions, see FindSlowGnssErrors.
  std::optional<SlowGnssErrors> SlowErrors() const {
    const Marginals marginals(last_.network->net(),
                              {.threads = options_.threads, .analysis = last_.analysis});
    return FindSlowGnssErrors(*last_.network, marginals.linearized());
  }

 private:
  Adjustment ScreenAgain() {
    return options_.stages.empty()
               ? adjustment_internal::ScreenAgain(flight_, options_, std::move(last_))
               : Adjust(flight_, options_);
  }

  /// Keeps a screened adjustment. A clock error that it finds becomes an unknown, since it would be
  /// taken for noise.
  void Take(Adjustment adjustment) {
    last_ = std::move(adjustment);
    if (last_.gnss_clock) {
      clock_.Free();
      last_ = ScreenAgain();
    }
  }

  const Flight& flight_;
  const AdjustOptions& options_;
  UnknownClock& clock_;
  Adjustment last_;
};

/// Sizes that one factor scales, because the same residuals show them.
class ScaledSizes {
 public:
  ScaledSizes(std::vector<std::string> channels, double smallest_factor)
      : channels_(std::move(channels)), smallest_factor_(smallest_factor) {}

  void Add(std::string name, std::string unit, double unit_si, double* value) {
    if (*value > 0.0) sizes_.push_back({std::move(name), std::move(unit), unit_si, *value, value});
  }

  void Double() { Scale(2.0 * factor_); }

  bool Contain(const std::string& name) const {
    return std::ranges::any_of(sizes_, [&](const Size& size) { return size.name == name; });
  }

  /// Continues from this share of the present sizes as a new start.
  void StartAt(double share) {
    for (Size& size : sizes_) size.start *= factor_ * share;
    factor_ = 1.0;
    Scale(1.0);
  }

  /// Remembers the present sizes for GoBack.
  void Keep() { kept_factor_ = factor_; }
  void GoBack() { Scale(kept_factor_); }

  /// Takes the residuals of an adjustment with the present sizes. Returns the relative change.
  double Update(const std::map<std::string, Misfit>& misfits) {
    if (sizes_.empty()) return 0.0;
    Misfit sum;
    for (const std::string& channel : channels_) {
      const auto at = misfits.find(channel);
      if (at == misfits.end()) continue;
      sum.redundancy += at->second.redundancy;
      sum.squares += at->second.squares;
    }
    redundancy_ = sum.redundancy;
    const double variance =
        (kPriorDof + factor_ * factor_ * sum.squares) / (kPriorDof + sum.redundancy);
    return Scale(std::max(smallest_factor_, std::sqrt(variance)));
  }

  /// Replaces the mode of the variances by their posterior mean, which allows for what is not known
  /// of them.
  void TakeMean() {
    const double dof = kPriorDof + redundancy_;
    if (dof > kLeastDof) Scale(factor_ * std::sqrt(dof / (dof - 2.0)));
  }

  void Append(std::vector<NoiseSize>* list) const {
    const double dof = kPriorDof + redundancy_;
    for (const Size& size : sizes_) {
      list->push_back({size.name, size.unit, size.start / size.unit_si, *size.value / size.unit_si,
                       1.0 / std::sqrt(2.0 * dof), redundancy_});
    }
  }

 private:
  // A posterior with fewer degrees of freedom keeps its mode.
  static constexpr double kLeastDof = 4.0;

  struct Size {
    std::string name, unit;
    double unit_si, start;
    double* value;
  };

  double Scale(double factor) {
    const double change = std::abs(factor / factor_ - 1.0);
    factor_ = factor;
    for (const Size& size : sizes_) *size.value = factor * size.start;
    return change;
  }

  std::vector<std::string> channels_;
  double smallest_factor_;
  std::vector<Size> sizes_;
  double factor_ = 1.0, kept_factor_ = 1.0, redundancy_ = 0.0;
};

/// Units of the noise of a triad in flight.yaml, in SI.
struct TriadUnits {
  const char *white, *markov, *walk;
  double white_si, markov_si, walk_si;
};

ScaledSizes WhiteNoise(const std::string& name, const TriadUnits& units,
                       std::vector<std::string> channels, SensorNoise* noise) {
  ScaledSizes scaled(std::move(channels), 0.0);
  scaled.Add("imu." + name + ".white", units.white, units.white_si, &noise->white);
  return scaled;
}

ScaledSizes Processes(const std::string& name, const TriadUnits& units, SensorNoise* noise) {
  ScaledSizes scaled({name + " bias process"}, 0.0);
  for (std::size_t k = 0; k < noise->processes.size(); ++k) {
    BiasProcess& process = noise->processes[k];
    if (process.type == BiasProcess::Type::kRandomConstant) continue;
    const bool walk = process.type == BiasProcess::Type::kRandomWalk;
    scaled.Add("imu." + name + ".processes[" + std::to_string(k) + "]",
               walk ? units.walk : units.markov, walk ? units.walk_si : units.markov_si,
               &process.sigma);
  }
  return scaled;
}

/// Returns the sizes of GNSS positions and velocities. The velocities get a scale of their own.
std::vector<ScaledSizes> GnssSizes(Flight* flight) {
  GnssConfig& config = *flight->config.gnss;
  std::vector<ScaledSizes> all{ScaledSizes({"gnss position"}, 1.0)};
  all.back().Add(kGnssSigmaScale, "1", 1.0, &config.sigma_scale);
  if (!UsesVelocities(*flight)) return all;
  if (!config.velocity_sigma_scale) config.velocity_sigma_scale = config.sigma_scale;
  all.emplace_back(ScaledSizes({"gnss velocity"}, 1.0));
  all.back().Add("gnss.velocity_sigma_scale", "1", 1.0, &*config.velocity_sigma_scale);
  return all;
}

/// Returns all sizes that are estimated. They point into the configuration of the flight.
std::vector<ScaledSizes> EstimatedSizes(Flight* flight) {
  const TriadUnits gyro{"deg/sqrt(h)",
                        "deg/h",
                        "deg/h/sqrt(h)",
                        RadPerSqrtSFromDegPerSqrtHour(1.0),
                        RadpsFromDegPerHour(1.0),
                        RadpsPerSqrtSFromDegPerHourPerSqrtHour(1.0)};
  const TriadUnits accel{"m/s/sqrt(h)",   "mg",
                         "mg/sqrt(h)",    MpsPerSqrtSFromMpsPerSqrtHour(1.0),
                         Mps2FromMg(1.0), Mps2PerSqrtSFromMgPerSqrtHour(1.0)};
  ImuModel& model = flight->config.imu->model;
  std::vector<ScaledSizes> all{
      WhiteNoise("gyro", gyro, {"inertial gyro"}, &model.gyro),
      WhiteNoise("accel", accel, {"inertial velocity", "inertial position"}, &model.accel),
      Processes("gyro", gyro, &model.gyro), Processes("accel", accel, &model.accel)};
  for (ScaledSizes& sizes : GnssSizes(flight)) all.push_back(std::move(sizes));
  return all;
}

/// Starts white noise that the flight does not state at the level of the raw data.
void StartAtRawLevel(const ImuData& imu, ImuModel* model) {
  const ImuModel unstated = UnknownImu();
  const WhiteNoiseDensities raw = EstimateWhiteNoise(imu);
  if (model->gyro.white == unstated.gyro.white && raw.gyro_rad_per_sqrt_s > 0.0) {
    model->gyro.white = raw.gyro_rad_per_sqrt_s;
  }
  if (model->accel.white == unstated.accel.white && raw.accel_mps_per_sqrt_s > 0.0) {
    model->accel.white = raw.accel_mps_per_sqrt_s;
  }
}

/// Makes the first adjustment, with larger sizes than those of the start if the sensors contradict
/// each other with these. Throws the first exception if they still do.
void StartRounds(NoiseRounds* rounds, std::vector<ScaledSizes>* all) {
  std::optional<SensorsContradict> first;
  for (int doublings = 0; doublings <= kMostDoublings; ++doublings) {
    try {
      return rounds->Start();
    } catch (const SensorsContradict& e) {
      if (!first) first.emplace(e);
      for (ScaledSizes& sizes : *all) sizes.Double();
    }
  }
  throw SensorsContradict(*first);
}

/// Updates all sizes. Returns the largest relative change.
double UpdateSizes(const NoiseRounds& rounds, std::vector<ScaledSizes>* all) {
  const std::map<std::string, Misfit> misfits = rounds.Misfits();
  double change = 0.0;
  for (ScaledSizes& sizes : *all) change = std::max(change, sizes.Update(misfits));
  return change;
}

/// Repeats rounds with the same measurements until the sizes stay the same.
void Settle(NoiseRounds* rounds, std::vector<ScaledSizes>* all, NoiseSizes* found) {
  for (int k = 0; k < kMostRounds; ++k) {
    ++found->rounds;
    if (UpdateSizes(*rounds, all) < kSmallestChange) return;
    rounds->Repeat();
  }
}

void KeepAll(std::vector<ScaledSizes>* all) {
  for (ScaledSizes& sizes : *all) sizes.Keep();
}

/// Repeats rounds until the sizes stay the same after another search for outliers. Keeps the sizes
/// with which such a search worked.
void Iterate(NoiseRounds* rounds, std::vector<ScaledSizes>* all, NoiseSizes* found) {
  for (int k = 0; k < kMostScreenings; ++k) {
    Settle(rounds, all, found);
    rounds->Screen();
    KeepAll(all);
    ++found->rounds;
    found->converged = UpdateSizes(*rounds, all) < kSmallestChange;
    if (found->converged) return;
    rounds->Repeat();
  }
}

/// Returns whether nobody stated which part of the GNSS errors is slow.
bool MayHaveSlowErrors(const GnssConfig& config) {
  return config.automatic_process && config.processes.empty();
}

/// Divides the stated errors of the GNSS positions into white and slow ones.
void Divide(const SlowGnssErrors& slow, GnssConfig* config, std::vector<ScaledSizes>* all) {
  config->processes.push_back(slow.process);
  for (ScaledSizes& sizes : *all) {
    if (sizes.Contain(kGnssSigmaScale)) sizes.StartAt(slow.white_share);
  }
}

/// Continues the rounds with slow GNSS errors if the positions show them. If that fails, the sizes
/// before it remain.
void AddSlowErrors(NoiseRounds* rounds, FlightConfig* config, std::vector<ScaledSizes>* all,
                   NoiseSizes* found) {
  if (!MayHaveSlowErrors(*config->gnss)) return;
  const std::optional<SlowGnssErrors> slow = rounds->SlowErrors();
  if (!slow) return;
  const GnssConfig before = *config->gnss;
  const std::vector<ScaledSizes> sizes_before = *all;
  try {
    Divide(*slow, &*config->gnss, all);
    rounds->FreeClock();
    Iterate(rounds, all, found);
    found->slow_gnss = slow->process;
  } catch (const Interrupted&) {
    throw;
  } catch (const Error&) {
    *all = sizes_before;
    for (ScaledSizes& sizes : *all) sizes.GoBack();
    *config->gnss = before;
  }
}

}  // namespace

bool HasUnknownNoise(const FlightConfig& config) {
  return config.imu && config.imu->grade == kUnknownGrade;
}

NoiseSizes EstimateNoise(const AdjustOptions& options, Flight* flight) {
  adjustment_internal::ExpectCommonTime(*flight);  // larger sizes would hide such a clock
  StartAtRawLevel(*flight->imu, &flight->config.imu->model);
  std::vector<ScaledSizes> all = EstimatedSizes(flight);
  UnknownClock clock(&flight->config);
  NoiseRounds rounds(*flight, options, &clock);
  NoiseSizes found;
  StartRounds(&rounds, &all);
  KeepAll(&all);
  try {
    Iterate(&rounds, &all, &found);
    AddSlowErrors(&rounds, &flight->config, &all, &found);
  } catch (const Interrupted&) {
    throw;
  } catch (const Error&) {  // the flight can be adjusted with the sizes before
    found.converged = false;
    for (ScaledSizes& sizes : all) sizes.GoBack();
  }
  for (ScaledSizes& sizes : all) {
    sizes.TakeMean();
    sizes.Append(&found.sizes);
  }
  return found;
}

}  // namespace dn
