#pragma once

#include <dn/adjustment/beams.h>
#include <dn/builder/beam_unknowns.h>
#include <dn/factors/lidar_effect.h>
#include <dn/files/flight.h>
#include <dn/fixed_trajectory/gauss_helmert.h>

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace dn::adjustment_internal {

/// Estimates the corrections of the beams as laser unknowns of an adjustment on a fixed trajectory.
class BeamAdjustment {
 public:
  /// `ends`: all ends of the problem, with the laser vectors of the files and their beams. They and
  /// the flight must outlive the object. `what` is an end in messages: "a pair" or "a point".
  /// Throws InvalidInput if a beam is not one of the scanner.
  BeamAdjustment(const Flight& flight, std::vector<GaussHelmertEnd*> ends, const char* what);

  /// Returns whether the scanner has beams with unknown errors that the ends name.
  bool any() const { return !unknowns_.empty(); }

  /// Calls adjust(), which returns the estimated laser unknowns of the problem to which `laser`
  /// belongs. With beams it does so twice, since the terms of the vectors are those of one value.
  void Run(LaserUnknowns* laser, const std::function<Eigen::VectorXd()>& adjust);

  /// Returns the corrections with their variances, SI; both are in the order of the laser unknowns.
  std::vector<BeamCorrections> Corrections(const Eigen::VectorXd& value,
                                           const Eigen::VectorXd& variance) const;

 private:
  void SetVectors(const Eigen::VectorXd& value);
  Eigen::MatrixXd Information() const;

  const Flight& flight_;
  std::vector<GaussHelmertEnd*> ends_;
  std::vector<Eigen::Vector3d> file_u_b_;  ///< laser vectors of the files
  Eigen::Matrix3d R_bs_nominal_;
  std::vector<BeamUnknown> unknowns_;
  LidarEffects effects_;  ///< one for each unknown
  Eigen::Index size_ = 0;
};

}  // namespace dn::adjustment_internal
