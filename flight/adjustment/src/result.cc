#include <dn/adjustment/bias_correlation.h>
#include <dn/adjustment/result.h>
#include <dn/adjustment/trajectory_sigma.h>
#include <dn/axis_names.h>
#include <dn/builder/node_grid.h>
#include <dn/files/scanners.h>
#include <dn/solvers/prediction.h>
#include <dn/solvers/solve.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "open_filter.h"
#include "residual_statistics.h"

namespace dn {
namespace {

Eigen::Vector3d Sigmas(const Eigen::Matrix3d& covariance) {
  return covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
}

TrajectorySigma SigmaAt(const FlightNetwork& network, std::size_t k, const Marginals& marginals) {
  const NodeBlocks& node = network.nodes()[k];
  const NodeAxes axes = FindNodeAxes(network, k);
  const auto sigma = [&](const Eigen::Matrix3d& turn, BlockId block) {
    return Sigmas(turn * marginals.DiagonalBlock(block) * turn.transpose());
  };
  return {node.t_s, sigma(axes.R_enu_m, node.p_mb.id), sigma(axes.R_enu_m, node.v_m.id),
          sigma(axes.rph_from_body, node.q_mb.id)};
}

// Returns the time of the first gap of the inertial data in which a filter loses the attitude.
double FirstLongGap(const ImuData& imu) {
  constexpr double kLongGapS = 3.0;
  const auto gap = std::ranges::find_if(
      imu.gaps, [](const ImuGap& one) { return one.t_end_s - one.t_begin_s > kLongGapS; });
  return gap == imu.gaps.end() ? std::numeric_limits<double>::infinity() : gap->t_begin_s;
}

// Adds the innovations of a forward filter that starts at the adjusted trajectory with a diffuse
// prior. The first ones are left out, until the filter has converged, and those after a long gap.
void AddInnovations(const Adjustment& adjustment, TrajectoryResult* result) {
  constexpr double kSettleS = 30.0;
  const adjustment_internal::DiffusePriorFilter filter(adjustment);
  const FilterRun run = filter.Run(FilterDirection::kForward);
  const double settled_s = filter.times().front() + kSettleS;
  const double lost_s = FirstLongGap(*adjustment.network->flight().imu);
  for (const bool velocity : {false, true}) {
    std::vector<double> t_s;
    std::vector<std::vector<double>> values(3);
    double nis = 0.0;
    for (const Innovation& innovation : run.innovations) {
      if (innovation.velocity != velocity || innovation.t_s < settled_s ||
          innovation.t_s > lost_s) {
        continue;
      }
      t_s.push_back(innovation.t_s);
      for (std::size_t a = 0; a < 3; ++a) {
        values[a].push_back(innovation.normalised[static_cast<Eigen::Index>(a)]);
      }
      nis += innovation.nis / 3.0;
    }
    if (t_s.empty()) continue;
    const std::string sensor = velocity ? "gnss velocity" : "gnss position";
    for (std::size_t a = 0; a < 3; ++a) {
      result->innovations.push_back(DescribeSeries(sensor, kEnu[a], t_s, values[a]));
    }
    (velocity ? result->nis_velocity : result->nis_position) =
        nis / static_cast<double>(t_s.size());
  }
}

// Variance ratio above which, or below whose inverse, the innovations indicate another stochastic
// model. Chance changes the ratio by a tenth in a short flight.
constexpr double kVarianceFactor = 2.0;

void AddInnovationWarnings(TrajectoryResult* result) {
  const auto judge = [&](double nis, const std::string& sensor) {
    if (nis > kVarianceFactor || (nis > 0.0 && nis < 1.0 / kVarianceFactor)) {
      result->warnings.push_back({facts::InnovationSize{sensor, std::sqrt(nis)}});
    }
  };
  judge(result->nis_position, "GNSS positions");
  judge(result->nis_velocity, "GNSS velocities");
}

AdjustmentFigures Figures(const Adjustment& adjustment) {
  const FlightNetwork& network = *adjustment.network;
  const CostSummary summary = EvaluateCost(network.net());
  AdjustmentFigures figures;
  figures.chi2 = 2.0 * summary.cost;
  figures.parameters = summary.parameters;
  figures.redundancy = summary.residuals - summary.parameters;
  figures.sigma0 = figures.redundancy > 0
                       ? std::sqrt(figures.chi2 / static_cast<double>(figures.redundancy))
                       : 0.0;
  figures.iterations = adjustment.iterations;
  figures.converged = adjustment.converged;
  figures.nodes = static_cast<long>(network.nodes().size());
  const auto [first, past] =
      SampleRange(*network.flight().imu, network.trajectory().node_times().front(),
                  network.trajectory().node_times().back());
  figures.imu_epochs = static_cast<long>(past - first);
  figures.gnss_epochs = static_cast<long>(network.gnss().edges().size()) -
                        static_cast<long>(adjustment.gnss_rejected.size());
  figures.outliers = adjustment.outliers;
  figures.correspondences = static_cast<long>(network.pairs().edges().size()) - adjustment.outliers;
  figures.surface_outliers = adjustment.surface_outliers;
  figures.surface_pairs =
      static_cast<long>(network.surfaces().points().size()) - adjustment.surface_outliers;
  return figures;
}

BiasCorrelation Summarise(const std::vector<BiasCorrelationAt>& series,
                          Eigen::Matrix3d BiasCorrelationAt::*triad, std::size_t barycentre) {
  BiasCorrelation result;
  result.at_barycentre = series[barycentre].*triad;
  double sum2 = 0.0;
  for (const BiasCorrelationAt& at : series) {
    result.max_abs = std::max(result.max_abs, (at.*triad).cwiseAbs().maxCoeff());
    sum2 += (at.*triad).squaredNorm();
  }
  result.rms = std::sqrt(sum2 / (9.0 * static_cast<double>(series.size())));
  return result;
}

}  // namespace

Eigen::Matrix3d TotalBiasCovariance(const std::vector<ProcessChain>& chains, double t_s,
                                    const Marginals& marginals) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const ProcessChain& a : chains) {
    for (const ProcessChain& b : chains) {
      const BlockId id_a = a.At(t_s).id;
      const BlockId id_b = b.At(t_s).id;
      if (id_a == id_b) {
        covariance += marginals.DiagonalBlock(id_a);
      } else if (const auto block = marginals.SelectedCovariance(id_a, id_b)) {
        covariance += *block;
      }
    }
  }
  return covariance;
}

