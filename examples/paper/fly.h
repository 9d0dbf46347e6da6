#pragma once

#include <dn/calibration/gauss_helmert_flight.h>
#include <dn/calibration/result.h>
#include <dn/sim/simulate.h>

#include <cstdint>
#include <filesystem>
#include <string>

namespace paper {

/// A simulated flight with the trajectory that `dn smooth` gives of its raw inertial and GNSS data,
/// ready for both formulations: flight.trajectory, and trajectory_sigma.txt beside its file.
struct SmoothedFlight {
  dn::SimulatedFlight sim;
  Eigen::Vector3d rph_rmse_deg;  ///< of the smoothed attitude, over the flight
};

/// Flies a shipped scenario, or one given, and smooths it. The stated attitude accuracy of the
/// trajectory is that of the paper's Table 1. Files go to `folder`.
SmoothedFlight Fly(const dn::Scenario& scenario, std::uint64_t seed,
                   const std::filesystem::path& folder);

/// Error of estimated angles, deg: the rotation vector of estimate times inverse truth.
Eigen::Vector3d ErrorDeg(const Eigen::Vector3d& estimate_rad, const Eigen::Vector3d& truth_rad);

}  // namespace paper
