#include "simulated_replicates.h"

#include <dn/diagnosis/solution.h>
#include <dn/effects/effect_table.h>
#include <dn/interrupted.h>
#include <dn/parallel.h>
#include <dn/sim/random.h>
#include <dn/sim/simulate.h>
#include <dn/solvers/prediction.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "evidence_adjustment.h"

namespace dn::diagnosis_internal {
namespace {

constexpr std::size_t kMinReplicates = 3;
constexpr Eigen::Index kMostConspicuous = 20;
constexpr std::size_t kMostLinear = 100;  // number of linear replicates in the energy distance
constexpr int kPermutations = 999;
// Relative tolerance of the change caused by an effect in a replay, whose pairs lie
// elsewhere on ground of another shape.
constexpr double kOtherGround = 0.25;

bool HasOutliers(const Scenario& scenario) {
  const auto& effects = scenario.effects;
  return std::any_of(effects.begin(), effects.end(), [](const Effect& effect) {
    return effect.name == EffectRow(EffectId::kP2pOutliers).name;
  });
}

NamedStatistics ComputeStatistics(const Flight& flight, PairOutliers outliers,
                                  const std::function<bool()>& interrupted) {
  AdjustOptions options;
  options.with_pairs = flight.pairs.has_value();
  options.interrupted = interrupted;
  options.final_step_sigmas = 0.1;  // moves the residuals by far less than their noise
  const Solution solution(std::move(AdjustForEvidence(flight, options, outliers).adjustment));
  const Locations locations(solution.network(), solution.linearized(),
                            RedundancyNumbers(solution.marginals()));
  return Comparable(locations.statistics(), locations.Evaluate(solution.linearized().residual()));
}

std::vector<std::string> CommonNames(const std::vector<NamedStatistics>& of,
                                     const NamedStatistics& and_of) {
  std::vector<std::string> names;
  for (const auto& [name, value] : and_of) {
    const bool in_all = std::all_of(of.begin(), of.end(),
                                    [&, n = name](const auto& one) { return one.count(n) > 0; });
    if (in_all) names.push_back(name);
  }
  return names;
}

/// Returns the deviations of the values from the mean of the linear replicates, divided by the
/// standard deviation of the replicates.
Eigen::VectorXd Standardised(const NamedStatistics& values, const std::vector<std::string>& names,
                             const LinearReplicates& linear) {
  Eigen::VectorXd z(static_cast<Eigen::Index>(names.size()));
  for (std::size_t k = 0; k < names.size(); ++k) {
    z[static_cast<Eigen::Index>(k)] =
        (values.at(names[k]) - linear.mean.at(names[k])) / linear.sigma.at(names[k]);
  }
  return z;
}

/// Returns `count` different numbers of [0, n) in random order.
std::vector<std::size_t> Drawn(std::size_t n, std::size_t count, Random* random) {
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t k = 0; k < count; ++k) {
    const auto at = k + static_cast<std::size_t>(random->Uniform() * static_cast<double>(n - k));
    std::swap(order[k], order[std::min(at, n - 1)]);
  }
  order.resize(count);
  return order;
}

/// Returns the distances between all points.
Eigen::MatrixXd Distances(const std::vector<Eigen::VectorXd>& points) {
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      D(i, j) = D(j, i) =
          (points[static_cast<std::size_t>(i)] - points[static_cast<std::size_t>(j)]).norm();
    }
  }
  return D;
}

/// Returns the energy distance 2 E|X - Y| - E|X - X'| - E|Y - Y'| of some points X and all others
/// Y.
double EnergyDistance(const Eigen::MatrixXd& D, const std::vector<std::size_t>& of) {
  const auto total = static_cast<double>(D.rows()), n = static_cast<double>(of.size());
  Eigen::VectorXd inside = Eigen::VectorXd::Zero(D.rows());
  for (const std::size_t k : of) inside[static_cast<Eigen::Index>(k)] = 1.0;
  const Eigen::VectorXd outside = Eigen::VectorXd::Ones(D.rows()) - inside;
  const double m = total - n;
  const Eigen::VectorXd to_inside = D * inside;
  return 2.0 * outside.dot(to_inside) / (n * m) - inside.dot(to_inside) / (n * n) -
         outside.dot(D * outside) / (m * m);
}

