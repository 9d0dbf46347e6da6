#pragma once

#include <dn/adjustment/gauss_helmert_flight.h>
#include <dn/adjustment/result.h>
#include <dn/sim/simulate.h>

#include <cstdint>
#include <filesystem>
#include <string>

namespace paper {

/// A simulated flight with the trajectory that `dn smooth` computes from its raw inertial and GNSS
/// data. It is prepared for both formulations: flight.trajectory is set, and trajectory_sigma.txt
/// is in the folder of its file.
struct SmoothedFlight {
  dn::SimulatedFlight sim;
  Eigen::Vector3d rph_rmse_deg;  ///< rmse of the smoothed attitude over the flight
};

/// Simulates and smooths a scenario. The stated attitude accuracy of the trajectory is that of the
/// paper's Table 1. Files are written to `folder`.
SmoothedFlight Fly(const dn::Scenario& scenario, std::uint64_t seed,
                   const std::filesystem::path& folder);

/// Returns the error of estimated angles, deg: the rotation vector of estimate times inverse truth.
Eigen::Vector3d ErrorDeg(const Eigen::Vector3d& estimate_rad, const Eigen::Vector3d& truth_rad);

}  // namespace paper
