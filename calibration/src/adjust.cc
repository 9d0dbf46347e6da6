#include <dn/calibration/adjust.h>
#include <dn/geo/text_table.h>
#include <dn/imu/strapdown.h>
#include <dn/navigation/gnss_screening.h>
#include <dn/navigation/gnss_steps.h>
#include <dn/navigation/robust_scale.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <optional>
#include <set>

namespace dn {
namespace {

using Clock = std::chrono::steady_clock;

// Largest norm of a whitened 3-vector that belongs to the data: the quantile of chi_3 that leaves
// as much outside as four sigmas of a normal variable do (6.3e-5).
constexpr double kRejectNorm = 4.68;
constexpr double kGnssHuberNorm = 3.0;
constexpr double kPairCauchyNorm = 3.0;
// The damping of Levenberg-Marquardt is relative to the diagonal of the normal matrix; a common
// shift of a whole trajectory is a direction 1e-9 of it and must not be damped away.
constexpr double kTrustRegionRadius = 1e13;
// Relative change of the cost at which a stage has converged: 1e-4 sigma of a cost of 1e4.
constexpr double kCostTolerance = 1e-13;
constexpr double kStripJoinS = 5.0;
constexpr double kStripMarginS = 0.5;
constexpr int kMaxRelinearisations = 4;
constexpr int kMaxScreenings = 20;
constexpr std::size_t kJumpEnds = 12;
constexpr std::size_t kPositionBlock = 1;  // of a GNSS position edge
// A network that contradicts more of its GNSS epochs than this is not a good flight with bad
// epochs.
constexpr double kLargestRejectedShare = 1.0 / 3.0;
// Residuals so many times their stated noise come from something else than noise.
constexpr double kLargestSigma0 = 10.0;
// Bias change (in the units of BiasChange) below which new increments change nothing.
constexpr double kRelinearised = 0.02;

double Seconds(Clock::time_point since) {
  return std::chrono::duration<double>(Clock::now() - since).count();
}

std::vector<double> PairEpochs(const Flight& flight) {
  std::vector<double> t_s;
  for (const LidarPair& pair : flight.pairs->pairs) {
    t_s.push_back(pair.t_i_s);
    t_s.push_back(pair.t_j_s);
  }
  return t_s;
}

std::vector<double> GridOf(const Flight& flight, const TimeInterval& span, bool with_pairs,
                           double rate_hz) {
  NodeGridOptions options;
  options.rate_in_strips_hz = rate_hz;
  options.every_imu_epoch = flight.config.network.inertial == NetworkConfig::Inertial::kRaw;
  std::vector<TimeInterval> dense;
  if (with_pairs) {
    dense = ClusterEpochs(PairEpochs(flight), kStripJoinS);
    for (TimeInterval& interval : dense) {
      interval.t0_s -= kStripMarginS;
      interval.t1_s += kStripMarginS;
    }
  }
  return NodeTimes(*flight.imu, span, GnssTimes(flight, span), dense, options);
}

// Starting states at the nodes from those of the forward filter on its coarser grid.
InitialStates StatesAtNodes(const Flight& flight, const std::vector<double>& node_t_s,
                            const std::vector<FilterState>& coarse) {
  std::vector<double> coarse_t_s;
  for (const FilterState& state : coarse) coarse_t_s.push_back(state.pose.t_s);
  InitialStates initial;
  MapPose last = coarse.front().pose;
  for (const double t_s : node_t_s) {
    const FilterState& before = coarse[NodeBefore(coarse_t_s, t_s + 1e-7)];
    const double reset_t_s = std::max(last.t_s, before.pose.t_s);
    if (before.pose.t_s >= last.t_s) last = before.pose;
    if (t_s - reset_t_s > 1e-7) {
      try {
        last = Propagate(flight.frame, last,
                         Preintegrate(*flight.imu, last.t_s, t_s,
                                      {before.TotalGyroBias(), before.TotalAccelBias()}, {}));
      } catch (const InvalidInput&) {  // a hole in the inertial data: coast
        last.p_mb += (t_s - last.t_s) * last.v_m;
      }
    } else if (t_s < last.t_s - 1e-7) {  // before the first GNSS epoch: coast backwards
      initial.nodes.push_back({t_s, last.q_mb, last.p_mb + (t_s - last.t_s) * last.v_m, last.v_m});
      continue;
    }
    last.t_s = t_s;
    initial.nodes.push_back(last);
  }
  initial.gyro_bias_radps = coarse.back().TotalGyroBias();
  initial.accel_bias_mps2 = coarse.back().TotalAccelBias();
  return initial;
}

std::vector<std::size_t> RejectedGnss(const FlightNetwork& network) {
  std::vector<std::size_t> epochs;
  for (const FlightNetwork::GnssEdge& edge : network.gnss_edges) {
    const bool velocity_out = edge.velocity >= 0 && !network.net.factor(edge.velocity).active;
    if (!network.net.factor(edge.position).active || velocity_out) epochs.push_back(edge.epoch);
  }
  return epochs;
}

Loss RobustLoss(RobustKind kind, double width) {
  switch (kind) {
    case RobustKind::kHuber:
      return {Loss::Type::kHuber, width};
    case RobustKind::kCauchy:
      return {Loss::Type::kCauchy, width};
    case RobustKind::kNone:
      break;
  }
  return {};
}

class Adjuster {
 public:
  Adjuster(const Flight& flight, const AdjustOptions& options)
      : flight_(flight), options_(options) {}

