#include "variances.h"

#include <dn/distributions.h>
#include <dn/effects/effect_table.h>
#include <dn/imu/noise_check.h>
#include <dn/size_prior.h>
#include <dn/solvers/restricted_likelihood.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "inertial_noise.h"
#include "likelihood_peak.h"

namespace dn::diagnosis_internal {
namespace {

// Below this likelihood ratio the quadratic approximation is used.
constexpr double kWorthALookNats = 2.0;
// Largest distance of the most probable size from that of one Fisher step, in ln(size).
constexpr double kMostLogStep = 5.0;
// Sizes within this fraction of the stated one count as no effect.
constexpr double kNoEffect = 0.02;
// Number of sizes of an inertial noise for which the network is evaluated.
constexpr int kInertialSizes = 8;
// Evidence of the residuals for an inertial noise from which on raw data add to it: the 5 % level
// of a one-sided test.
constexpr double kShownNats = 1.35;
// Spread of the logarithms of the levels of axes and octaves: of a sensor, and of motion.
constexpr double kSensorSpread = 0.03, kMotionSpread = 1.0;

/// A variance component: rows of some channels, and the relative growth of their variances.
struct Component {
  EffectId effect;
  Eigen::VectorXd share;
  /// Size of the effect as a function of theta of VarianceLikelihood, and the inverse.
  std::function<double(double)> size_of_theta, theta_of_size;
  double typical_log_spread = 0.4;  ///< typical spread of ln(size)
  double centre = 1.0;              ///< centre of the prior of the size
  bool at_least_stated = false;     ///< the size cannot be below the stated one
};

/// Returns the evidence of a logarithm of two levels for a sensor, relative to motion.
double EqualLevels(double log_ratio, double sigma) {
  const auto log_density = [&](double spread) {
    const double total = std::hypot(spread, sigma);
    return -0.5 * std::pow(log_ratio / total, 2) - std::log(total);
  };
  return log_density(kSensorSpread) - log_density(kMotionSpread);
}

/// Returns the evidence that a noise is that of a sensor and not motion, nats: its axes and octaves
/// have equal levels.
double WhiteEvidence(const NoiseLevel& level) {
  const auto& axes = level.axis_ratio;
  const double sigma = std::sqrt(3.0) * level.sigma / level.ratio;
  const double middle = std::log(axes[0] * axes[1]) / 2.0;
  return EqualLevels(std::log(axes[0] / axes[1]), std::sqrt(2.0) * sigma) +
         EqualLevels(std::log(axes[2]) - middle, std::sqrt(1.5) * sigma) +
         EqualLevels(level.tilt, level.tilt_sigma);
}

/// Returns the log prior density of ln(size): normal distributions about ln(centre) of several
/// spreads.
double LogPrior(const Component& component, double size) {
  double sum = 0.0;
  for (std::size_t g = 0; g < SizePrior::kSizes; ++g) {
    const double spread = SizePrior::kTimesTypical[g] * component.typical_log_spread;
    const double off = std::log(size / component.centre) / spread;
    sum += SizePrior::kProbability[g] * std::exp(-0.5 * off * off) / spread;
  }
  return std::log(std::max(sum, 1e-300)) - 0.5 * std::log(2.0 * std::numbers::pi);
}

class Variances {
 public:
  Variances(const FlightNetwork& network, const Marginals& marginals, const LibraryOptions& options)
      : network_(network),
        marginals_(marginals),
        linearized_(marginals.linearized()),
        options_(options) {}

  VarianceScreen Run() {
    MakeComponents();
    ScreenComponents();
    ScreenInertial();
    SortByEvidence(&out_.effects);
    return std::move(out_);
  }

 private:
  Component Scale(EffectId effect, const Eigen::VectorXd& share) const {
    return {effect,
            share,
            [](double theta) { return std::sqrt(1.0 + theta); },
            [](double ratio) { return ratio * ratio - 1.0; },
            std::log(EffectRow(effect).components[0].typical),
            1.0,
            false};
  }

  void MakeComponents() {
    const Eigen::Index n = linearized_.rows();
    Eigen::VectorXd gnss = Eigen::VectorXd::Zero(n), pairs = gnss, ranges = gnss;
    for (const GnssEdge& edge : network_.gnss().edges()) {
      for (const FactorId id : {edge.position, edge.velocity}) {
        if (id < 0) continue;
        if (const auto rows = linearized_.FindRows(id))
          gnss.segment(rows->first, rows->count).setOnes();
      }
    }
    for (const PairEdge& edge : network_.pairs().edges()) {
      const auto rows = linearized_.FindRows(edge.id);
      if (!rows) continue;
      const double sigma_m = network_.flight().config.lidar->sigma_p_m;
      const double range_m = 0.5 * (edge.pair.u_i_s.norm() + edge.pair.u_j_s.norm());
      pairs.segment(rows->first, rows->count).setOnes();
      ranges.segment(rows->first, rows->count).setConstant(range_m * range_m / (sigma_m * sigma_m));
    }
    const auto add = [&](Component component) {
      if (component.share.maxCoeff() > 0.0 && options_.Wanted(component.effect)) {
        components_.push_back(std::move(component));
      }
    };
    add(Scale(EffectId::kGnssNoiseScale, gnss));
    add(Scale(EffectId::kP2pNoiseScale, pairs));
    add({EffectId::kP2pRangeNoise, ranges,
         [](double theta) { return std::sqrt(std::max(0.0, theta)); },
         [](double sigma_per_m) { return sigma_per_m * sigma_per_m; }, 1.0,
         EffectRow(EffectId::kP2pRangeNoise).components[0].typical_si(), true});
  }