Eigen::Matrix3d BoresightResult::correlation() const {
  return ModelledBoresight{angles_rad, covariance_rad2}.correlation();
}

Eigen::Matrix3d ModelledBoresight::correlation() const {
  const Eigen::Vector3d inverse = sigma_rad().cwiseMax(1e-300).cwiseInverse();
  return inverse.asDiagonal() * covariance_rad2 * inverse.asDiagonal();
}

double PairResolution(const Flight& flight, std::size_t scanner) {
  return ScannerAt(flight.config, scanner).sigma_p_m / MeanRange(ScannerPairs(flight, scanner));
}

std::vector<LidarPair> ScannerPairs(const Flight& flight, std::size_t scanner) {
  std::vector<LidarPair> pairs = flight.pairs->pairs;
  const auto k = static_cast<int>(scanner);
  std::erase_if(pairs,
                [k](const LidarPair& pair) { return pair.scanner_i != k && pair.scanner_j != k; });
  return pairs;
}

void AssessLargestSigma(const Eigen::Vector3d& sigma_rad, BoresightResult* result) {
  // An angle with a larger sigma is known no better than by a look at the mount.
  constexpr double kLargestSigmaDeg = 0.5;
  for (int i = 0; i < 3; ++i) {
    if (sigma_rad[i] <= kLargestSigmaDeg * kRadPerDeg) continue;
    result->verdict = Verdict::kNotObservable;
    result->reasons.push_back({facts::SigmaTooLarge{i}});
  }
}

void AssessSeparability(BoresightResult* result) {
  constexpr double kInseparable = 0.999;
  const Eigen::Matrix3d correlation = result->correlation();
  result->verdict = Verdict::kCalibrated;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < i; ++j) {
      if (std::abs(correlation(i, j)) <= kInseparable) continue;
      result->verdict = Verdict::kNotObservable;
      result->reasons.push_back({facts::AnglesInseparable{j, i}});
    }
  }
}

void AssessObservability(const Flight& flight, const Eigen::Vector3d& sigma_rad,
                         const Eigen::Vector3d& attitude_sigma_rad, BoresightResult* result,
                         std::size_t scanner) {
  // If all pairs together are no better than this many times a single one, they do not determine
  // the angle.
  constexpr double kPairResolutions = 10.0;
  constexpr double kAttitudeSigmas = 3.0;
  constexpr std::size_t kFewestPairs = 6;  // two per angle: a wrong pair is then visible
  const double pairs_rad = kPairResolutions * PairResolution(flight, scanner);
  AssessSeparability(result);
  for (int i = 0; i < 3; ++i) {
    if (sigma_rad[i] <= pairs_rad + kAttitudeSigmas * attitude_sigma_rad[i]) continue;
    result->verdict = Verdict::kNotObservable;
    result->reasons.push_back({facts::SigmaAbovePairs{i}});
  }
  const std::size_t pairs = ScannerPairs(flight, scanner).size();
  if (pairs < kFewestPairs) {
    result->verdict = Verdict::kNotObservable;
    result->reasons.push_back({facts::FewPairs{static_cast<long>(pairs)}});
  }
  if (result->verdict == Verdict::kCalibrated) AssessLargestSigma(sigma_rad, result);
}

