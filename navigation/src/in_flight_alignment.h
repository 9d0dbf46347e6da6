#pragma once

#include <dn/builder/flight_network.h>
#include <dn/flight/flight.h>
#include <dn/imu/preintegration.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace dn::internal {

/// A GNSS antenna position in m.
struct Antenna {
  double t_s;
  Eigen::Vector3d p_m;
};

/// The antenna positions inside a span, to a microsecond.
std::vector<Antenna> AntennaTrack(const Flight& flight, const TimeInterval& span);

/// Time between the antenna positions whose second differences AlignInFlight takes, s: such that
/// their noise is 0.1 m/s^2, at least 1 s.
double AlignmentSpacing(const Flight& flight);

/// Attitude at the beginning of a span of a flight.
struct InFlight {
  Eigen::Quaterniond q_mb = Eigen::Quaterniond::Identity();
  double sigma_heading_rad = 1e9;
  double misfit_mps2 = 0.0;  ///< root mean square of (beta - R_a alpha) over the squared spacing
  bool valid = false;
};

/// Wahba's problem R_a alpha_k = beta_k in the inertial frame that coincides with m at the first
/// epoch:
///   beta = X2 - (1 + r) X1 + r X0 - D2 (D + D2) / 2 C G,  X = C(t) (r0 + p)
///                                                                from the antenna positions
///   alpha = r dR_a0 (D dv01 - dp01) + dR_a1 dp12 + lever terms   from the inertial data
/// with D and D2 the time from epoch 0 to 1 and from 1 to 2, r = D2 / D; epochs within a millisecond
/// of even spacing count as even.
/// The flight needs inertial data, GNSS and its lever arm alone. Not valid where fewer than three
/// triples of positions lie in the span.
InFlight AlignInFlight(const Flight& flight, const TimeInterval& span, const ImuCorrection& bias);

}  // namespace dn::internal
