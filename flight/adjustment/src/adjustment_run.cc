#include <dn/adjustment/stages.h>
#include <dn/error.h>
#include <dn/solvers/solve.h>

#include <cmath>
#include <utility>

namespace dn {
namespace {

// The damping of Levenberg-Marquardt is relative to the diagonal of the normal matrix. The
// curvature along a common shift of the whole trajectory is only 1e-9 of it, and must not be damped
// away.
constexpr double kTrustRegionRadius = 1e13;
// Relative change of the cost at convergence: 1e-4 sigma for a cost of 1e4.
constexpr double kCostTolerance = 1e-13;

}  // namespace

AdjustmentRun::AdjustmentRun(const Flight& flight, const AdjustOptions& options)
    : flight_(flight),
      options_(options),
      inertial_(options.stages.empty() && !options.customise_before_lidar
                    ? NetworkConfig::Inertial::kPreintegrated
                    : flight.config.network.inertial) {}

FlightNetwork& AdjustmentRun::network() {
  if (!result_.network) {
    throw InvalidConfig(
        "adjustment: the stage 'network' must come before all that use the network");
  }
  return *result_.network;
}

FlightNetworkOptions AdjustmentRun::network_options() const {
  FlightNetworkOptions network = options_.network;
  network.threads = options_.threads;
  return network;
}

void AdjustmentRun::CustomiseBeforeLidar() {
  customised_before_lidar_ = true;
  if (options_.customise_before_lidar) options_.customise_before_lidar(network());
}

void AdjustmentRun::Customise() {
  customised_ = true;
  if (options_.customise) options_.customise(network());
}

void AdjustmentRun::ExpectCustomised() const {
  if (options_.customise_before_lidar && !customised_before_lidar_) {
    throw InvalidConfig(
        "adjustment: customise_before_lidar is set, but the stage 'before lidar' that calls it is "
        "not among the stages");
  }
  if (options_.customise && !customised_) {
    throw InvalidConfig(
        "adjustment: customise is set, but the stage 'before final' that calls it is not among the "
        "stages");
  }
}

void AdjustmentRun::Announce(const std::string& step) const {
  if (options_.progress) options_.progress(step, 0);
  if (options_.interrupted && options_.interrupted()) throw Interrupted();
}

void AdjustmentRun::Solve(const std::string& name, int max_iterations, double sigma_tolerance) {
  Announce(name);
  SolveOptions options;
  options.threads = options_.threads;
  options.max_iterations = max_iterations;
  options.initial_trust_region_radius = kTrustRegionRadius;
  options.function_tolerance = kCostTolerance;
  options.sigma_tolerance = sigma_tolerance;
  options.analysis = result_.analysis;
  options.second_attempt = false;  // the initial values come from a filter
  options.on_iteration = [&](const IterationProgress& progress) {
    if (options_.progress) options_.progress(name, progress.iteration);
    return !(options_.interrupted && options_.interrupted());
  };
  const SolveSummary summary = dn::Solve(network().net(), options);
  if (summary.interrupted) throw Interrupted();
  result_.stages.push_back({name, summary.iterations, summary.initial_cost, summary.final_cost,
                            summary.converged, summary.time_s, summary.message});
  result_.iterations += summary.iterations;
  result_.converged = summary.converged;
  result_.cost = summary.final_cost;
  if (!std::isfinite(summary.final_cost)) {
    throw NotConverged("stage '" + name + "': " + summary.message);
  }
}

void AdjustmentRun::SetGnssLoss(const Loss& loss) {
  for (const GnssEdge& edge : network().gnss().edges()) {
    network().net().SetLoss(edge.position, loss);
    if (edge.velocity >= 0) network().net().SetLoss(edge.velocity, loss);
  }
}

void AdjustmentRun::SetPairLoss(const Loss& loss) {
  for (const auto& edge : network().pairs().edges()) network().net().SetLoss(edge.id, loss);
  for (const auto& edge : network().surfaces().edges()) network().net().SetLoss(edge.id, loss);
}

void AdjustmentRun::SwapNetworkIn(std::unique_ptr<FlightNetwork> network) {
  set_aside_ = std::exchange(result_.network, std::move(network));
}

std::unique_ptr<FlightNetwork> AdjustmentRun::SwapNetworkBack() {
  return std::exchange(result_.network, std::move(set_aside_));
}

double AdjustmentRun::MeanPairDifference() {
  double sum = 0.0;
  long n = 0;
  for (std::size_t k = 0; k < network().pairs().edges().size(); ++k) {
    if (!network().net().factor(network().pairs().edges()[k].id).active) continue;
    sum += network().pairs().Difference(k).norm();
    ++n;
  }
  return n > 0 ? sum / static_cast<double>(n) : 0.0;
}

}  // namespace dn
