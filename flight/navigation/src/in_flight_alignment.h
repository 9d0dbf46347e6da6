#pragma once

#include <dn/builder/flight_network.h>
#include <dn/builder/node_grid.h>
#include <dn/files/flight.h>
#include <dn/imu/preintegration.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace dn::navigation_internal {

/// A GNSS antenna position in the map frame.
struct Antenna {
  double t_s;
  Eigen::Vector3d p_m;
};

/// Returns the antenna positions inside a span, with a tolerance of one microsecond.
std::vector<Antenna> AntennaTrack(const Flight& flight, const TimeInterval& span);

/// Returns the spacing of the antenna positions in the second differences of AlignInFlight, s. It
/// is chosen so that their noise is 0.1 m/s^2, and is at least 1 s. Short spans use a shorter one.
double AlignmentSpacing(const Flight& flight);

/// Attitude at the start of a time span of a flight.
struct InFlight {
  Eigen::Quaterniond q_mb = Eigen::Quaterniond::Identity();
  double sigma_heading_rad = 1e9;
  double misfit_mps2 = 0.0;  ///< root mean square of (beta - R_a alpha) over the squared spacing
  bool valid = false;
};

/// Solves Wahba's problem R_a alpha_k = beta_k in the inertial frame that coincides with the map
/// frame at the first epoch:
///   beta = X2 - (1 + r) X1 + r X0 - D2 (D + D2) / 2 C G,  X = C(t) (r0 + p)
///                                                                from the antenna positions
///   alpha = r dR_a0 (D dv01 - dp01) + dR_a1 dp12 + lever terms   from the inertial data
/// where D and D2 are the times from epoch 0 to 1 and from 1 to 2, r = D2 / D, and G is
/// gravitation. A spacing that is even to a millisecond counts as even. The flight only needs
/// inertial data, GNSS and its lever arm. The result is not valid if the span contains fewer than
/// three triples of positions.
InFlight AlignInFlight(const Flight& flight, const TimeInterval& span, const ImuCorrection& bias);

}  // namespace dn::navigation_internal
