#pragma once

#include <dn/adjustment/gauss_helmert_flight.h>
#include <dn/fixed_trajectory/plane_adjustment.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

/// The boresight of a flight from planes on its fixed trajectory: problem, adjustment and
/// covariances.
struct PlaneCalibration {
  PlaneProblem problem;
  PlaneAdjustment adjustment;
  PlaneErrorCovariance scatter;
  TrajectoryAccuracy accuracy;
  /// Covariance of the attitude error that is constant over the flight, rad^2 in body.
  Eigen::Matrix3d constant_rad2 = Eigen::Matrix3d::Zero();
  StripDiversity diversity;
  double mean_range_m = 0.0;
  VectorOrigin origin;  ///< origin of the laser vectors of the points
  /// Boresight with its reliable covariance; sigma_apriori_rad and sigma_scaled_rad are set.
  BoresightResult boresight;
  std::vector<UnknownEstimate> unknowns;  ///< lidar_range_offset, if it is estimated
  /// Corrections of the beams of a scanner with several beams, as in GaussHelmertCalibration;
  /// `ends` are points of planes.
  std::vector<BeamCorrections> beams;
  AdjustmentFigures figures;  ///< correspondences are points; outliers are points left out
  double solve_time_s = 0.0;
  double covariance_time_s = 0.0;
};

/// Returns the adjustment problem for planes that strips of a flight share, with the lever arm, the
/// initial boresight and the priors of flight.yaml. The range offset is estimated if `estimate`
/// names lidar_range_offset. Throws InvalidConfig if `estimate` does not name the boresight.
PlaneProblem MakePlaneProblem(const Flight& flight, std::vector<ObservedPlane> planes);

/// Throws RankDeficient, with the numbers, if fewer than ten planes are kept or if their normals
/// are too parallel. `found` is the number of planes given to the adjustment. Normals are too
/// parallel if the smallest eigenvalue of the sum of n n^T is below 0.3. That is the value for ten
/// planes that slope by 10 deg in the weakest direction; a wall counts 1. Both bounds are
/// conventions: an angle must not rest on a few roofs.
void ExpectEnoughPlanes(const PlaneAdjustment& adjustment, std::size_t found);

/// Estimates the boresight of a flight with a trajectory from planes that its strips share.
///
/// The covariance is ReliableCovariance of the planes. The verdict is as in CalibrateGaussHelmert,
/// with points instead of pairs:
///   not_observable  two angles cannot be separated, or a sigma exceeds 0.5 deg;
///   absorbed        the attitude error of the trajectory moves a point off its plane by more than
///                   half of the point's own noise, and exceeds 0.01 deg in roll or pitch or
///                   0.02 deg in heading; or the laser vectors were computed with an assumed
///                   boresight (GaussHelmertFlightOptions::vectors),
///   calibrated      otherwise.
///
/// Throws InvalidConfig if `estimate` does not name the boresight; InvalidInput; RankDeficient as
/// ExpectEnoughPlanes does, or if a direction is not determined; NotConverged; Interrupted.
PlaneCalibration CalibratePlanes(const Flight& flight, std::vector<ObservedPlane> planes,
                                 const GaussHelmertFlightOptions& options = {});

}  // namespace dn