  Adjustment Run() {
    const auto start = Clock::now();
    BuildInertial();
    SolveInsGnss();
    ScreenGnssEpochs();
    if (options_.with_pairs) {
      CheckPairEpochs();
      network().AddPairs(flight_.pairs->pairs);
      if (network().pair_edges.empty()) {
        throw InvalidInput(
            "adjustment: the two epochs of every pair lie between the same two nodes; pairs must "
            "join different strips");
      }
      result_.residual_initial_m = MeanPairDifference();
      StartBoresight();
      SolvePairsRobustly();
      RejectPairs();
    }
    if (options_.customise) options_.customise(network());
    SolveFinally();
    if (options_.with_pairs) result_.residual_final_m = MeanPairDifference();
    result_.time_s = Seconds(start);
    return std::move(result_);
  }

 private:
  FlightNetwork& network() { return *result_.network; }
  const FlightNetwork& network_const() const { return *result_.network; }

  void Announce(const std::string& stage) const {
    if (options_.progress) options_.progress(stage, 0);
    if (options_.interrupted && options_.interrupted()) throw Interrupted();
  }

  void CheckPairEpochs() const {
    const std::vector<LidarPair>& pairs = flight_.pairs->pairs;
    const bool one = std::all_of(pairs.begin(), pairs.end(), [&](const LidarPair& pair) {
      return pair.t_i_s == pairs[0].t_i_s && pair.t_j_s == pairs[0].t_j_s;
    });
    if (!one) return;
    throw InvalidInput("adjustment: all " + std::to_string(pairs.size()) +
                       " pairs join the same two epochs, " + FormatDouble(pairs[0].t_i_s) +
                       " and " + FormatDouble(pairs[0].t_j_s) +
                       " s; a boresight needs pairs along whole strips");
  }

  void BuildInertial() {
    Announce("alignment");
    const std::optional<double>& rate_hz = flight_.config.network.node_rate_hz;
    result_.node_rate_hz = rate_hz ? *rate_hz : AutoNodeRateHz(flight_);
    const TimeInterval span = NetworkSpan(flight_, options_.with_pairs);
    const TimeInterval gnss_span = NetworkSpan(flight_, false);
    const std::vector<double> coarse =
        NodeTimes(*flight_.imu, gnss_span, GnssTimes(flight_, gnss_span), {}, {});
    const Alignment alignment = Align(flight_, coarse, options_.interrupted);
    result_.alignment_method = alignment.method;
    const std::vector<double> node_t_s =
        GridOf(flight_, span, options_.with_pairs, result_.node_rate_hz);
    result_.network = std::make_unique<FlightNetwork>(
        flight_, node_t_s, StatesAtNodes(flight_, node_t_s, alignment.run.states),
        options_.network);
  }

  void SetGnssLoss(const Loss& loss) {
    for (const FlightNetwork::GnssEdge& edge : network().gnss_edges) {
      network().net.SetLoss(edge.position, loss);
      if (edge.velocity >= 0) network().net.SetLoss(edge.velocity, loss);
    }
  }

  void SetPairLoss(const Loss& loss) {
    for (const auto& edge : network().pair_edges) network().net.SetLoss(edge.id, loss);
  }

