#include <dn/adjustment/words.h>
#include <dn/diagnosis/solution.h>
#include <dn/effects/effect_table.h>
#include <dn/fleet/reduced_flight.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace dn {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kSameMounting = 1e-9;

/// Returns the entries of `estimate` that are effects.
std::vector<EstimateEntry> EstimatedEffects(const FlightConfig& config) {
  std::vector<EstimateEntry> effects = config.estimate;
  std::erase_if(effects, [](const EstimateEntry& entry) { return entry.unknown == "boresight"; });
  return effects;
}

Index CountComponents(EffectId effect) {
  return static_cast<Index>(EffectRow(effect).components.size());
}

ReducedEffect MakeEstimated(const EstimateEntry& entry) {
  ReducedEffect effect{FindEffect(entry.unknown)->id, true, {}, {}};
  const Index count = CountComponents(effect.effect);
  for (Index k = 0; k < count; ++k) effect.components.push_back(k);
  effect.prior_sigma = PriorSigma(entry).value_or(VectorXd::Constant(count, kInfinite));
  return effect;
}

/// Returns the rows of the estimated effect `name` in the unknowns of EffectPosterior, which have
/// the boresight first.
std::vector<Index> FindRows(const UnmodelledEffects& unmodelled, const std::string& name) {
  Index first = 3;
  for (const UnmodelledEffects::UnknownChange& unknown : unmodelled.unknowns) {
    const Index size = unknown.value.size();
    if (unknown.name != name) {
      first += size;
      continue;
    }
    std::vector<Index> rows;
    for (Index k = 0; k < size; ++k) rows.push_back(first + k);
    return rows;
  }
  return {};
}

/// Collects the unknowns of a reduced flight.
class Reduction {
 public:
  Reduction(const Solution& solution, const BoresightResult& boresight)
      : solution_(solution),
        boresight_(boresight),
        check_(solution.model_check()),
        config_(solution.network().flight().config) {
    if (check_.unmodelled) posterior_ = check_.unmodelled->posterior;
  }

  ReducedFlight Run() {
    Describe();
    AddEstimated();
    flight_.ties = ReduceTies(solution_, blocks_, rows_, check_.unmodelled ? &posterior_ : nullptr);
    if (check_.unmodelled) AddEffects();
    return std::move(flight_);
  }

 private:
  void Describe() {
    const FlightNetwork& network = solution_.network();
    flight_.name = config_.name;
    flight_.begin_s = network.nodes().front().t_s;
    flight_.end_s = network.nodes().back().t_s;
    flight_.origin = network.flight().frame.origin();
    flight_.mounting = StatedMounting(config_);
    flight_.verdict = boresight_.verdict;
    flight_.reasons = Words(boresight_.reasons);
    flight_.angles_rad = boresight_.angles_rad;
    flight_.as_modelled = boresight_.as_modelled.value_or(
        ModelledBoresight{boresight_.angles_rad, boresight_.covariance_rad2});
    if (!config_.lidar->boresight_sigma_rad) return;
    flight_.prior_sigma_rad = config_.lidar->boresight_sigma_rad;
    flight_.prior_angles_rad = config_.lidar->mounting.boresight_rad;
  }

  void AddEstimated() {
    blocks_ = {solution_.network().calibration().boresight().id};
    std::vector<double> values{0.0, 0.0, 0.0};
    rows_ = {0, 1, 2};
    const std::vector<UnknownEstimate> estimates = solution_.CheckedUnknowns();
    for (const EstimateEntry& entry : EstimatedEffects(config_)) {
      flight_.effects.push_back(MakeEstimated(entry));
      blocks_.push_back(solution_.network().net().Find(entry.unknown));
      const double to_si = EffectRow(flight_.effects.back().effect).components.front().to_si;
      for (const UnknownEstimate& one : estimates) {
        if (one.name != entry.unknown) continue;
        for (const double value : one.value) values.push_back(value * to_si);
      }
      if (!check_.unmodelled) continue;
      const std::vector<Index> rows = FindRows(*check_.unmodelled, entry.unknown);
      rows_.insert(rows_.end(), rows.begin(), rows.end());
    }
    flight_.mean = VectorXd::Map(values.data(), static_cast<Index>(values.size()));
    flight_.covariance = JointCovariance();
    if (check_.unmodelled) {
      flight_.covariance += posterior_.added(rows_, rows_);
      flight_.covariance.topLeftCorner<3, 3>() += check_.unmodelled->noise_covariance_rad2;
    }
  }