/// Returns the statistics in which a flight differs most from the assumed model.
Eigen::VectorXi MostConspicuous(const Eigen::VectorXd& z) {
  Eigen::VectorXi order = Eigen::VectorXi::LinSpaced(z.size(), 0, static_cast<int>(z.size()) - 1);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return std::abs(z[a]) > std::abs(z[b]); });
  return order.head(std::min(kMostConspicuous, order.size()));
}

/// Returns the shrunk correlation matrix of the first half of the linear replicates.
Eigen::MatrixXd ShrunkCorrelation(const std::vector<Eigen::VectorXd>& z) {
  const Eigen::Index n = z.front().size();
  const std::size_t half = z.size() / 2;
  Eigen::MatrixXd C = kShrunk * Eigen::MatrixXd::Identity(n, n);
  for (std::size_t k = 0; k < half; ++k) {
    C += (1.0 - kShrunk) / static_cast<double>(half) * z[k] * z[k].transpose();
  }
  return C;
}

/// Returns the squared Mahalanobis distance of a flight from the mean of its replicates. It uses
/// the statistics in which the flight differs most from the model.
double DeviationSize(const Eigen::VectorXd& flight, const Eigen::VectorXd& off,
                     const Eigen::MatrixXd& correlation) {
  const Eigen::VectorXi most = MostConspicuous(flight);
  const Eigen::LLT<Eigen::MatrixXd> llt(correlation(most, most));
  return llt.matrixL().solve(off(most)).squaredNorm();
}

}  // namespace

void CopyAssumptions(const FlightConfig& of, FlightConfig* config) {
  config->estimate = of.estimate;
  config->network = of.network;
  config->gnss->robust = of.gnss->robust;
  config->imu->model.vibration = of.imu->model.vibration;
  if (!config->lidar || !of.lidar) return;
  config->lidar->mounting.boresight_rad = of.lidar->mounting.boresight_rad;
  config->lidar->boresight_sigma_rad = of.lidar->boresight_sigma_rad;
  config->lidar->robust = of.lidar->robust;
}

NamedStatistics Comparable(const std::vector<LocationStatistic>& statistics,
                           const Eigen::VectorXd& values) {
  NamedStatistics named;
  for (std::size_t k = 0; k < statistics.size(); ++k) {
    const std::string& where = statistics[k].location;
    const bool of_strips = where.rfind("strips ", 0) == 0 && where.find(',') == std::string::npos;
    if (where.empty() || of_strips) {
      named[StatisticName(statistics[k])] = values[static_cast<Eigen::Index>(k)];
    }
  }
  return named;
}

std::vector<NamedStatistics> SimulateReplicates(const Flight& flight, const Scenario& scenario,
                                                const Trajectory& replayed,
                                                const SimulatedReplicateOptions& options) {
  const PairOutliers outliers =
      HasOutliers(scenario) ? PairOutliers::kReject : PairOutliers::kNotThere;
  const double node_rate_hz = DiagnosisNodeRateHz(flight);
  std::vector<NamedStatistics> all(static_cast<std::size_t>(options.count));
  ParallelFor(options.count, options.threads, [&](int k) {
    if (options.interrupted && options.interrupted()) throw Interrupted();
    SimulateOptions simulate;
    simulate.seed = MixBits(options.seed + static_cast<std::uint64_t>(k));
    simulate.replay = &replayed;
    Flight replicate = Simulate(scenario, simulate).flight;
    CopyAssumptions(flight.config, &replicate.config);
    replicate.config.network.node_rate_hz = node_rate_hz;
    try {
      all[static_cast<std::size_t>(k)] =
          ComputeStatistics(replicate, outliers, options.interrupted);
    } catch (const NotConverged&) {
      return;
    } catch (const InvalidInput&) {
      return;
    }
  });
  std::erase_if(all, [](const NamedStatistics& one) { return one.empty(); });
  return all;
}

LinearReplicates NameLinearReplicates(const std::vector<LocationStatistic>& statistics,
                                      const ReplicateSet& replicates, const ReplicateTest& test) {
  LinearReplicates linear;
  linear.mean = Comparable(statistics, test.mean);
  linear.sigma = Comparable(statistics, test.sigma);
  for (const ResidualSummary& replicate : replicates.all) {
    linear.all.push_back(Comparable(statistics, replicate.locations));
  }
  return linear;
}