  // Solves one stage; a stage that is only on the way may stop at its iteration limit.
  void SolveStage(const std::string& name, int max_iterations) {
    Announce(name);
    SolveOptions options;
    options.threads = options_.threads;
    options.max_iterations = max_iterations;
    options.initial_trust_region_radius = kTrustRegionRadius;
    options.function_tolerance = kCostTolerance;
    options.second_attempt = false;  // the initial values are those of a filter
    options.on_iteration = [&](const IterationProgress& progress) {
      if (options_.progress) options_.progress(name, progress.iteration);
      return !(options_.interrupted && options_.interrupted());
    };
    const SolveReport report = Solve(network().net, options);
    if (report.interrupted) throw Interrupted();
    result_.stages.push_back({name, report.iterations, report.initial_cost, report.final_cost,
                              report.converged, report.time_s});
    result_.iterations += report.iterations;
    result_.converged = report.converged;
    result_.cost = report.final_cost;
    if (!std::isfinite(report.final_cost)) {
      throw NotConverged("stage '" + name + "': " + report.message);
    }
  }

  void SolveInsGnss() {
    const RobustKind configured = flight_.config.gnss->robust;
    SetGnssLoss(RobustLoss(configured == RobustKind::kNone ? RobustKind::kHuber : configured,
                           kGnssHuberNorm));
    SolveStage("INS/GNSS, robust", options_.max_iterations);
    for (int k = 0; k < kMaxRelinearisations && network().BiasChange() > 1.0; ++k) {
      network().Relinearise();
      SolveStage("INS/GNSS, increments anew", options_.max_iterations);
    }
  }

  // Gross errors of single epochs and offsets of whole runs, whichever stands out more, until
  // nothing changes. A misfit with one cause for all epochs is not one of gross errors.
  void ScreenGnssEpochs() {
    std::set<FactorId> out_for_good;
    for (int pass = 0; pass < kMaxScreenings; ++pass) {
      Announce("GNSS screening");
      result_.gnss_rejected = RejectedGnss(network());
      CheckRejectedShare();
      MarginalsOptions marginals_options;
      marginals_options.threads = options_.threads;
      Marginals marginals(network().net, marginals_options);
      marginals.ComputeSelectedInverse();
      if (MisfitExplained(marginals)) break;
      const GnssScreening screening(network(), marginals);
      const std::optional<GnssJump> jump =
          FindGnssJump(network(), marginals, screening.WorstPositions(kJumpEnds));
      if (jump && jump->statistic > screening.Worst()) {
        TakeOut(*jump, &out_for_good);
      } else if (screening.Apply(out_for_good, &network().net) == 0) {
        result_.gnss_correlation = TestGnssCorrelation(network(), marginals);
        break;
      }
      SolveStage("INS/GNSS, screened", options_.max_iterations);
    }
    result_.gnss_rejected = RejectedGnss(network());
    CheckRejectedShare();
    CheckFit();
  }

  // Far beyond any doubt about a stochastic model.
  void CheckFit() const {
    const CostSummary summary = EvaluateCost(network_const().net, options_.threads);
    const auto redundancy = static_cast<double>(summary.residuals - summary.parameters);
    const double sigma0 = std::sqrt(2.0 * summary.cost / std::max(1.0, redundancy));
    if (sigma0 <= kLargestSigma0) return;
    throw InvalidInput("inertial data and GNSS do not fit each other: their residuals are " +
                       FormatDouble(std::round(sigma0 * 10.0) / 10.0) +
                       " times the stated noise; check axes, units, lever arm, time tags and the "
                       "stochastic model");
  }

  // Solves without the run, then takes back what lies nearer to the others than to the jump.
  void TakeOut(const GnssJump& jump, std::set<FactorId>* out_for_good) {
    Network& net = network().net;
    for (std::size_t e = jump.first; e <= jump.last; ++e) {
      net.SetActive(network().gnss_edges[e].position, false);
    }
    SolveStage("INS/GNSS, screened", options_.max_iterations);
    for (std::size_t e = jump.first; e <= jump.last; ++e) {
      const FactorId id = network().gnss_edges[e].position;
      Eigen::VectorXd r;
      std::vector<Eigen::MatrixXd> J;
      net.EvaluateFactor(id, &r, &J);
      const bool agrees = r.norm() < (r + J[kPositionBlock] * jump.offset_m).norm();
      net.SetActive(id, agrees);
      if (!agrees) out_for_good->insert(id);
    }
  }

