#pragma once

#include <dn/adjustment/clocks.h>
#include <dn/adjustment/finding.h>
#include <dn/builder/flight_network.h>
#include <dn/builder/flight_nodes.h>
#include <dn/error.h>
#include <dn/files/flight.h>
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

/// One stage of an adjustment; dn/adjustment/stages.h has the predefined ones.
struct AdjustmentStage {
  std::string name;
  std::function<void(AdjustmentRun&)> run;
};

/// Options of an adjustment of a flight.
struct AdjustOptions {
  bool with_pairs = true;  ///< false: INS/GNSS only
  int threads = 1;
  int max_iterations = 40;  ///< per stage
  /// The final least squares ends with a step that is shorter than this, in standard deviations of
  /// all unknowns together. The step after it would be shorter by orders of magnitude.
  double final_step_sigmas = 1e-3;
  /// Called at the start of a stage and after every iteration, with the number of finished
  /// iterations: ("lidar, robust", 3).
  std::function<void(const std::string& stage, int iterations)> progress = {};
  /// Polled between epochs and iterations; if it returns true, the adjustment throws Interrupted.
  std::function<bool()> interrupted = {};
  /// Called once after the pairs were added to the network, before the first stage that uses them.
  /// Add blocks and factors of your own here if the start of the boresight and the rejection of
  /// pairs must include them. The stage "before lidar" calls it. Adjust throws InvalidConfig if a
  /// function is set but its stage is not among those that run.
  std::function<void(FlightNetwork&)> customise_before_lidar = {};
  /// Called once on the complete network, after the rejection of outliers and before the final
  /// least squares. Add blocks and factors of your own here if they need no robust stage before.
  /// The stage "before final" calls it.
  std::function<void(FlightNetwork&)> customise = {};
  /// The stages in the order in which they run; if empty, DefaultStages(with_pairs).
  std::vector<AdjustmentStage> stages = {};
  FlightNetworkOptions network;

  void Validate() const;
};

/// Thrown if the adjustment did not converge; the message names the stage and the observed values.
class NotConverged : public Error {
 public:
  using Error::Error;
};

/// Inertial data and GNSS that no choice of states and biases brings together: wrong axes, units,
/// coordinates or time tags. The message ends with what to check.
class SensorsContradict : public InvalidInput {
 public:
  /// `finding`: what contradicts, and by how much. `remedy`: what to check.
  SensorsContradict(const std::string& finding, const std::string& remedy,
                    const FileLocation& where)
      : InvalidInput(finding + remedy, where), finding_(finding) {}

  const std::string& finding() const { return finding_; }

 private:
  std::string finding_;
};

/// One solve of the staged adjustment.
struct StageSummary {
  std::string name;
  int iterations = 0;
  double cost_before = 0.0;
  double cost_after = 0.0;
  bool converged = false;
  double time_s = 0.0;
  std::string message = {};  ///< SolveSummary::message
};

/// A solved flight with the record of its adjustment.
struct Adjustment {
  std::unique_ptr<FlightNetwork> network;
  std::string alignment_method;
  double node_rate_hz = 0.0;  ///< from NodeRateHz
  std::vector<StageSummary> stages;
  int iterations = 0;  ///< sum over all stages
  bool converged = false;
  long outliers = 0;          ///< number of rejected pairs
  long surface_outliers = 0;  ///< number of rejected surface pairs
  /// GNSS epochs whose position or velocity was rejected because it contradicts all other data;
  /// indices into Flight::gnss, in time order.
  std::vector<std::size_t> gnss_rejected;
  /// Control points that were left out because they contradict all other data; indices into
  /// ControlData::points.
  std::vector<std::size_t> control_rejected;
  /// Test of the GNSS residuals for time-correlated errors, in the INS/GNSS solution without the
  /// rejected epochs. It is not made if another cause of the misfit was found.
  GnssCorrelation gnss_correlation;
  /// GNSS clock error, estimated by the INS/GNSS solution in addition to the assumed model. It is
  /// set if it removes at least half of the misfit. The GNSS epochs are then screened with the
  /// estimated clock, but the result uses the assumed model.
  std::optional<ClockEstimate> gnss_clock;
  /// Warnings for the user: the adjustment is complete, but its model is in doubt.
  std::vector<Finding> warnings;
  /// Mean norm of the pair differences before the lidar stages.
  double residual_initial_m = 0.0;
  double residual_final_m = 0.0;  ///< the same for the kept pairs, at the solution
  double cost = 0.0;
  double time_s = 0.0;
  /// Symbolic analysis shared by the solves; the covariances reuse it.
  std::shared_ptr<SharedAnalysis> analysis = std::make_shared<SharedAnalysis>();
};

/// Adjusts a flight in stages:
///   1. alignment and forward filter;
///   2. INS/GNSS, with one-by-one rejection of GNSS positions and velocities that contradict all
///      other data;
///   3. boresight alone, with the trajectory constant;
///   4. all unknowns, with a robust loss on GNSS and pairs;
///   5. rejection of pairs;
///   6. final least squares.
/// The increments are integrated again if the biases have changed, and at the end.
///
/// Robust losses (`robust` in flight.yaml) apply to the intermediate stages only. The final stage
/// is plain least squares over the kept data, so that covariances and tests of the result are
/// exact.
///
/// Requires the flight's imu and gnss, and pairs if with_pairs is set. Throws InvalidInput,
/// NotConverged, Interrupted. Throws SensorsContradict if more than a third of the GNSS epochs
/// contradict the inertial data, or if the GNSS residuals exceed all stated noise. The latter ends
/// the work at once if half of the epochs are more than 30 sigmas off and no clock explains it.
///
/// The flight must outlive the adjustment, so a temporary flight does not compile.
Adjustment Adjust(const Flight& flight, const AdjustOptions& options = {});
Adjustment Adjust(const Flight&& flight, const AdjustOptions& options = {}) = delete;

/// Repeats the final least squares of an adjustment after a change of its network. Throws
/// NotConverged and Interrupted.
void AdjustAgain(const Flight& flight, const AdjustOptions& options, Adjustment* adjustment);

}  // namespace dn