std::optional<double> TestSimulatedAgainstLinear(const std::vector<NamedStatistics>& full,
                                                 const LinearReplicates& linear,
                                                 std::uint64_t seed) {
  const std::vector<std::string> names = CommonNames(full, linear.mean);
  if (full.size() < kMinReplicates || names.empty()) return std::nullopt;
  std::vector<Eigen::VectorXd> points;
  for (const NamedStatistics& one : full) points.push_back(Standardised(one, names, linear));
  const std::size_t half = linear.all.size() / 2;
  for (std::size_t k = half; k < std::min(linear.all.size(), half + kMostLinear); ++k) {
    points.push_back(Standardised(linear.all[k], names, linear));
  }
  const Eigen::MatrixXd D = Distances(points);
  std::vector<std::size_t> of_full(full.size());
  std::iota(of_full.begin(), of_full.end(), std::size_t{0});
  const double distance = EnergyDistance(D, of_full);
  Random random(seed, "full against linear twins");
  int as_far = 0;
  for (int k = 0; k < kPermutations; ++k) {
    if (EnergyDistance(D, Drawn(points.size(), full.size(), &random)) >= distance) ++as_far;
  }
  return (1.0 + as_far) / (1.0 + kPermutations);
}

std::optional<double> TestAmongReplicates(const NamedStatistics& flight,
                                          const std::vector<NamedStatistics>& replicates,
                                          const LinearReplicates& linear, std::uint64_t seed) {
  std::vector<NamedStatistics> both = replicates;
  both.push_back(flight);
  const std::vector<std::string> names = CommonNames(both, linear.mean);
  const std::size_t half = linear.all.size() / 2;
  if (replicates.size() < kMinReplicates || names.empty() || half <= replicates.size())
    return std::nullopt;
  std::vector<Eigen::VectorXd> z;
  for (const NamedStatistics& one : linear.all) z.push_back(Standardised(one, names, linear));
  const Eigen::MatrixXd correlation = ShrunkCorrelation(z);
  const Eigen::VectorXd of_flight = Standardised(flight, names, linear);
  Eigen::VectorXd mark(of_flight.size()), off(of_flight.size());
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    const MeanAndSigma of_replicates = *ReplicateMeanAndSigma(replicates, names[k]);
    const double unit = linear.sigma.at(names[k]);
    mark[at] = (of_replicates.mean - linear.mean.at(names[k])) / unit;
    const double scatter = std::max(of_replicates.sigma / unit, 1.0);
    off[at] = (of_flight[at] - mark[at]) / std::hypot(scatter, kOtherGround * mark[at]);
  }
  const double size = DeviationSize(of_flight, off, correlation);
  Random random(seed, "flight among its twins");
  int as_far = 0;
  for (int draw = 0; draw < kPermutations; ++draw) {
    const std::vector<std::size_t> some = Drawn(z.size() - half, 1 + replicates.size(), &random);
    Eigen::VectorXd replicate_off = z[half + some[0]];
    for (std::size_t k = 1; k < some.size(); ++k) {
      replicate_off -= z[half + some[k]] / static_cast<double>(replicates.size());
    }
    if (DeviationSize(mark + z[half + some[0]], replicate_off, correlation) >= size) ++as_far;
  }
  return (1.0 + as_far) / (1.0 + kPermutations);
}

std::optional<MeanAndSigma> ReplicateMeanAndSigma(const std::vector<NamedStatistics>& replicates,
                                                  const std::string& name) {
  std::vector<double> values;
  for (const NamedStatistics& replicate : replicates) {
    const auto at = replicate.find(name);
    if (at != replicate.end()) values.push_back(at->second);
  }
  if (values.size() < 2) return std::nullopt;
  MeanAndSigma out;
  for (const double value : values) out.mean += value / static_cast<double>(values.size());
  for (const double value : values) {
    out.sigma += (value - out.mean) * (value - out.mean) / static_cast<double>(values.size() - 1);
  }
  out.sigma = std::sqrt(out.sigma);
  return out;
}

}  // namespace dn::diagnosis_internal