  // True where a wrong lever arm or wrong time tags lie behind the misfit: a warning. Throws
  // InvalidInput when a clock steps, which no single correction undoes.
  bool MisfitExplained(const Marginals& marginals) {
    const std::optional<GnssMisfit> misfit = ExplainGnssMisfit(network(), marginals);
    if (!misfit) return false;
    const Eigen::VectorXd rounded = (misfit->estimate * 1e4).array().round() / 1e4;
    const GnssEpoch& epoch = flight_.gnss->epochs[network().gnss_edges[misfit->first].epoch];
    switch (misfit->cause) {
      case GnssMisfit::Cause::kLeverArm:
        result_.warnings.push_back(
            "the innovations of the GNSS positions ask for a correction of gnss.lever_arm_m by "
            "about [" +
            FormatDouble(rounded[0]) + ", " + FormatDouble(rounded[1]) + ", " +
            FormatDouble(rounded[2]) +
            "] m (forward, right, down): check its sign and axes, or estimate gnss_lever_arm");
        return true;
      case GnssMisfit::Cause::kTimeOffset:
        result_.warnings.push_back(
            "the innovations of the GNSS positions ask for time tags that are earlier by about " +
            FormatDouble(rounded[0]) + " s: check the time systems of IMU and GNSS");
        return true;
      case GnssMisfit::Cause::kClockStep:
        break;
    }
    throw InvalidInput("a clock steps: from about t = " + FormatDouble(epoch.t_s) +
                           " s on, the GNSS time tags are " + FormatDouble(rounded[0]) +
                           " s late against those of the inertial data; correct the time tags, or "
                           "limit time_span_s to one part",
                       {flight_.config.gnss->file, epoch.line});
  }

  void CheckRejectedShare() const {
    const auto all = static_cast<double>(network_const().gnss_edges.size());
    const auto rejected = static_cast<double>(result_.gnss_rejected.size());
    if (rejected <= kLargestRejectedShare * all) return;
    const GnssEpoch& first = flight_.gnss->epochs[result_.gnss_rejected.front()];
    throw InvalidInput("GNSS and inertial data contradict each other at " +
                           std::to_string(result_.gnss_rejected.size()) + " of " +
                           std::to_string(network_const().gnss_edges.size()) +
                           " GNSS epochs, first at t = " + FormatDouble(first.t_s) +
                           " s: a clock that steps, a changed reference, wrong time tags or wrong "
                           "axes; correct the data, or limit time_span_s to the good part",
                       {flight_.config.gnss->file, first.line});
  }

  double MeanPairDifference() {
    double sum = 0.0;
    long n = 0;
    for (std::size_t k = 0; k < network().pair_edges.size(); ++k) {
      if (!network().net.factor(network().pair_edges[k].id).active) continue;
      sum += network().PairDifference(k).norm();
      ++n;
    }
    return n > 0 ? sum / static_cast<double>(n) : 0.0;
  }

  // Gauss-Newton on the boresight alone, the trajectory held, with Cauchy weights at the median
  // scale.
  void StartBoresight() {
    Network& net = network().net;
    if (net.block(network().boresight.id).held) return;
    constexpr int kBoresightBlock = 6;
    constexpr int kMaxSteps = 30;
    constexpr double kStepRad = 1e-8;
    for (int step = 0; step < kMaxSteps; ++step) {
      std::vector<Eigen::Vector3d> r;
      std::vector<Eigen::Matrix3d> A;
      std::vector<double> norm2;
      for (const auto& edge : network().pair_edges) {
        Eigen::VectorXd residual;
        std::vector<Eigen::MatrixXd> J;
        net.EvaluateFactor(edge.id, &residual, &J);
        r.emplace_back(residual);
        A.emplace_back(J[kBoresightBlock]);
        norm2.push_back(residual.squaredNorm());
      }
      const double scale2 = RobustVariance(norm2);
      Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
      Eigen::Vector3d b = Eigen::Vector3d::Zero();
      for (std::size_t k = 0; k < r.size(); ++k) {
        const double weight = 1.0 / (1.0 + norm2[k] / (kPairCauchyNorm * kPairCauchyNorm * scale2));
        N += weight * A[k].transpose() * A[k];
        b += weight * A[k].transpose() * r[k];
      }
      // Weak directions are left to the full network: a small ridge, 1 deg per sqrt(number of
      // pairs).
      N.diagonal().array() += 1.0 / (kRadPerDeg * kRadPerDeg);
      const Eigen::Vector3d d = -N.ldlt().solve(b);
      net.SetValue(network().boresight, Exp(d) * net.Value(network().boresight));
      if (d.norm() < kStepRad) break;
    }
  }

