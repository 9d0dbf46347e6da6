#pragma once

#include <dn/distributions.h>
#include <dn/montecarlo/flight_record.h>
#include <dn/report/json.h>

#include <array>
#include <string>
#include <vector>

namespace dn {

/// A statistic with its 99 % interval under the hypothesis that the covariances are correct.
struct TestedStatistic {
  double value = 0.0;
  Interval band;
  bool ok() const { return band.Contains(value); }
};

/// Consistency of the boresight over the flights.
struct BoresightConsistency {
  TestedStatistic nees_per_dof;             ///< mean NEES / 3
  std::array<TestedStatistic, 3> coverage;  ///< share of the angles within 1, 2, 3 sigmas
  Eigen::Vector3d mean_sigmas = Eigen::Vector3d::Zero();  ///< mean of e / sigma, per angle
  Eigen::Vector3d rms_deg = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_sigma_deg = Eigen::Vector3d::Zero();
};

/// Consistency of one quantity of the trajectory. At one epoch the flights are independent, so the
/// mean of their NEES has an exact band. Errors at different epochs are correlated. Therefore the
/// share of epochs outside the band is 1 % only on average.
struct TrajectoryConsistency {
  std::string quantity;
  std::vector<double> t_s;
  std::vector<double> nees_per_dof;  ///< mean over the flights, per epoch
  Interval band;                     ///< 99 % interval of nees_per_dof at one epoch
  double share_outside = 0.0;
  double share_above = 0.0;                              ///< share of over-confident epochs
  double mean_nees_per_dof = 0.0;                        ///< mean over epochs and flights
  Eigen::Vector3d rms_sigmas = Eigen::Vector3d::Zero();  ///< rms of e / sigma per component
};

/// Consistency of one axis of a sensor over all flights.
struct SensorConsistency {
  std::string sensor;
  std::string axis;
  TestedStatistic variance_ratio;  ///< mean square / expected variance
  TestedStatistic lag1;            ///< tested only for innovations, which must be white
};

/// Consistency of the covariances over many simulated flights.
struct MonteCarloSummary {
  long flights = 0;
  long failures = 0;
  std::vector<std::string> failure_messages;  ///< "seed 7: ..."
  bool with_pairs = true;
  BoresightConsistency boresight;
  std::vector<TrajectoryConsistency> trajectory;  ///< in the order of kQuantities
  TestedStatistic chi2_per_dof;                   ///< sum of 2 x cost / sum of redundancies
  TestedStatistic share_chi2_inside;  ///< share of flights whose chi2 is inside its own 99 % band
  /// Share of flights whose model is rejected by the model check, although it is the true one.
  TestedStatistic share_contradicted;
  std::vector<std::string> contradictions;  ///< of these flights: "seed 7: ..."
  std::vector<SensorConsistency> residuals;
  std::vector<SensorConsistency> innovations;
  Eigen::Vector3d position_rms_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_rms_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d attitude_rms_deg = Eigen::Vector3d::Zero();  ///< roll, pitch, heading
  double mean_time_s = 0.0;

  /// Returns true if every tested statistic is inside its band.
  bool consistent() const;
};

/// Tests the covariances with the records of all flights. Throws InvalidInput if no flight was
/// adjusted.
MonteCarloSummary Summarise(const std::vector<FlightRecord>& records);

Json ToJson(const MonteCarloSummary& summary);

/// Formats trajectory_nees.txt. Columns: number of the quantity in the order of the summary, from
/// 1; t [s]; NEES / 3, mean over the flights. Empty if no epochs were recorded.
std::string FormatTrajectoryNees(const MonteCarloSummary& summary);

/// Formats boresight_errors.txt: seed and error / sigma of roll, pitch, yaw of every flight that
/// was adjusted with pairs. Empty if there is no such flight.
std::string FormatBoresightErrors(const std::vector<FlightRecord>& records);

/// Formats the summary as a text table.
std::string FormatTable(const MonteCarloSummary& summary, const std::string& scenario);

}  // namespace dn
