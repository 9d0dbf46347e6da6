#include <dn/diagnosis/adapt.h>
#include <dn/diagnosis/gap_output.h>
#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <dn/names.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace dn {
namespace {

using Eigen::VectorXd;

constexpr double kPriorTypicalSizes = 10.0;
constexpr double kPriorEstimates = 3.0;
// flight.yaml rejects smaller sigmas; a process with such a sigma is treated as absent.
constexpr double kLeastSigma = 1e-12;

const EffectSpec& RequireEffect(const std::string& effect) {
  const EffectSpec* spec = FindEffect(effect);
  if (spec == nullptr) throw InvalidInput("there is no effect '" + effect + "'");
  return *spec;
}

/// Returns the section of a sensor. Throws InvalidInput if the flight has none.
template <class Section>
Section& RequireSection(std::optional<Section>& section, const char* name) {
  if (!section) {
    throw InvalidInput(std::string("the effect needs the section '") + name + "' of flight.yaml");
  }
  return *section;
}

BiasProcess GaussMarkov(const VectorXd& si) {
  return {BiasProcess::Type::kGaussMarkov, si[0], si[1]};
}

void AddProcess(const VectorXd& si, SensorNoise* noise) {
  if (si[0] > kLeastSigma) noise->processes.push_back(GaussMarkov(si));
}

void AddGnssProcess(const Flight&, const GapCause&, const VectorXd& si, FlightConfig* config) {
  if (si.head<3>().maxCoeff() <= kLeastSigma) return;
  RequireSection(config->gnss, "gnss").processes.push_back({si.head<3>(), si[3]});
}

void AddGnssMultipath(const Flight&, const GapCause&, const VectorXd& si, FlightConfig* config) {
  if (si.head<3>().maxCoeff() <= kLeastSigma) return;
  RequireSection(config->gnss, "gnss")
      .processes.push_back({si.head<3>(), si[3], GnssErrorGrowth::kBank});
}

void ScaleGnss(const Flight&, const GapCause&, const VectorXd& si, FlightConfig* config) {
  GnssConfig& gnss = RequireSection(config->gnss, "gnss");
  gnss.sigma_scale *= si[0];
  if (gnss.velocity_sigma_scale) *gnss.velocity_sigma_scale *= si[0];
}

void ScaleGyro(const Flight&, const GapCause&, const VectorXd& si, FlightConfig* config) {
  RequireSection(config->imu, "imu").model.gyro.white *= si[0];
}

void ScaleAccel(const Flight&, const GapCause&, const VectorXd& si, FlightConfig* config) {
  RequireSection(config->imu, "imu").model.accel.white *= si[0];
}

void AddGyroProcess(const Flight&, const GapCause&, const VectorXd& si, FlightConfig* config) {
  AddProcess(si, &RequireSection(config->imu, "imu").model.gyro);
}

void AddAccelProcess(const Flight&, const GapCause&, const VectorXd& si, FlightConfig* config) {
  AddProcess(si, &RequireSection(config->imu, "imu").model.accel);
}

void AddVibration(const Flight&, const GapCause& cause, const VectorXd& si, FlightConfig* config) {
  if (!cause.times.window_s) throw InvalidInput("imu_vibration needs a time window (window_s)");
  if (si.maxCoeff() <= kLeastSigma) return;
  const auto& [t0_s, t1_s] = *cause.times.window_s;
  RequireSection(config->imu, "imu").model.vibration.push_back({t0_s, t1_s, si[0], si[1]});
}

void ScalePairs(const Flight&, const GapCause&, const VectorXd& si, FlightConfig* config) {
  RequireSection(config->lidar, "lidar").sigma_p_m *= si[0];
}

void AddRangeNoise(const Flight& flight, const GapCause&, const VectorXd& si,
                   FlightConfig* config) {
  LidarConfig& lidar = RequireSection(config->lidar, "lidar");
  if (!flight.pairs) throw InvalidInput("p2p_range_noise needs the pairs of the flight");
  lidar.sigma_p_m = std::hypot(lidar.sigma_p_m, si[0] * MeanRange(flight.pairs->pairs));
}

void RejectPairs(const Flight&, const GapCause&, const VectorXd&, FlightConfig* config) {
  RobustKind& robust = RequireSection(config->lidar, "lidar").robust;
  if (robust == RobustKind::kNone) robust = RobustKind::kCauchy;
}

void RejectEpochs(const Flight&, const GapCause&, const VectorXd&, FlightConfig* config) {
  RobustKind& robust = RequireSection(config->gnss, "gnss").robust;
  if (robust == RobustKind::kNone) robust = RobustKind::kHuber;
}

/// The key of flight.yaml that models a random effect, and the function that sets it.
struct Statement {
  EffectId effect;
  const char* key;
  void (*put)(const Flight& flight, const GapCause& cause, const VectorXd& si,
              FlightConfig* config);
};

constexpr Statement kStatements[] = {
    {EffectId::kGnssCorrelatedNoise, "gnss.processes", &AddGnssProcess},
    {EffectId::kGnssMultipath, "gnss.processes", &AddGnssMultipath},
    {EffectId::kGnssNoiseScale, "gnss.sigma_scale", &ScaleGnss},
    {EffectId::kGyroNoiseScale, "imu.gyro.white_deg_sqrt_h", &ScaleGyro},
    {EffectId::kAccelNoiseScale, "imu.accel.white_m_s_sqrt_h", &ScaleAccel},
    {EffectId::kGyroBiasProcess, "imu.gyro.processes", &AddGyroProcess},
    {EffectId::kAccelBiasProcess, "imu.accel.processes", &AddAccelProcess},
    {EffectId::kImuVibration, "imu.vibration", &AddVibration},
    {EffectId::kP2pNoiseScale, "lidar.sigma_p_m", &ScalePairs},
    {EffectId::kP2pRangeNoise, "lidar.sigma_p_m", &AddRangeNoise},
    {EffectId::kP2pOutliers, "lidar.robust", &RejectPairs},
    {EffectId::kGnssOutliers, "gnss.robust", &RejectEpochs},
};

const Statement* FindStatement(EffectId effect) {
  const auto* found = std::find_if(std::begin(kStatements), std::end(kStatements),
                                   [&](const Statement& s) { return effect == s.effect; });
  return found == std::end(kStatements) ? nullptr : found;
}

/// Returns a prior sigma so wide that the data determine the estimate, in the unit of the table.
double PriorSigma(const EffectSpec& spec, const VectorXd& estimate) {
  double sigma = 0.0;
  for (const EffectComponent& part : spec.components) {
    sigma = std::max(sigma, kPriorTypicalSizes * part.typical);
  }
  return estimate.size() > 0 && estimate.allFinite()
             ? std::max(sigma, kPriorEstimates * estimate.cwiseAbs().maxCoeff())
             : sigma;
}

void AddToEstimate(const EffectSpec& spec, const GapCause& cause, FlightConfig* config) {
  const auto same = [&](const EstimateEntry& entry) { return entry.unknown == spec.name; };
  if (std::any_of(config->estimate.begin(), config->estimate.end(), same)) return;
  EstimateEntry entry{.unknown = spec.name, .times = cause.times};
  if (spec.needs_prior) entry.sigma = {PriorSigma(spec, cause.estimate)};
  config->estimate.push_back(std::move(entry));
}

}  // namespace

