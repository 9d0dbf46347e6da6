#pragma once

#include <dn/builder/flight_network.h>
#include <dn/builder/flight_nodes.h>
#include <dn/calibration/clocks.h>
#include <dn/calibration/finding.h>
#include <dn/flight/flight.h>
#include <dn/interrupted.h>
#include <dn/navigation/alignment.h>
#include <dn/navigation/gnss_correlation.h>
#include <dn/solvers/shared_analysis.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace dn {

class AdjustmentRun;

/// One stage of an adjustment; dn/calibration/stages.h has those that there are.
struct AdjustmentStage {
  std::string name;
  std::function<void(AdjustmentRun&)> run;
};

/// Options of an adjustment of a flight.
struct AdjustOptions {
  bool with_pairs = true;  ///< false: INS/GNSS only
  int threads = 1;
  int max_iterations = 40;  ///< of each stage
  /// Called at the start of a stage and after every iteration ("lidar, robust", 3 iterations done).
  std::function<void(const std::string& stage, int iterations)> progress = {};
  /// Polled between epochs and iterations; true ends the work with Interrupted.
  std::function<bool()> interrupted = {};
  /// Called once when the pairs have joined the network, before the first stage that uses them, for
  /// blocks and factors of your own that the start of the boresight and the rejection of pairs
  /// should see. Not without pairs. The stage "before lidar" calls it.
  std::function<void(FlightNetwork&)> customise_before_lidar = {};
  /// Called once when the network stands complete, gross errors left out, before the final least
  /// squares: the place to add blocks and factors of your own that need no start. The stage
  /// "before final" calls it.
  std::function<void(FlightNetwork&)> customise = {};
  /// Run in this order; empty: DefaultStages(with_pairs).
  std::vector<AdjustmentStage> stages = {};
  FlightNetworkOptions network;

  void Validate() const;
};

/// The adjustment did not converge; the message says in which stage, and what was seen.
class NotConverged : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One solve of the staged adjustment.
struct StageReport {
  std::string name;
  int iterations = 0;
  double cost_before = 0.0;
  double cost_after = 0.0;
  bool converged = false;
  double time_s = 0.0;
};

/// A solved flight.
struct Adjustment {
  std::unique_ptr<FlightNetwork> network;
  std::string alignment_method;
  double node_rate_hz = 0.0;  ///< NodeRateHz
  std::vector<StageReport> stages;
  int iterations = 0;  ///< of all stages
  bool converged = false;
  long outliers = 0;  ///< pairs rejected
  /// GNSS epochs whose position or velocity contradicts all other data, left out; indices into
  /// Flight::gnss, in time order.
  std::vector<std::size_t> gnss_rejected;
  /// Of the INS/GNSS solution with the epochs that are left; untested where another cause of misfit
  /// was found.
  GnssCorrelation gnss_correlation;
  /// The GNSS clock as the INS/GNSS solution estimates it beside the assumed model, where that takes
  /// away at least half of the misfit. The epochs are screened with it; the result is that of the
  /// assumed model.
  std::optional<ClockEstimate> gnss_clock;
  /// What its user should look into: the adjustment stands, but its model is in doubt.
  std::vector<Finding> warnings;
  double residual_initial_m = 0.0;  ///< mean norm of the pairs' differences before the lidar stages
  double residual_final_m = 0.0;    ///< of the pairs kept, at the solution
  double cost = 0.0;
  double time_s = 0.0;
  /// What its solutions shared, which serves the covariances as well.
  std::shared_ptr<SharedAnalysis> analysis = std::make_shared<SharedAnalysis>();
};

/// Adjusts a flight in stages: alignment and forward filter; INS/GNSS, from which GNSS positions
/// and velocities that contradict all other data are taken out one by one; boresight alone with the
/// trajectory held; everything with a robust loss on GNSS and pairs; rejection of pairs; final
/// least squares. Increments are integrated anew whenever the biases have moved, and at the end.
///
/// Robust losses (`robust` of flight.yaml) belong to the stages on the way. The final stage is plain
/// least squares over what was kept, so that covariances and tests of the result are exact.
///
/// Needs the flight's imu and gnss (and pairs, when with_pairs). Throws InvalidInput (also when
/// more than a third of the GNSS epochs contradict the inertial data), NotConverged, Interrupted.
Adjustment Adjust(const Flight& flight, const AdjustOptions& options = {});

}  // namespace dn
