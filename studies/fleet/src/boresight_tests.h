#pragma once

#include <dn/fleet/fleet.h>

#include <vector>

#include "fleet_likelihood.h"

namespace dn::fleet_internal {

/// A change of the boresight and its score test in a model without it.
struct ChangeTest {
  bool single_flight = false;
  Eigen::Index flight = 0;  ///< first flight with the other boresight
  Eigen::Vector3d change_rad;
  Eigen::Matrix3d covariance_rad2;
  double statistic = 0.0;  ///< chi-square with three degrees of freedom without a change
};

/// Score tests of changes of the boresight.
class BoresightTests {
 public:
  explicit BoresightTests(const FleetEstimate& estimate, Eigen::Index flights);

  /// Tests the boresight of one flight against that of all others.
  ChangeTest TestFlight(Eigen::Index flight) const;
  /// Tests the boresight from a flight on against that before it.
  ChangeTest TestFrom(Eigen::Index flight) const;

  /// Tests all changes: from each flight but the first on, and of each single flight in between.
  /// The p-value is the share of replicates of the scores whose largest statistic is as large;
  /// far beyond them it is the bound of Bonferroni.
  BoresightStability TestAll() const;

 private:
  ChangeTest Test(bool single, Eigen::Index flight) const;
  std::vector<ChangeTest> Candidates() const;
  double FamilyPValue(const std::vector<ChangeTest>& tests, double statistic) const;

  Eigen::Index flights_;
  Eigen::VectorXd score_;   // of the boresights
  Eigen::MatrixXd A_;       // its covariance
  Eigen::MatrixXd summed_;  // sums of A_ over the flights from each one on
};

}  // namespace dn::fleet_internal
