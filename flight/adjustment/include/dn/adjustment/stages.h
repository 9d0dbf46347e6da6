#pragma once

#include <dn/calibration/adjust.h>
#include <dn/network.h>

#include <memory>
#include <string>
#include <vector>

namespace dn {

/// A staged adjustment under way, as its stages see it.
class AdjustmentRun {
 public:
  /// Both must outlive the run.
  AdjustmentRun(const Flight& flight, const AdjustOptions& options);

  const Flight& flight() const { return flight_; }
  const AdjustOptions& options() const { return options_; }

  /// Those of the network, on the threads of the run.
  FlightNetworkOptions network_options() const;

  /// Throws InvalidConfig where no stage has made it yet.
  FlightNetwork& network();

  /// Of the nodes of the network as it stands. Raw inertial data are taken last, as increments
  /// between fewer nodes decide as well what is left out; from the start on where the options have
  /// stages or blocks of a user's own, which only the first network would get.
  NetworkConfig::Inertial inertial() const { return inertial_; }
  void TakeRawInertial() { inertial_ = NetworkConfig::Inertial::kRaw; }

  /// What is known so far.
  Adjustment& result() { return result_; }

  /// Tells the progress that a step begins. Throws Interrupted where that is wished.
  void Announce(const std::string& step) const;

  /// Last steps of a stage, in standard deviations of all unknowns together: of the last one, of one
  /// after which the next goes on, and of one that only decides what is left out.
  static constexpr double kFinalSigmas = 1e-3;
  static constexpr double kStageSigmas = 0.1;
  static constexpr double kRoughSigmas = 1.0;

  /// Solves the network as it stands until a step is shorter than `sigma_tolerance`, and adds a
  /// StageReport of that name; ending at the iteration limit is no error. Throws NotConverged where
  /// the cost is not finite, Interrupted.
  void Solve(const std::string& name, int max_iterations, double sigma_tolerance = kStageSigmas);

  /// Of every GNSS position and velocity, of every pair.
  void SetGnssLoss(const Loss& loss);
  void SetPairLoss(const Loss& loss);

  /// Takes another network in place of the present one, until TakeBack gives it back for that.
  void StandIn(std::unique_ptr<FlightNetwork> network);
  std::unique_ptr<FlightNetwork> TakeBack();
  bool has_stand_in() const { return set_aside_ != nullptr; }

  /// Mean norm of the differences of the pairs that are in use, m; 0 without any.
  double MeanPairDifference();

 private:
  const Flight& flight_;
  const AdjustOptions& options_;
  NetworkConfig::Inertial inertial_;
  Adjustment result_;
  std::unique_ptr<FlightNetwork> set_aside_;
};

/// The stages of Adjust in their order:
///
///   name                   | function          | what it does
///   -----------------------|-------------------|-------------------------------------------------
///   network                | MakeNetwork       | alignment, forward filter, nodes, inertial and GNSS
///                          |                   | edges
///   INS/GNSS               | SolveInsGnss      | solves it with a robust loss on GNSS
///   GNSS clock             | SettleGnssClock   | nodes at the times of the GNSS epochs, where the
///                          |                   | clock is estimated
///   GNSS screening         | ScreenGnss        | takes out what contradicts all other data
///   pairs                  | AddPairs          | edges of the pairs
///   before lidar           | AddOwnBeforeLidar | AdjustOptions::customise_before_lidar
///   boresight start        | StartBoresight    | boresight alone, the trajectory held
///   lidar, robust          | SolvePairsRobustly| everything, with a robust loss on the pairs as well
///   pair rejection         | RejectPairs       | takes out pairs that cannot be noise
///   inertial rate          | GoToInertialRate  | with `inertial: raw`: nodes at every inertial epoch
///   before final           | AddOwnBeforeFinal | AdjustOptions::customise
///   final least squares    | SolveFinally      | no robust loss; increments integrated anew
///
/// Without pairs the first four and the last three.
std::vector<AdjustmentStage> DefaultStages(bool with_pairs = true);

/// The place of a stage in a list, for insert and erase. Throws InvalidConfig naming the stages
/// that there are.
std::vector<AdjustmentStage>::iterator StageNamed(const std::string& name,
                                                  std::vector<AdjustmentStage>* stages);

/// Makes the network with its trajectory from the alignment. Throws InvalidInput.
void MakeNetwork(AdjustmentRun& run);

/// The loss on GNSS is that of gnss.robust, Huber's by default. It stays until SolveFinally.
void SolveInsGnss(AdjustmentRun& run);

/// Solves anew with nodes at the times of the epochs that the estimated clock tells, as long as the
/// two lie more than 5 ms apart.
void SettleGnssClock(AdjustmentRun& run);

/// Takes out gross errors of single epochs and offsets of whole runs, whichever stands out more,
/// until nothing changes. Where offset and drift of the clock show in the misfit, that is done with
/// both among the unknowns, and the assumed network is solved without the same epochs
/// (Adjustment::gnss_clock). Another cause for all epochs is a warning, or InvalidInput where a clock
/// steps. Throws InvalidInput where more than a third of the epochs contradict, or nothing fits.
void ScreenGnss(AdjustmentRun& run);

/// Throws InvalidInput where no pair joins two nodes.
void AddPairs(AdjustmentRun& run);

/// Gauss-Newton on the boresight alone, with Cauchy weights at the median scale.
void StartBoresight(AdjustmentRun& run);

/// The loss on the pairs is that of lidar.robust, Cauchy's by default. It stays until SolveFinally.
void SolvePairsRobustly(AdjustmentRun& run);

/// Takes out the pairs whose residuals exceed what noise of the median scale brings.
void RejectPairs(AdjustmentRun& run);

/// With `inertial: raw` the network anew with nodes at every inertial epoch, where it has not, with
/// what is in use of the measurements, from the present trajectory.
void GoToInertialRate(AdjustmentRun& run);

/// Calls the user's functions, where there are any.
void AddOwnBeforeLidar(AdjustmentRun& run);
void AddOwnBeforeFinal(AdjustmentRun& run);

/// Least squares of what was kept: every robust loss of a GNSS epoch or a pair ends here, so that
/// the inverse of the normal matrix is the covariance of the estimate. Throws NotConverged.
void SolveFinally(AdjustmentRun& run);

}  // namespace dn