  void ScreenComponents() {
    if (components_.empty()) return;
    Eigen::MatrixXd shares(linearized_.rows(), static_cast<Eigen::Index>(components_.size()));
    for (std::size_t k = 0; k < components_.size(); ++k) {
      shares.col(static_cast<Eigen::Index>(k)) = components_[k].share;
    }
    const VarianceScore score = ScoreVariances(marginals_, shares);
    for (std::size_t k = 0; k < components_.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      const double information = score.information(at, at);
      if (!(information > 0.0)) continue;
      out_.effects.push_back(
          Judge(components_[k], score.u[at] / information, 1.0 / std::sqrt(information)));
    }
  }

  /// Evaluates a component from one Fisher step `theta` with its sigma, and by its profile
  /// likelihood if the step is significant.
  HypothesisEvidence Judge(const Component& component, double theta, double sigma_theta) const {
    const auto evidence = [&](double log_evidence, double size, double sigma) {
      return MakeEvidence(component.effect, log_evidence, Eigen::VectorXd::Constant(1, size),
                          Eigen::VectorXd::Constant(1, sigma));
    };
    const double quadratic = 0.5 * theta * theta / (sigma_theta * sigma_theta);
    const bool impossible = component.at_least_stated && theta <= 0.0;
    if (impossible || quadratic < kWorthALookNats) {
      return evidence(
          -std::log1p(1.0 / std::max(1e-6, sigma_theta)) * 0.5,
          component.size_of_theta(std::max(theta, -0.9)),
          component.at_least_stated ? component.size_of_theta(sigma_theta) : 0.5 * sigma_theta);
    }
    const LikelihoodPeak peak = FindSizePeak(component, theta, sigma_theta);
    const double size = std::exp(peak.log_size);
    const bool matters = component.at_least_stated || std::abs(size - 1.0) >= kNoEffect;
    const double log_evidence = peak.value + LogPrior(component, size) +
                                0.5 * std::log(2.0 * std::numbers::pi) + std::log(peak.width);
    HypothesisEvidence effect = evidence(matters ? log_evidence : 0.0, size, size * peak.width);
    effect.p_value = ChiSquareTail(2.0 * std::max(0.0, peak.value), 1.0);
    return effect;
  }

  /// Returns the maximum of the likelihood over ln(size), relative to the stated size.
  LikelihoodPeak FindSizePeak(const Component& component, double theta, double sigma_theta) const {
    VarianceLikelihood likelihood(linearized_, component.share, options_.threads);
    const auto of_log_sizes = [&](const std::vector<double>& log_sizes) {
      std::vector<double> thetas{0.0};
      for (const double log_size : log_sizes) {
        thetas.push_back(component.theta_of_size(std::exp(log_size)));
      }
      std::vector<double> l = likelihood.At(thetas);
      for (std::size_t k = 1; k < l.size(); ++k) l[k] -= l[0];
      l.erase(l.begin());
      return l;
    };
    const double start = std::log(component.size_of_theta(std::max(theta, -0.7)));
    const double step = std::clamp(sigma_theta / (1.0 + std::abs(theta)), 1e-3, 0.3);
    const auto peak = FindPeak(of_log_sizes, {start - step, start, start + step},
                               start - kMostLogStep, start + kMostLogStep);
    return peak.value_or(LikelihoodPeak{start, of_log_sizes({start})[0], step});
  }

  void ScreenInertial() {
    const Flight& flight = network_.flight();
    if (!flight.imu || !flight.config.imu) return;
    HighBandOptions high_band;
    high_band.sampling = flight.config.imu->read.sampling;
    const ImuModel& model = flight.config.imu->model;
    const NoiseCheck check = CheckNoise(MeasureHighBand(*flight.imu, model, high_band));
    const NoiseCauses noise = NoiseCauseEvidence(check.evidence);
    const double not_white = std::max(noise.not_white[kGyroTriad], noise.not_white[kAccelTriad]);
    out_.raw_only_nats = std::max(0.0, not_white);
    AddScale(EffectId::kGyroNoiseScale, check, noise, kGyroTriad);
    AddScale(EffectId::kAccelNoiseScale, check, noise, kAccelTriad);
    const bool beside = check.evidence.window_and_scale > check.evidence.window;
    const auto& window = beside ? check.window_with_scale : check.window;
    if (window) AddVibration(*window, {check.evidence.window, -not_white});
  }

  /// Evidence of the raw data for an inertial noise, nats.
  struct RawEvidence {
    double against_stated = 0.0;
    double against_motion = 0.0;
  };

