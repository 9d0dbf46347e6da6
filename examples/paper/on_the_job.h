#pragma once

#include <dn/adjustment/finding.h>

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace paper {

/// One flight of a strip set, calibrated by both formulations from the same pairs.
struct Calibrated {
  /// Attitude errors of the smoothed trajectory that the adjustment used.
  Eigen::Vector3d rph_rmse_deg;
  struct Method {
    Eigen::Vector3d error_deg;  ///< against the truth
    Eigen::Vector3d sigma_deg;
    double nees = 0.0;
    Eigen::Matrix3d correlation;
  };
  Method gh;  ///< with the reliable covariance; the correlation is that of the normal matrix
  Method dn;
  Eigen::Vector3d gh_sigma_formal_deg;  ///< from the normal matrix, times sigma0
  double condition_number = 0.0, sigma0 = 0.0, residual_initial_m = 0.0, residual_final_m = 0.0;
  Eigen::Matrix3d dn_accel, dn_gyro;  ///< correlation of the boresight with the biases
  dn::Verdict gh_verdict, dn_verdict;
};

/// Simulates and calibrates one flight. node_rate_hz is the node rate of the network within the
/// strips; without a value the program chooses it.
Calibrated Calibrate(const std::string& set, std::uint64_t seed,
                     const std::filesystem::path& folder, std::optional<double> node_rate_hz);

/// The flights of one strip set, seed 1 first.
struct SetResult {
  std::string name;
  std::vector<Calibrated> flights;
};

void PrintAttitude(const std::vector<SetResult>& sets);
void PrintAdjustment(const std::vector<SetResult>& sets);
void PrintErrors(const std::vector<SetResult>& sets);
void PrintConsistency(const std::vector<SetResult>& sets);
void PrintCorrelations(const std::vector<SetResult>& sets);

}  // namespace paper