NodeAxes FindNodeAxes(const FlightNetwork& network, std::size_t node) {
  const LocalFrame& frame = network.flight().frame;
  const MapPose pose = network.trajectory().NodePose(node);
  const Eigen::Vector3d down_b =
      ToNavPoint(pose, frame).q_nb.conjugate() * Eigen::Vector3d::UnitZ();
  return {frame.R_m_enu(pose.p_mb).transpose(), BodyFromEulerRates(down_b).inverse()};
}

std::vector<TrajectorySigma> TrajectorySigmas(const FlightNetwork& network,
                                              const Marginals& marginals) {
  std::vector<TrajectorySigma> sigma;
  for (std::size_t k = 0; k < network.nodes().size(); ++k) {
    sigma.push_back(SigmaAt(network, k, marginals));
  }
  return sigma;
}

TrajectoryResult ExtractTrajectory(const Adjustment& adjustment, const Marginals& marginals) {
  const FlightNetwork& network = *adjustment.network;
  TrajectoryResult result;
  result.sigma = TrajectorySigmas(network, marginals);
  for (std::size_t k = 0; k < network.nodes().size(); ++k) {
    const double t_s = network.nodes()[k].t_s;
    BiasEstimate bias;
    bias.t_s = t_s;
    bias.gyro_radps = network.trajectory().GyroBias(t_s);
    bias.accel_mps2 = network.trajectory().AccelBias(t_s);
    bias.sigma_gyro_radps =
        Sigmas(TotalBiasCovariance(network.trajectory().gyro_bias(), t_s, marginals));
    bias.sigma_accel_mps2 =
        Sigmas(TotalBiasCovariance(network.trajectory().accel_bias(), t_s, marginals));
    result.biases.push_back(bias);
  }
  result.figures = Figures(adjustment);
  result.redundancy = RedundancyNumbers(marginals);
  result.residuals = ResidualStatistics(marginals.linearized(), result.redundancy);
  AddInnovations(adjustment, &result);
  AddInnovationWarnings(&result);
  return result;
}

BoresightResult ExtractBoresight(const Adjustment& adjustment, const Marginals& marginals,
                                 std::size_t scanner) {
  const FlightNetwork& network = *adjustment.network;
  const Block<LeftRotation> boresight = network.calibration().scanners()[scanner].boresight;
  if (network.net().block(boresight.id).held) {
    throw RankDeficient(
        "the boresight is constant at its assumed value: add boresight to estimate in "
        "flight.yaml");
  }
  BoresightResult result;
  const Eigen::Quaterniond q = network.net().Value(boresight);
  result.angles_rad = Log(q);
  result.euler_zyx_rad = RollPitchHeading(q);
  const Marginals::Columns columns = marginals.SolveColumns({boresight.id});
  result.covariance_rad2 = columns.Rows(boresight.id);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(result.covariance_rad2);
  result.condition_number = eigen.eigenvalues()[2] / eigen.eigenvalues()[0];
  const std::size_t barycentre =
      NodeNear(network.trajectory().node_times(), LidarBarycentre(network));
  const auto series = BiasCorrelationOverTime(network, marginals, columns, scanner);
  result.accel_bias = Summarise(series, &BiasCorrelationAt::accel, barycentre);
  result.gyro_bias = Summarise(series, &BiasCorrelationAt::gyro, barycentre);
  AssessObservability(network.flight(), result.sigma_rad(),
                      SigmaAt(network, barycentre, marginals).rph_rad, &result, scanner);
  if (result.verdict == Verdict::kCalibrated && !adjustment.warnings.empty()) {
    result.verdict = Verdict::kAbsorbed;
  }
  result.reasons.insert(result.reasons.end(), adjustment.warnings.begin(),
                        adjustment.warnings.end());
  // The network models the trajectory's errors, so the angles absorb none.
  if (result.reasons.empty()) {
    result.reasons.push_back({facts::TrajectoryEstimated{}});
  }
  return result;
}

std::vector<UnknownEstimate> ExtractUnknowns(const Adjustment& adjustment,
                                             const Marginals& marginals) {
  const FlightNetwork& network = *adjustment.network;
  std::vector<UnknownEstimate> estimates;
  for (const EstimateEntry& entry : network.flight().config.estimate) {
    if (IsBoresight(entry)) continue;
    const BlockId id = network.net().Find(entry.unknown);
    const BlockRecord& record = network.net().block(id);
    const Eigen::VectorXd assumed = AssumedValue(network.flight(), entry.unknown);
    const Eigen::VectorXd sigma = marginals.Covariance(id).diagonal().cwiseMax(0.0).cwiseSqrt();
    UnknownEstimate estimate{entry.unknown, record.label.unit, {}, {}};
    for (int i = 0; i < record.kind.stored_size; ++i) {
      estimate.value.push_back((record.value[static_cast<std::size_t>(i)] - assumed[i]) *
                               record.label.per_si);
      estimate.sigma.push_back(sigma[i] * record.label.per_si);
    }
    estimates.push_back(estimate);
  }
  return estimates;
}

}  // namespace dn