  void SolvePairsRobustly() {
    constexpr int kIterations = 6;
    SetPairLoss({Loss::Type::kCauchy, kPairCauchyNorm});
    SolveStage("lidar, robust", kIterations);
  }

  void RejectPairs() {
    Network& net = network().net;
    std::vector<double> norm2;
    for (const auto& edge : network().pair_edges) {
      Eigen::VectorXd r;
      net.EvaluateFactor(edge.id, &r);
      norm2.push_back(r.squaredNorm());
    }
    const double scale2 = RobustVariance(norm2);
    for (std::size_t k = 0; k < norm2.size(); ++k) {
      if (norm2[k] <= kRejectNorm * kRejectNorm * scale2) continue;
      net.SetActive(network().pair_edges[k].id, false);
      ++result_.outliers;
    }
    SetPairLoss(RobustLoss(flight_.config.lidar->robust, kPairCauchyNorm));
  }

  void SolveFinally() {
    SetGnssLoss(RobustLoss(flight_.config.gnss->robust, kGnssHuberNorm));
    network().Relinearise();
    for (int k = 0; k < kMaxRelinearisations; ++k) {
      SolveStage("final least squares", options_.max_iterations);
      if (network().BiasChange() < kRelinearised) break;
      network().Relinearise();
    }
    if (!result_.converged) {
      const StageReport& last = result_.stages.back();
      throw NotConverged(
          "the final least squares did not converge in " + std::to_string(options_.max_iterations) +
          " iterations (cost " + std::to_string(last.cost_before) + " to " +
          std::to_string(last.cost_after) +
          "); check the stochastic model, lever arms and the time tags of the flight");
    }
  }

  const Flight& flight_;
  const AdjustOptions& options_;
  Adjustment result_;
};

}  // namespace

void AdjustOptions::Validate() const {
  if (threads < 1) throw InvalidConfig("adjustment: threads must be at least 1");
  if (max_iterations < 1) throw InvalidConfig("adjustment: max_iterations must be at least 1");
}

double AutoNodeRateHz(const Flight& flight) {
  constexpr double kLadderHz[] = {1.0, 2.0, 5.0, 10.0, 20.0};
  // Measured on flights of three grades and two densities of pairs (docs/benchmarks.md): up to this
  // share no boresight sigma is off by more than 0.5 %, and no angle by more than 0.05 sigma, of
  // their limits.
  constexpr double kSharedVariance = 0.05;
  constexpr double kShortestStripS = 1.0;
  if (!flight.config.lidar || !flight.pairs || flight.pairs->pairs.empty()) return kLadderHz[0];
  const auto ends = 2.0 * static_cast<double>(flight.pairs->pairs.size());
  double strips_s = kShortestStripS;
  for (const TimeInterval& strip : ClusterEpochs(PairEpochs(flight), kStripJoinS)) {
    strips_s += strip.t1_s - strip.t0_s;
  }
  const double noise_m_per_sqrt_s =
      flight.config.imu->model.gyro.white * MeanRange(flight.pairs->pairs);
  const double relative = noise_m_per_sqrt_s / flight.config.lidar->sigma_p_m;
  for (const double rate_hz : kLadderHz) {
    const double ends_per_interval = std::max(1.0, ends / strips_s / rate_hz);
    if (relative * relative / rate_hz * ends_per_interval <= kSharedVariance) return rate_hz;
  }
  return std::end(kLadderHz)[-1];
}

Adjustment Adjust(const Flight& flight, const AdjustOptions& options) {
  options.Validate();
  if (!flight.imu || !flight.gnss)
    throw InvalidInput("adjustment: the flight has no inertial or GNSS data");
  if (options.with_pairs && (!flight.pairs || flight.pairs->pairs.empty())) {
    throw InvalidInput("adjustment: the flight has no point-to-point pairs");
  }
  return Adjuster(flight, options).Run();
}

}  // namespace dn
