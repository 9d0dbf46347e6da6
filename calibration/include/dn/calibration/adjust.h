#pragma once

#include <dn/builder/flight_network.h>
#include <dn/flight/flight.h>
#include <dn/interrupted.h>
#include <dn/navigation/alignment.h>
#include <dn/navigation/gnss_correlation.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace dn {

/// Options of an adjustment of a flight.
struct AdjustOptions {
  bool with_pairs = true;  ///< false: INS/GNSS only
  int threads = 1;
  int max_iterations = 40;  ///< of each stage
  /// Called at the start of a stage and after every iteration ("lidar, robust", 3 iterations done).
  std::function<void(const std::string& stage, int iterations)> progress = {};
  /// Polled between epochs and iterations; true ends the work with Interrupted.
  std::function<bool()> interrupted = {};
  /// Called once when the network stands complete, before it is solved with every edge: the place
  /// to add blocks and factors of your own.
  std::function<void(FlightNetwork&)> customise = {};
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
  double node_rate_hz = 0.0;  ///< within strips
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
  /// What its user should look into, in one sentence each: the adjustment stands, but its model is
  /// in doubt.
  std::vector<std::string> warnings;
  double residual_initial_m = 0.0;  ///< mean norm of the pairs' differences before the lidar stages
  double residual_final_m = 0.0;    ///< of the pairs kept, at the solution
  double cost = 0.0;
  double time_s = 0.0;
};

/// Adjusts a flight in stages: alignment and forward filter; INS/GNSS, from which GNSS positions
/// and velocities that contradict all other data are taken out one by one; boresight alone with the
/// trajectory held; everything with a robust loss on the pairs; rejection of pairs; final least
/// squares. Increments are integrated anew whenever the biases have moved, and at the end.
///
/// Needs the flight's imu and gnss (and pairs, when with_pairs). Throws InvalidInput (also when
/// more than a third of the GNSS epochs contradict the inertial data), NotConverged, Interrupted.
Adjustment Adjust(const Flight& flight, const AdjustOptions& options = {});

/// Node rate within the strips for `node_rate_hz: auto`: the lowest of 1, 2, 5, 10 and 20 Hz at
/// which the angle random walk of one interval, seen at the mean laser range, has at most a
/// twentieth of the variance of the mean of the pairs in that interval. Beyond it the noise that
/// the pairs of an interval share with each other and with the inertial edge, and which the network
/// takes as independent, begins to matter.
double AutoNodeRateHz(const Flight& flight);

}  // namespace dn
