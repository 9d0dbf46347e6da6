#include <dn/adjustment/words.h>
#include <dn/diagnosis/solution.h>
#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <dn/montecarlo/flight_record.h>
#include <dn/rotation.h>
#include <dn/sim/draw_effects.h>
#include <dn/stopwatch.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace dn {
namespace {

/// The truth of a simulated flight at the epochs of its network.
class Truth {
 public:
  Truth(const SimulatedFlight& simulated, const FlightNetwork& network)
      : simulated_(simulated), network_(network) {}

  MapPose Pose(double t_s) const { return simulated_.truth->Pose(t_s); }

  // The network has one bias per interval, so its true value is the mean over the samples in the
  // interval.
  Eigen::Vector3d Bias(const std::vector<ProcessChain>& chains,
                       const std::vector<Eigen::Vector3d>& samples, double t_s) const {
    double begin_s = network_.trajectory().node_times().front(),
           end_s = network_.trajectory().node_times().back();
    for (const ProcessChain& chain : chains) {
      const auto next =
          std::upper_bound(chain.t_begin_s.begin(), chain.t_begin_s.end(), t_s + 1e-9);
      begin_s = std::max(begin_s, *(next - 1));
      if (next != chain.t_begin_s.end()) end_s = std::min(end_s, *next);
    }
    const auto [first, past] = SampleRange(*simulated_.flight.imu, begin_s, end_s);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t k = first; k < past; ++k) sum += samples[k];
    return sum / static_cast<double>(past - first);
  }

 private:
  const SimulatedFlight& simulated_;
  const FlightNetwork& network_;
};

void SetErrors(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance,
               std::size_t quantity, EpochErrors* out) {
  if (covariance.isZero(0.0)) {  // not estimated
    out->nees[quantity] = std::numeric_limits<double>::quiet_NaN();
    out->sigmas[quantity].setConstant(std::numeric_limits<double>::quiet_NaN());
    return;
  }
  out->nees[quantity] = error.dot(covariance.ldlt().solve(error));
  out->sigmas[quantity] = error.cwiseQuotient(covariance.diagonal().cwiseSqrt());
}

/// Pose and total biases at a node with their covariances: map axes, attitude about the body axes.
struct NodeEstimate {
  MapPose pose;
  Eigen::Vector3d gyro_bias_radps, accel_bias_mps2;
  Eigen::Matrix3d C_p, C_v, C_q, C_gyro, C_accel;
};

NodeEstimate EstimateAt(const FlightNetwork& network, std::size_t k, const Marginals& marginals) {
  const TrajectoryGraph& trajectory = network.trajectory();
  const NodeBlocks& node = network.nodes()[k];
  return {trajectory.NodePose(k),
          trajectory.GyroBias(node.t_s),
          trajectory.AccelBias(node.t_s),
          marginals.DiagonalBlock(node.p_mb.id),
          marginals.DiagonalBlock(node.v_m.id),
          marginals.DiagonalBlock(node.q_mb.id),
          TotalBiasCovariance(trajectory.gyro_bias(), node.t_s, marginals),
          TotalBiasCovariance(trajectory.accel_bias(), node.t_s, marginals)};
}

/// Takes the change by unmodelled effects into an estimate.
void AddChange(const NodeChange& change, NodeEstimate* estimate) {
  change.MovePose(&estimate->pose);
  estimate->C_p += change.position_covariance_m2;
  estimate->C_v += change.velocity_covariance;
  const auto attitude = change.pose_root.bottomRows<3>();
  estimate->C_q += attitude * attitude.transpose();
  estimate->gyro_bias_radps += change.gyro_bias_radps;
  estimate->accel_bias_mps2 += change.accel_bias_mps2;
  estimate->C_gyro += change.gyro_bias_covariance;
  estimate->C_accel += change.accel_bias_covariance;
}

EpochErrors ErrorsAt(const SimulatedFlight& simulated, const FlightNetwork& network, std::size_t k,
                     const NodeEstimate& estimate) {
  const Truth truth(simulated, network);
  const NodeBlocks& node = network.nodes()[k];
  const MapPose pose = truth.Pose(node.t_s);
  EpochErrors errors;
  errors.t_s = node.t_s - network.nodes().front().t_s;
  SetErrors(estimate.pose.p_mb - pose.p_mb, estimate.C_p, 0, &errors);
  SetErrors(estimate.pose.v_m - pose.v_m, estimate.C_v, 1, &errors);
  SetErrors(Log(Eigen::Quaterniond(pose.q_mb.conjugate() * estimate.pose.q_mb)), estimate.C_q, 2,
            &errors);
  const TrajectoryGraph& trajectory = network.trajectory();
  SetErrors(estimate.gyro_bias_radps -
                truth.Bias(trajectory.gyro_bias(), simulated.gyro_bias_radps, node.t_s),
            estimate.C_gyro, 3, &errors);
  SetErrors(estimate.accel_bias_mps2 -
                truth.Bias(trajectory.accel_bias(), simulated.accel_bias_mps2, node.t_s),
            estimate.C_accel, 4, &errors);
  return errors;
}

