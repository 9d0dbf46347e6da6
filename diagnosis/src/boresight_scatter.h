#pragma once

#include <dn/builder/flight_network.h>

#include <Eigen/Core>
#include <optional>

namespace dn::internal {

/// How far the boresights from one pair of strips each scatter beyond their noise, rad, per angle.
/// Each is that of the INS/GNSS data with the point pairs of its two strips alone, one linear step
/// from the network's values; with G_g = J_g N_g^-1 E, E the columns of the boresight,
///
///   theta_g = -G_g^T r_g,   cov(theta_g, theta_h) = G_g^T G_h over the data that both have:
///
/// the trajectory is common, so that they are correlated. 0 where the noise explains the scatter;
/// nothing where the boresight is held or fewer than two pairs of strips determine it.
std::optional<double> BoresightScatter(const FlightNetwork& network, int threads);

/// The tau with which values of covariance C + tau^2 I scatter about their common mean as they
/// should: d^T (cov d + tau^2 I)^-1 d = dim d for orthonormal contrasts d between the values; 0
/// where they scatter less. One value of three components per three rows.
double ExcessScatter(const Eigen::VectorXd& values, const Eigen::MatrixXd& C);

}  // namespace dn::internal
