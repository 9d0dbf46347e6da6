#pragma once

#include <dn/builder/flight_network.h>

#include <Eigen/Core>
#include <optional>

namespace dn::diagnosis_internal {

/// Estimates a boresight from each pair of strips and returns the scatter of these estimates beyond
/// their noise, rad, per angle. Each estimate uses the INS/GNSS data and the point pairs of its two
/// strips alone, and is one linear step from the network's values. With G_g = J_g N_g^-1 E, where E
/// selects the columns of the boresight,
///
///   theta_g = -G_g^T r_g,   cov(theta_g, theta_h) = G_g^T G_h over the data that both have.
///
/// The estimates are correlated because they share the trajectory. Returns 0 if the noise explains
/// the scatter. Returns nullopt if the boresight is constant, or if fewer than two pairs of strips
/// determine it.
std::optional<double> BoresightScatter(const FlightNetwork& network, int threads);

/// Returns the tau for which values of covariance C + tau^2 I scatter as expected about their
/// common mean. With orthonormal contrasts d between the values, d^T (cov d + tau^2 I)^-1 d = dim
/// d. Returns 0 if they scatter less than C predicts. Each value takes three rows.
double ExcessScatter(const Eigen::VectorXd& values, const Eigen::MatrixXd& C);

}  // namespace dn::diagnosis_internal