  /// Returns the evidence that the raw data show more or less noise than stated, white or not.
  static RawEvidence NoiseScaleEvidence(const NoiseCheck& check, const NoiseCauses& noise,
                                        ImuTriad triad) {
    const NoiseEvidence& raw = check.evidence;
    const bool not_white = noise.not_white[triad] > 0.0;
    return {not_white ? std::max({raw.scale[triad], raw.coloured[triad], raw.unsteady[triad]})
                      : raw.scale[triad],
            WhiteEvidence(*check.level[triad])};
  }

  /// Compares a noise of the raw data with the residuals of the network. The raw data also show
  /// motion. Only if the residuals show the noise, do the raw data add that it is not a motion.
  NetworkSupport Support(const RawEvidence& raw, const PreintegrationNoise& part,
                         const std::vector<double>& thetas) const {
    const Eigen::VectorXd share = InertialShare(network_, linearized_, part);
    if (!(share.maxCoeff() > 0.0)) return {};
    NetworkSupport support = FindNetworkSupport(linearized_, share, thetas, options_.threads);
    if (support.of_raw_data && support.log_evidence > kShownNats) {
      support.log_evidence += std::max(0.0, raw.against_motion);
    }
    support.log_evidence = std::min(support.log_evidence, raw.against_stated);
    return support;
  }

  void NoteRawOnly(const RawEvidence& raw, const NetworkSupport& support) {
    out_.raw_only_nats =
        std::max(out_.raw_only_nats, raw.against_stated - std::max(0.0, support.log_evidence));
  }

  void AddVibration(const NoiseWindow& window, const RawEvidence& raw) {
    if (!options_.Wanted(EffectId::kImuVibration)) return;
    double log_evidence = raw.against_stated, part = 1.0;
    if (raw.against_stated > kWorthALookNats) {
      const ImuVibration added{window.t0_s, window.t1_s, window.sigma[kGyroTriad],
                               window.sigma[kAccelTriad]};
      std::vector<double> thetas;
      for (int k = 1; k <= kInertialSizes; ++k) thetas.push_back(std::exp2(k - kInertialSizes));
      const NetworkSupport support = Support(raw, {0.0, 0.0, 0.0, {added}}, thetas);
      NoteRawOnly(raw, support);
      log_evidence = support.log_evidence;
      part = std::sqrt(support.theta);
    }
    const Eigen::Vector2d sigma = part * Eigen::Vector2d(window.sigma[0], window.sigma[1]);
    out_.effects.push_back(
        MakeEvidence(EffectId::kImuVibration, log_evidence, sigma,
                     Eigen::Vector2d(window.sigma_of_sigma[0], window.sigma_of_sigma[1])));
    out_.effects.back().times.window_s = {{window.t0_s, window.t1_s}};
  }

  void AddScale(EffectId id, const NoiseCheck& check, const NoiseCauses& noise, ImuTriad triad) {
    if (!check.level[triad] || !options_.Wanted(id)) return;
    const NoiseLevel& level = *check.level[triad];
    const RawEvidence raw = NoiseScaleEvidence(check, noise, triad);
    double log_evidence = raw.against_stated, ratio = level.ratio, sigma = level.sigma;
    if (raw.against_stated > kWorthALookNats && std::abs(level.ratio - 1.0) >= kNoEffect) {
      const NetworkSupport support = ScaleSupport(raw, level.ratio, triad);
      NoteRawOnly(raw, support);
      log_evidence = support.log_evidence;
      if (!support.of_raw_data) {
        ratio = std::sqrt(1.0 + support.theta);
        sigma = std::abs(std::log(level.ratio)) / kInertialSizes * ratio;
      }
    }
    const bool matters = std::abs(ratio - 1.0) >= kNoEffect;
    out_.effects.push_back(MakeEvidence(id, matters ? log_evidence : std::min(0.0, log_evidence),
                                        Eigen::VectorXd::Constant(1, ratio),
                                        Eigen::VectorXd::Constant(1, sigma)));
  }

  NetworkSupport ScaleSupport(const RawEvidence& raw, double ratio, ImuTriad triad) const {
    const ImuModel& model = network_.flight().config.imu->model;
    PreintegrationNoise part;
    part.position_floor_m = 0.0;
    if (triad == kGyroTriad) part.gyro_white_rad_per_sqrt_s = model.gyro.white;
    if (triad == kAccelTriad) part.accel_white_mps_per_sqrt_s = model.accel.white;
    std::vector<double> thetas;
    for (int k = 1; k <= kInertialSizes; ++k) {
      thetas.push_back(std::pow(ratio, 2.0 * k / kInertialSizes) - 1.0);
    }
    return Support(raw, part, thetas);
  }

  const FlightNetwork& network_;
  const Marginals& marginals_;
  const LinearizedNetwork& linearized_;
  const LibraryOptions& options_;
  std::vector<Component> components_;
  VarianceScreen out_;
};

}  // namespace

VarianceScreen ScreenVariances(const FlightNetwork& network, const Marginals& marginals,
                               const LibraryOptions& options) {
  return Variances(network, marginals, options).Run();
}

}  // namespace dn::diagnosis_internal
