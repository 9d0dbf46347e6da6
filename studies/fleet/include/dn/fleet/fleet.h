#pragma once

#include <dn/adjustment/result.h>
#include <dn/files/across.h>
#include <dn/fleet/reduced_flight.h>
#include <dn/report/json.h>

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dn {

/// Angles with their covariance.
struct UncertainAngles {
  Eigen::Vector3d rad = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_rad2 = Eigen::Matrix3d::Zero();

  Eigen::Vector3d sigma_rad() const { return covariance_rad2.diagonal().cwiseMax(0.0).cwiseSqrt(); }
};

/// A flight as a part of the fleet.
struct FleetFlight {
  std::string name;
  double begin_s = 0.0;
  Verdict verdict = Verdict::kCalibrated;
  UncertainAngles alone;  ///< result of the flight alone
  /// Boresight of the flight minus that of the other flights. The effects of the sensor are common
  /// and cancel as far as they act alike.
  UncertainAngles change;
  double p_value = 1.0;  ///< of the change, as that of a single test
};

/// The best explanation of boresights that differ.
struct BoresightChange {
  bool single_flight = false;  ///< true: only that flight differs; else all from it on
  std::size_t flight = 0;      ///< index of the first flight with the other boresight
  UncertainAngles change;      ///< left rotation of the boresight
  UncertainAngles after;       ///< boresight of the flight, estimated with the change
  double statistic = 0.0;      ///< chi-square with three degrees of freedom if nothing changed
};

/// Test of whether the boresight is the same, or changes as `across` states, in all flights.
struct BoresightStability {
  static constexpr double kLevel = 0.01;  ///< probability of a false alarm

  BoresightChange change;  ///< the likeliest one
  double p_value = 1.0;    ///< of the largest statistic of all possible changes
  /// Test of all differences together: chi-square and degrees of freedom.
  double chi2 = 0.0;
  long dof = 0;
  double chi2_p_value = 1.0;

  bool stable() const { return p_value > kLevel; }
};

/// Random walk of the boresight from flight to flight.
struct BoresightWalk {
  double sigma_rad = 0.0;  ///< per flight and angle: as stated, or else of largest likelihood
  bool stated = false;
  double upper_rad = 0.0;  ///< upper limit of its size, 95 %
  double log_ratio = 0.0;  ///< log likelihood of the estimate minus that of a constant boresight
};

/// Pairs between two strips of different flights.
struct StripTies {
  std::string file;  ///< FOLDER/FILE of the pairs
  std::string flight_i, flight_j;
  long used = 0, rejected = 0;
  /// Mean of the first ends minus the second ones, as each flight alone determines them. East,
  /// north, up at the origin of the first flight.
  Eigen::Vector3d mean_enu_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_enu_m = Eigen::Vector3d::Zero();
  double p_value = 1.0;  ///< of this mean, for the largest of all strips
};

/// Pairs between flights.
struct FleetTies {
  static constexpr double kLevel = 0.001;  ///< probability of a false contradiction

  std::vector<StripTies> by_strips;
  double noise_factor = 1.0;  ///< multiplies the stated variances of the pairs

  long used() const;
  /// Returns the strips that contradict most; null if none do.
  const StripTies* Contradiction() const;
};

/// Result of the calibration of several flights.
struct FleetResult {
  /// Boresight of all flights; with a random walk that of the last one. Its contributions are those
  /// of the effects that flights share.
  BoresightResult boresight;
  /// The part of its covariance that is from effects that flights share: more flights do not make
  /// it much smaller.
  Eigen::Matrix3d shared_covariance_rad2 = Eigen::Matrix3d::Zero();
  std::vector<UnknownEstimate> unknowns;  ///< those under `across`
  std::vector<FleetFlight> flights;
  std::optional<FleetTies> ties;  ///< absent without pairs between flights
  BoresightStability stability;
  bool constant = true;  ///< false: `across` states a random walk
  BoresightWalk walk;
  UncertainAngles next_constant;  ///< next flight, if the boresight is constant
  UncertainAngles next_walk;      ///< next flight, with the random walk
  UncertainAngles next_limit;     ///< next flight, with a random walk of the upper limit
};

/// Adjusts the boresight and the shared effects of several flights from their likelihoods.
///
///   sum over flights of (y - y_k)^T L_k (y - y_k),   y = [boresight; shared effects],
///
/// with the likelihood's information L_k of a flight, one prior per effect, and steps of the
/// boresight by `across`. Effects of a sensor have one value for all flights. Effects of a place
/// have one for the flights at that place, and effects of a day one per flight.
///
/// Pairs between flights (ReducedFlight::ties) add the likelihood of their differences.
///
/// Throws InvalidConfig for fewer than two flights, for different mountings, and for a name under
/// `across` that a flight does not estimate.
FleetResult AdjustFleet(const std::vector<ReducedFlight>& flights, const AcrossConfig& across);

/// A flight outside of the fleet, and the reason.
using ExcludedFlight = std::pair<std::string, std::string>;

/// Returns result.json of several flights (schema dn.result/1) without timings.
Json FleetJson(const FleetResult& fleet, const std::vector<ExcludedFlight>& excluded);

/// Returns the result as a table for the terminal.
std::string FleetSummary(const FleetResult& fleet, const std::vector<ExcludedFlight>& excluded);

/// Returns the reasons of the verdict as sentences, the deciding one first.
std::vector<std::string> FleetReasons(const FleetResult& fleet);

}  // namespace dn
