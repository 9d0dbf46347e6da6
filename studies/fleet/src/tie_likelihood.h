#pragma once

#include <dn/fleet/reduced_flight.h>

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

namespace dn::fleet_internal {

/// A ground point that two flights measured.
struct Tie {
  std::string name;
  std::size_t flight_i = 0, flight_j = 0;  ///< indices of the flights
  Eigen::Index at_i = 0, at_j = 0;         ///< indices of the point in their ReducedTies
  Eigen::Matrix3d noise_m2 = Eigen::Matrix3d::Identity();  ///< of the pair, ECEF
};

/// Returns the ties whose both flights take part.
std::vector<Tie> FindTies(const std::vector<ReducedFlight>& flights);

/// The tie points of a flight as a function of unknowns y, ECEF:
///
///   g = offset_m + response y + e,   e ~ N(0, covariance_m2).
struct ConditionalTies {
  Eigen::VectorXd offset_m;
  Eigen::MatrixXd response;
  Eigen::MatrixXd covariance_m2;
  std::vector<Eigen::Index> columns;  ///< places of y among the unknowns of all flights
};

/// Conditions tie points on y, which has this mean and covariance. `rows`: the columns of y in
/// TieMoments::cross.
ConditionalTies ConditionTies(const TieMoments& ties, const Eigen::VectorXd& mean,
                              const Eigen::MatrixXd& covariance,
                              const std::vector<Eigen::Index>& rows);

/// Differences of the ends of all ties, three numbers per tie, as a function of all unknowns:
///
///   d = offset_m + response y + e,   e ~ N(0, covariance_m2) without the noise of the pairs.
struct TieDifferences {
  Eigen::VectorXd offset_m;
  Eigen::MatrixXd response;
  Eigen::MatrixXd covariance_m2;
};

/// Returns the differences, first end minus second. `each` has one element per flight.
TieDifferences MakeDifferences(const std::vector<Tie>& ties,
                               const std::vector<ConditionalTies>& each, Eigen::Index unknowns);

/// Returns the covariance of the noise of all pairs, times a factor.
Eigen::MatrixXd NoiseCovariance(const std::vector<Tie>& ties, double factor);

/// Keeps the differences of some ties.
TieDifferences KeepTies(const TieDifferences& all, const std::vector<std::size_t>& kept);

/// Adds the likelihood of the differences being noise of the covariance `noise_m2`, in the form of
/// FleetLikelihood: y^T information y - 2 y^T vector.
void AddDifferences(const TieDifferences& ties, const Eigen::MatrixXd& noise_m2,
                    Eigen::MatrixXd* information, Eigen::VectorXd* vector);

}  // namespace dn::fleet_internal
