#pragma once

#include <dn/montecarlo/flight_record.h>
#include <dn/report/distributions.h>
#include <dn/report/json.h>

#include <array>
#include <string>
#include <vector>

namespace dn {

/// A figure with the interval that holds it with 99 % probability when the covariances are right.
struct JudgedFigure {
  double value = 0.0;
  Interval band;
  bool ok() const { return band.Contains(value); }
};

/// Consistency of the boresight over the flights.
struct BoresightConsistency {
  JudgedFigure nees_per_dof;             ///< mean NEES / 3
  std::array<JudgedFigure, 3> coverage;  ///< share of the angles within 1, 2, 3 sigmas
  Eigen::Vector3d mean_sigmas = Eigen::Vector3d::Zero();  ///< mean of e / sigma, per angle
  Eigen::Vector3d rms_deg = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_sigma_deg = Eigen::Vector3d::Zero();
};

/// Consistency of one quantity of the trajectory. At one epoch the flights are independent, so the
/// mean of their NEES has an exact band; between epochs errors are correlated, so the share of
/// epochs outside is 1 % in the mean only.
struct TrajectoryConsistency {
  std::string quantity;
  std::vector<double> t_s;
  std::vector<double> nees_per_dof;  ///< mean over the flights, per epoch
  Interval band;                     ///< of one epoch, 99 %
  double share_outside = 0.0;
  double share_above = 0.0;                              ///< over-confident epochs
  double mean_nees_per_dof = 0.0;                        ///< over epochs and flights
  Eigen::Vector3d rms_sigmas = Eigen::Vector3d::Zero();  ///< rms of e / sigma per component
};

/// One sensor and axis over all flights.
struct SensorConsistency {
  std::string sensor;
  std::string axis;
  JudgedFigure variance_ratio;  ///< mean square / expected variance
  JudgedFigure lag1;            ///< judged for innovations only, which must be white
};

/// What many simulated flights together say about the covariances.
struct MonteCarloSummary {
  long flights = 0;
  long failures = 0;
  std::vector<std::string> failure_messages;  ///< "seed 7: ..."
  bool with_pairs = true;
  BoresightConsistency boresight;
  std::vector<TrajectoryConsistency> trajectory;  ///< in the order of kQuantities
  JudgedFigure chi2_per_dof;                      ///< sum of 2 x cost / sum of redundancies
  JudgedFigure share_chi2_inside;  ///< flights whose chi2 is inside its own 99 % band
  /// Flights that the model check calls contradicted, although the model is their own.
  JudgedFigure share_contradicted;
  std::vector<SensorConsistency> residuals;
  std::vector<SensorConsistency> innovations;
  Eigen::Vector3d position_rms_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_rms_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d attitude_rms_deg = Eigen::Vector3d::Zero();  ///< roll, pitch, heading
  double mean_time_s = 0.0;

  /// True when every judged figure is inside its band.
  bool consistent() const;
};

/// Judges the covariances by the flights. Throws InvalidInput when no flight was adjusted.
MonteCarloSummary Summarise(const std::vector<FlightRecord>& records);

Json ToJson(const MonteCarloSummary& summary);

/// trajectory_nees.txt: number of the quantity in the order of the summary, from 1; t [s]; NEES / 3,
/// mean over the flights. Empty where no epochs were judged.
std::string FormatTrajectoryNees(const MonteCarloSummary& summary);

/// boresight_errors.txt: seed, error / sigma of roll, pitch, yaw of every flight that was adjusted
/// with pairs; empty without any.
std::string FormatBoresightErrors(const std::vector<FlightRecord>& records);

/// The table that a person reads.
std::string FormatTable(const MonteCarloSummary& summary, const std::string& scenario);

}  // namespace dn
