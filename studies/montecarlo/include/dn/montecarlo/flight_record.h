#pragma once

#include <dn/adjustment/result.h>
#include <dn/report/json_reader.h>
#include <dn/sim/simulate.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// Estimated three-component quantities whose errors are compared with their covariance. Position
/// and velocity are in m (east, north, up). The attitude is about the body axes, biases are in b.
inline constexpr std::array<const char*, 5> kQuantities{"position", "velocity", "attitude",
                                                        "gyro bias", "accelerometer bias"};

/// Errors of the trajectory at one epoch, normalised by the estimated covariance C.
struct EpochErrors {
  double t_s = 0.0;                         ///< time since the first node
  std::array<double, 5> nees{};             ///< e^T C^-1 e of each quantity, expected 3
  std::array<Eigen::Vector3d, 5> sigmas{};  ///< error e_i / sigma_i of each component
};

/// Errors and test statistics of one simulated and adjusted flight.
struct FlightRecord {
  std::uint64_t seed = 0;
  bool with_pairs = true;
  std::string failure;  ///< error message; empty if the flight was adjusted
  Eigen::Vector3d boresight_error_rad = Eigen::Vector3d::Zero();  ///< left perturbation from truth
  Eigen::Matrix3d boresight_covariance_rad2 = Eigen::Matrix3d::Zero();
  double chi2 = 0.0;  ///< twice the cost, with the effects if they are drawn
  long redundancy = 0;
  long outliers = 0;
  /// The first reason of the model check to reject the model, although it is the true one. Empty
  /// if it does not.
  std::string contradiction;
  double check_p_value = 1.0;
  std::vector<EpochErrors> epochs;
  Eigen::Vector3d position_rms_m = Eigen::Vector3d::Zero();    ///< east, north, up, all nodes
  Eigen::Vector3d velocity_rms_mps = Eigen::Vector3d::Zero();  ///< east, north, up
  Eigen::Vector3d attitude_rms_rad = Eigen::Vector3d::Zero();  ///< roll, pitch, heading
  std::vector<SeriesStatistics> residuals;
  std::vector<SeriesStatistics> innovations;
  double time_s = 0.0;  ///< run time of simulation and adjustment

  double BoresightNees() const;
};

/// Options for adjusting and recording a flight.
struct FlightRecordOptions {
  bool with_pairs = true;
  double epoch_spacing_s = 1.0;  ///< spacing of the recorded epochs, which are nodes; > 0
  /// If set, each flight has every effect that the model leaves out, drawn from its prior times
  /// this factor, and the reported values are recorded. Otherwise there are none, and those of the
  /// pure model are recorded.
  std::optional<double> unmodelled = {};
  std::function<bool()> interrupted = {};
};

/// Simulates and adjusts one flight. An exception of the adjustment is stored as the record's
/// failure. Interrupted and errors of the scenario are thrown.
FlightRecord RunFlight(const Scenario& scenario, std::uint64_t seed,
                       const FlightRecordOptions& options);

/// These two functions convert a record to JSON and back without any loss of digits.
/// FlightRecordFromJson throws InvalidInput if the value is not a record or is out of range.
Json ToJson(const FlightRecord& record);
FlightRecord FlightRecordFromJson(const JsonPlace& json);

}  // namespace dn
