#pragma once

#include <dn/adjustment/adjust.h>
#include <dn/network.h>

#include <memory>
#include <string>
#include <vector>

namespace dn {

/// The state of a staged adjustment, on which the stages work.
class AdjustmentRun {
 public:
  /// `flight` and `options` must outlive the run.
  AdjustmentRun(const Flight& flight, const AdjustOptions& options);
  AdjustmentRun(const Flight&& flight, const AdjustOptions& options) = delete;
  AdjustmentRun(const Flight& flight, const AdjustOptions&& options) = delete;

  const Flight& flight() const { return flight_; }
  const AdjustOptions& options() const { return options_; }

  /// Returns the options of the network with the threads of the run.
  FlightNetworkOptions network_options() const;

  /// Returns the network; throws InvalidConfig if no stage has made it yet.
  FlightNetwork& network();

  /// Kind of inertial edges in the present network. Raw inertial data are used only at the end:
  /// preintegrated increments between fewer nodes are enough to reject outliers. They are used from
  /// the start if the options have their own stages or customise_before_lidar. A second network
  /// would lack the user's blocks and factors.
  NetworkConfig::Inertial inertial() const { return inertial_; }
  void TakeRawInertial() { inertial_ = NetworkConfig::Inertial::kRaw; }

  /// Returns the result so far, for reading and writing.
  Adjustment& result() { return result_; }

  /// Calls AdjustOptions::customise_before_lidar or AdjustOptions::customise, if it is set.
  void CustomiseBeforeLidar();
  void Customise();
  /// Throws InvalidConfig if one of these functions is set, but was not called.
  void ExpectCustomised() const;

  /// Reports the start of a step to `progress`. Throws Interrupted if `interrupted` returns true.
  void Announce(const std::string& step) const;

  /// Convergence bounds for Solve: length of the last step, in standard deviations of all unknowns
  /// together. The first is for a stage whose result the next one refines, the second for a stage
  /// that only decides on rejections. AdjustOptions has that of the final stage.
  static constexpr double kStageSigmas = 0.1;
  static constexpr double kRoughSigmas = 1.0;

  /// Solves the present network until a step is shorter than `sigma_tolerance`, and adds a
  /// StageSummary with the given name. Reaching the iteration limit is not an error. Throws
  /// NotConverged if the cost is not finite, and Interrupted.
  void Solve(const std::string& name, int max_iterations, double sigma_tolerance = kStageSigmas);

  /// Sets the loss of all GNSS positions and velocities, or of all pairs.
  void SetGnssLoss(const Loss& loss);
  void SetPairLoss(const Loss& loss);

  /// Swaps in another network; SwapNetworkBack swaps the original in again and returns the other
  /// one.
  void SwapNetworkIn(std::unique_ptr<FlightNetwork> network);
  std::unique_ptr<FlightNetwork> SwapNetworkBack();
  bool has_swapped_network() const { return set_aside_ != nullptr; }

  /// Returns the mean norm of the differences of the active pairs, m; 0 if there are none.
  double MeanPairDifference();

 private:
  const Flight& flight_;
  const AdjustOptions& options_;
  NetworkConfig::Inertial inertial_;
  Adjustment result_;
  std::unique_ptr<FlightNetwork> set_aside_;
  bool customised_before_lidar_ = false;
  bool customised_ = false;
};

/// Returns the stages of Adjust in their order:
///
///   name                   | function          | purpose
///   -----------------------|-------------------|------------------------------------------------
///   network                | MakeNetwork       | alignment, forward filter, nodes, inertial and
///                          |                   | GNSS edges
///   INS/GNSS               | SolveInsGnss      | solves it with a robust loss on GNSS
///   GNSS clock             | SettleGnssClock   | moves nodes to the times of the GNSS epochs, if
///                          |                   | the clock is estimated
///   GNSS screening         | ScreenGnss        | rejects GNSS data that contradict all other data
///   pairs                  | AddPairs          | adds the edges of the pairs
///   before lidar           | AddOwnBeforeLidar | calls AdjustOptions::customise_before_lidar
///   boresight start        | StartBoresight    | boresight alone, with the trajectory constant
///   lidar, robust          | SolvePairsRobustly| everything, with a robust loss on the pairs too
///   pair rejection         | RejectPairs       | rejects pairs whose residuals cannot be noise
///   control                | UseControl        | activates the surveys of control points
///   inertial rate          | UseInertialRate  | with `inertial: raw`: nodes at all IMU epochs
///   before final           | AddOwnBeforeFinal | calls AdjustOptions::customise
///   final least squares    | SolveFinally      | integrates increments again, no robust loss
///
/// Without pairs, returns the first four and the last three.
std::vector<AdjustmentStage> DefaultStages(bool with_pairs = true);

/// Returns the position of a stage in a list, for insert and erase. Throws InvalidConfig with the
/// names of the stages in the list.
std::vector<AdjustmentStage>::iterator FindStage(const std::string& name,
                                                 std::vector<AdjustmentStage>* stages);

/// Makes the network with the initial trajectory from the alignment. Throws InvalidInput, and
/// SensorsContradict if the GNSS tags are off by seconds (FindGnssLag).
void MakeNetwork(AdjustmentRun& run);

/// Solves the INS/GNSS network. The loss on GNSS is that of gnss.robust, Huber by default. It
/// applies until SolveFinally.
void SolveInsGnss(AdjustmentRun& run);

/// Makes nodes at the times of the GNSS epochs according to the estimated clock, and solves again.
/// Repeats this while node and epoch are more than 5 ms apart.
void SettleGnssClock(AdjustmentRun& run);

/// Rejects outliers at single GNSS epochs and offsets over several epochs, the most significant
/// first, until nothing changes.
///
/// If the misfit shows an offset and a drift of the clock, the screening estimates both. The
/// assumed network is then solved without the same epochs (Adjustment::gnss_clock). Any other cause
/// that affects all epochs gives a warning, or InvalidInput if a clock steps. Also throws
/// InvalidInput if more than a third of the epochs contradict, or if inertial data and GNSS do not
/// fit.
void ScreenGnss(AdjustmentRun& run);

/// Adds the edges of the pairs and of the control. The surveys of control points are not active
/// yet: a wrong one would bend the trajectory before the pairs are screened. Throws InvalidInput if
/// no pair joins two nodes, or if the tags of the pairs are off by seconds (FindPairClockOffset).
void AddPairs(AdjustmentRun& run);

/// Estimates the boresight alone by Gauss-Newton, with Cauchy weights at the median scale.
void StartBoresight(AdjustmentRun& run);

/// Solves the network with pairs. The loss on the pairs is that of lidar.robust, Cauchy by default.
/// It applies until SolveFinally.
void SolvePairsRobustly(AdjustmentRun& run);

/// Rejects the pairs whose residuals exceed the noise at the median scale.
void RejectPairs(AdjustmentRun& run);

/// Activates the surveys of all control points that are not checks.
void UseControl(AdjustmentRun& run);

/// With `inertial: raw`, makes the network again with nodes at every inertial epoch, from the
/// present trajectory and with the measurements that are active. Does nothing if the network
/// already has these nodes.
void UseInertialRate(AdjustmentRun& run);

/// These two stages call the user's functions if they are set.
void AddOwnBeforeLidar(AdjustmentRun& run);
void AddOwnBeforeFinal(AdjustmentRun& run);

/// Solves the least squares of the kept data without robust losses, so that the inverse of the
/// normal matrix is the covariance of the estimate. Throws NotConverged.
void SolveFinally(AdjustmentRun& run);

}  // namespace dn