  MatrixXd JointCovariance() const {
    MatrixXd joint = MatrixXd::Zero(flight_.mean.size(), flight_.mean.size());
    Index row = 0;
    for (const BlockId a : blocks_) {
      Index column = 0, height = 0;
      for (const BlockId b : blocks_) {
        const MatrixXd part = solution_.marginals().Covariance(a, b);
        joint.block(row, column, part.rows(), part.cols()) = part;
        column += part.cols();
        height = part.rows();
      }
      row += height;
    }
    return joint;
  }

  void AddEffects() {
    const Index x = flight_.mean.size(), e = posterior_.estimate.size();
    VectorXd mean(x + e);
    mean << flight_.mean, posterior_.estimate;
    const MatrixXd cross = posterior_.cross(rows_, Eigen::all);
    MatrixXd covariance(x + e, x + e);
    covariance << flight_.covariance, cross, cross.transpose(), posterior_.covariance;
    flight_.mean = mean;
    flight_.covariance = covariance;
    for (Index k = 0; k < e; ++k) {
      // The components of an effect are neighbours. Steps at several times have one name.
      if (k == 0 ||
          posterior_.effect[static_cast<std::size_t>(k)] != flight_.effects.back().effect ||
          flight_.effects.back().estimated || StartsAgain(posterior_, k)) {
        const EffectId effect = posterior_.effect[static_cast<std::size_t>(k)];
        flight_.effects.push_back({effect, false, {}, VectorXd(0), FindRemedy(effect)});
      }
      flight_.effects.back().components.push_back(
          posterior_.component[static_cast<std::size_t>(k)]);
      VectorXd& sigma = flight_.effects.back().prior_sigma;
      sigma.conservativeResize(sigma.size() + 1);
      sigma[sigma.size() - 1] = posterior_.prior_sigma[k];
    }
  }

  static bool StartsAgain(const EffectPosterior& posterior, Index k) {
    const auto at = static_cast<std::size_t>(k);
    return posterior.component[at] <= posterior.component[at - 1];
  }

  std::string FindRemedy(EffectId effect) const {
    for (const EffectContribution& part : boresight_.contributions) {
      if (part.effect == EffectName(effect)) return part.remedy;
    }
    return "";
  }

  const Solution& solution_;
  const BoresightResult& boresight_;
  const ModelCheck& check_;
  const FlightConfig& config_;
  EffectPosterior posterior_;
  std::vector<BlockId> blocks_;  // the boresight and the estimated effects
  std::vector<Index> rows_;      // theirs in EffectPosterior
  ReducedFlight flight_;
};

}  // namespace

FlightMounting StatedMounting(const FlightConfig& config) {
  return {config.lidar->mounting.R_bs_nominal,  config.imu->read.R_imu_to_body,
          config.lidar->mounting.lever_arm_b_m, config.lidar->scan_axis_s,
          config.lidar->nadir_axis_s,           config.gnss->lever_arm_b_m};
}

std::string FindDifference(const FlightMounting& a, const FlightMounting& b) {
  const auto differ = [](const auto& one, const auto& other) {
    return (one - other).cwiseAbs().maxCoeff() > kSameMounting;
  };
  if (differ(a.R_bs_nominal, b.R_bs_nominal)) return "lidar.R_sensor_to_body";
  if (differ(a.lidar_lever_arm_b_m, b.lidar_lever_arm_b_m)) return "lidar.lever_arm_m";
  if (differ(a.scan_axis_s, b.scan_axis_s)) return "lidar.scan_axis";
  if (differ(a.nadir_axis_s, b.nadir_axis_s)) return "lidar.nadir_axis";
  if (differ(a.R_imu_to_body, b.R_imu_to_body)) return "imu.R_imu_to_body";
  return "";
}

ReducedFlight ReduceFlight(const Solution& solution, const BoresightResult& boresight) {
  return Reduction(solution, boresight).Run();
}

}  // namespace dn
