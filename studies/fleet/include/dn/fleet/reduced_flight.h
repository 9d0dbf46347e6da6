#pragma once

#include <dn/adjustment/result.h>
#include <dn/effects/effect_table.h>
#include <dn/fleet/reduced_ties.h>
#include <dn/geo/local_frame.h>
#include <dn/report/json_reader.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace dn {

struct FlightConfig;
class Solution;

/// The parts of flight.yaml that must be the same for flights of one scanner on one mount, and the
/// lever arm of the antenna.
struct FlightMounting {
  Eigen::Matrix3d R_bs_nominal = Eigen::Matrix3d::Identity();   ///< scanner to body
  Eigen::Matrix3d R_imu_to_body = Eigen::Matrix3d::Identity();  ///< as in the section imu
  Eigen::Vector3d lidar_lever_arm_b_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d scan_axis_s = Eigen::Vector3d::UnitX();
  Eigen::Vector3d nadir_axis_s = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d gnss_lever_arm_b_m = Eigen::Vector3d::Zero();
};

/// Returns the mounting that a configuration states. It needs the sections imu, gnss and lidar.
FlightMounting StatedMounting(const FlightConfig& config);

/// Returns the key of flight.yaml in which two mountings differ beyond rounding; empty if they
/// agree. The lever arm of the antenna may differ.
std::string FindDifference(const FlightMounting& a, const FlightMounting& b);

/// An effect that a flight estimates, or that its model leaves out.
struct ReducedEffect {
  EffectId effect;
  bool estimated = false;                ///< an unknown under `estimate`
  std::vector<Eigen::Index> components;  ///< indices in the table of effects
  Eigen::VectorXd prior_sigma;           ///< of these components, SI; infinite without a prior
  std::string remedy = {};               ///< what makes its part in the sigmas smaller
};

/// A calibrated flight, reduced to the unknowns that it may share with other flights. All other
/// unknowns are eliminated: trajectory, biases, and time-correlated errors.
///
/// `mean` and `covariance` are those of the posterior of
///
///   [left rotation of the boresight from angles_rad; components of each effect], SI,
///
/// which has the priors of the flight. Dividing the posterior by these priors gives the likelihood,
/// exact to second order.
struct ReducedFlight {
  std::string name;
  std::string made_from;              ///< hash of configuration and data
  std::string data;                   ///< hash of the data
  double begin_s = 0.0, end_s = 0.0;  ///< first and last node
  Geodetic origin;
  FlightMounting mounting;
  Verdict verdict = Verdict::kCalibrated;
  std::vector<std::string> reasons;                      ///< of the verdict, as sentences
  Eigen::Vector3d angles_rad = Eigen::Vector3d::Zero();  ///< boresight, reported
  ModelledBoresight as_modelled;                         ///< boresight of the pure model
  /// Prior of the boresight (lidar.boresight_sigma_deg): mean and standard deviations.
  std::optional<Eigen::Vector3d> prior_angles_rad, prior_sigma_rad;
  std::vector<ReducedEffect> effects;
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
  std::optional<ReducedTies> ties;  ///< ground points that other flights measured, too
};

/// Reduces an adjusted flight. `boresight` is its CheckedBoresight.
ReducedFlight ReduceFlight(const Solution& solution, const BoresightResult& boresight);

/// Returns reduced.json (schema dn.reduced/1).
Json ReducedFlightJson(const ReducedFlight& flight);
/// Reads reduced.json. Throws InvalidInput if it does not describe a reduced flight.
ReducedFlight ReadReducedFlight(const JsonPlace& json);

}  // namespace dn