void AddTrajectoryRms(const SimulatedFlight& simulated, const FlightNetwork& network,
                      FlightRecord* record) {
  Eigen::Vector3d p2 = Eigen::Vector3d::Zero(), v2 = p2, rph2 = p2;
  const LocalFrame& frame = network.flight().frame;
  for (std::size_t k = 0; k < network.nodes().size(); ++k) {
    const MapPose estimate = network.trajectory().NodePose(k);
    const MapPose truth = simulated.truth->Pose(estimate.t_s);
    p2 += (estimate.p_mb - truth.p_mb).cwiseAbs2();
    v2 += (estimate.v_m - truth.v_m).cwiseAbs2();
    const Eigen::Vector3d difference = RollPitchHeading(ToNavPoint(estimate, frame).q_nb) -
                                       RollPitchHeading(ToNavPoint(truth, frame).q_nb);
    for (int i = 0; i < 3; ++i) rph2[i] += std::pow(std::remainder(difference[i], 2.0 * M_PI), 2);
  }
  const auto n = static_cast<double>(network.nodes().size());
  record->position_rms_m = (p2 / n).cwiseSqrt();
  record->velocity_rms_mps = (v2 / n).cwiseSqrt();
  record->attitude_rms_rad = (rph2 / n).cwiseSqrt();
}

/// `unmodelled`: null for the pure model.
void AddErrors(const SimulatedFlight& simulated, const Solution& solution,
               const UnmodelledEffects* unmodelled, double epoch_spacing_s, FlightRecord* record) {
  const FlightNetwork& network = solution.network();
  double next_s = 0.0;
  for (std::size_t k = 0; k < network.nodes().size(); ++k) {
    if (network.nodes()[k].t_s < network.nodes().front().t_s + next_s - 1e-6) continue;
    NodeEstimate estimate = EstimateAt(network, k, solution.marginals());
    if (unmodelled != nullptr) AddChange(unmodelled->nodes[k], &estimate);
    record->epochs.push_back(ErrorsAt(simulated, network, k, estimate));
    next_s += epoch_spacing_s;
  }
  AddTrajectoryRms(simulated, network, record);
  if (!record->with_pairs) return;
  Eigen::Quaterniond q = network.net().Value(network.calibration().boresight());
  record->boresight_covariance_rad2 =
      solution.marginals().Covariance(network.calibration().boresight());
  if (unmodelled != nullptr) {
    q = Exp(unmodelled->boresight_rad) * q;
    record->boresight_covariance_rad2 += unmodelled->covariance_rad2;
  }
  record->boresight_error_rad =
      Log(Eigen::Quaterniond(q * Exp(simulated.boresight_rad).conjugate()));
}

}  // namespace

double FlightRecord::BoresightNees() const {
  return boresight_error_rad.dot(boresight_covariance_rad2.ldlt().solve(boresight_error_rad));
}

FlightRecord RunFlight(const Scenario& scenario, std::uint64_t seed,
                       const FlightRecordOptions& options) {
  const Stopwatch watch;
  SimulateOptions simulate;
  simulate.seed = seed;
  simulate.progress = [&](const std::string&, double) {
    if (options.interrupted && options.interrupted()) throw dn::Interrupted();
  };
  const SimulatedFlight simulated = Simulate(
      options.unmodelled ? WithDrawnEffects(scenario, *options.unmodelled, seed) : scenario,
      simulate);
  FlightRecord record;
  record.seed = seed;
  record.with_pairs = options.with_pairs;
  try {
    AdjustOptions adjust;
    adjust.with_pairs = options.with_pairs;
    adjust.interrupted = options.interrupted;
    const Solution solution(simulated.flight, adjust);
    const TrajectoryResult& trajectory = solution.trajectory();
    record.chi2 = trajectory.figures.chi2;
    record.redundancy = trajectory.figures.redundancy;
    record.outliers = solution.adjustment().outliers;
    const ModelCheck& check = solution.model_check();
    const bool drawn = options.unmodelled.has_value() && check.unmodelled.has_value();
    if (drawn) record.chi2 *= std::pow(check.sigma0_with_effects / trajectory.figures.sigma0, 2);
    if (check.contradicted()) record.contradiction = Words(check.findings.front());
    record.check_p_value = check.p_value;
    record.residuals = trajectory.residuals;
    record.innovations = trajectory.innovations;
    AddErrors(simulated, solution, drawn ? &*check.unmodelled : nullptr, options.epoch_spacing_s,
              &record);
  } catch (const dn::Interrupted&) {
    throw;
  } catch (const std::exception& error) {
    record.failure = error.what();
  }
  record.time_s = watch.seconds();
  return record;
}

}  // namespace dn
