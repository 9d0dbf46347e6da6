#pragma once

#include <dn/calibration/result.h>
#include <dn/report/json.h>
#include <dn/sim/simulate.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace dn {

/// The estimated quantities of three components whose errors are compared with their covariance.
/// Position east, north, up of m; velocity the same; attitude about the body axes; biases in body.
inline constexpr std::array<const char*, 5> kQuantities{"position", "velocity", "attitude",
                                                        "gyro bias", "accelerometer bias"};

/// Error of the trajectory at one epoch, in the terms of its own covariance.
struct EpochErrors {
  double t_s = 0.0;                         ///< since the first node
  std::array<double, 5> nees{};             ///< e^T C^-1 e of each quantity, expected 3
  std::array<Eigen::Vector3d, 5> sigmas{};  ///< e_i / sigma_i of each component
};

/// What one simulated flight, once adjusted, says about its covariances.
struct FlightRecord {
  std::uint64_t seed = 0;
  bool with_pairs = true;
  std::string failure;  ///< message of what went wrong; empty when the flight was adjusted
  Eigen::Vector3d boresight_error_rad = Eigen::Vector3d::Zero();  ///< left perturbation from truth
  Eigen::Matrix3d boresight_covariance_rad2 = Eigen::Matrix3d::Zero();
  double chi2 = 0.0;
  long redundancy = 0;
  long outliers = 0;
  bool contradicted = false;  ///< by the model check, although the model is the flight's own
  double check_p_value = 1.0;
  std::vector<EpochErrors> epochs;
  Eigen::Vector3d position_rms_m = Eigen::Vector3d::Zero();    ///< east, north, up, all nodes
  Eigen::Vector3d velocity_rms_mps = Eigen::Vector3d::Zero();  ///< east, north, up
  Eigen::Vector3d attitude_rms_rad = Eigen::Vector3d::Zero();  ///< roll, pitch, heading
  std::vector<SeriesStatistics> residuals;
  std::vector<SeriesStatistics> innovations;
  double time_s = 0.0;  ///< simulation and adjustment

  double BoresightNees() const;
};

/// How a flight is adjusted and recorded.
struct FlightRecordOptions {
  bool with_pairs = true;
  double epoch_spacing_s = 1.0;  ///< of the recorded epochs, at nodes; > 0
  std::function<bool()> interrupted = {};
};

/// Simulates and adjusts one flight. What an adjustment throws becomes the record's failure;
/// Interrupted and errors of the scenario pass through.
FlightRecord RunFlight(const Scenario& scenario, std::uint64_t seed,
                       const FlightRecordOptions& options);

/// A record as JSON, and back: doubles survive unchanged.
Json ToJson(const FlightRecord& record);
FlightRecord FlightRecordFromJson(const Json& json);

}  // namespace dn