std::vector<double> ToFileValue(const GapCause& cause) {
  const EffectSpec& spec = RequireEffect(cause.effect);
  std::vector<double> value(cause.estimate.begin(), cause.estimate.end());
  for (std::size_t i = 0; i < std::min(value.size(), spec.components.size()); ++i) {
    const EffectComponent& part = spec.components[i];
    value[i] = std::clamp(value[i], part.lowest, part.highest);
  }
  if (const auto fault = ValueFault(spec, value)) {
    throw InvalidInput("the estimate of " + cause.effect + ": " + *fault);
  }
  return value;
}

std::vector<GapCause> VerdictCauses(const GapDiagnosis& diagnosis) {
  std::vector<GapCause> named;
  for (const std::string& effect : diagnosis.verdict.effects) {
    for (const GapCause& cause : diagnosis.causes) {
      if (cause.effect == effect) named.push_back(cause);
    }
  }
  return named;
}

std::string AdaptedKey(const std::string& effect) {
  const EffectSpec& spec = RequireEffect(effect);
  if (spec.fixed()) return "estimate";
  const Statement* statement = FindStatement(spec.id);
  return statement != nullptr ? statement->key : "";
}

FlightConfig Adapted(const Flight& flight, const std::vector<GapCause>& causes) {
  FlightConfig config = flight.config;
  for (const GapCause& cause : causes) {
    const EffectSpec& spec = RequireEffect(cause.effect);
    if (spec.fixed()) {
      AddToEstimate(spec, cause, &config);
    } else if (const Statement* statement = FindStatement(spec.id)) {
      statement->put(flight, cause, ValueInSi(spec, ToFileValue(cause)), &config);
    }
  }
  return config;
}

FlightConfig Adapted(const Flight& flight, const GapDiagnosis& diagnosis) {
  std::vector<GapCause> causes = VerdictCauses(diagnosis);
  for (const GapHeavyTails& tails : diagnosis.verdict.heavy_tails) {
    for (const GapCause& cause : diagnosis.causes) {
      if (HasName(tails.replaced, cause.effect)) causes.push_back(cause);
    }
  }
  FlightConfig config = Adapted(flight, causes);
  config.unexplained = UnexplainedWords(diagnosis);
  return config;
}

}  // namespace dn
