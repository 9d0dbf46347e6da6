#pragma once

#include <dn/calibration/gauss_helmert_flight.h>
#include <dn/solvers/plane_adjustment.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

/// A flight's boresight from planes on its fixed trajectory, with what stands behind the result.
struct PlaneCalibration {
  PlaneProblem problem;
  PlaneAdjustment adjustment;
  PlaneScatter scatter;
  TrajectoryAccuracy accuracy;
  /// Of the attitude error that is constant over the flight, rad^2 in body.
  Eigen::Matrix3d constant_rad2 = Eigen::Matrix3d::Zero();
  StripDiversity diversity;
  double mean_range_m = 0.0;
  /// With the reliable covariance; sigma_apriori_rad and sigma_scaled_rad beside it.
  BoresightResult boresight;
  std::vector<UnknownEstimate> unknowns;  ///< lidar_range_offset where it is estimated
  ModelCheck model_check;
  AdjustmentFigures figures;  ///< observations: points (correspondences), points left out
  double solve_time_s = 0.0;
  double covariance_time_s = 0.0;
};

/// The problem of planes that strips of a flight share: lever arm, initial boresight and priors of
/// flight.yaml; the range offset is estimated where `estimate` names lidar_range_offset.
/// Throws InvalidConfig when `estimate` does not name the boresight.
PlaneProblem MakePlaneProblem(const Flight& flight, std::vector<SeenPlane> planes);

/// Throws RankDeficient, with the numbers, where fewer than ten planes are left (found: that were
/// given to the adjustment), or where their normals are too parallel: the smallest eigenvalue of the
/// sum of n n^T is below 0.3, which is ten planes that slope by 10 deg in the weakest direction (a
/// wall counts 1). Both bounds are chosen: with them an angle rests on more than a few roofs.
void ExpectEnoughPlanes(const PlaneAdjustment& adjustment, std::size_t found);

/// Boresight of a flight with a trajectory by planes that its strips share.
///
/// The covariance is ReliableCovariance of the planes. The verdict is that of
/// CalibrateGaussHelmert, with points in the place of pairs:
///   not_observable  two angles cannot be told apart, or a sigma exceeds 0.5 deg,
///   absorbed        the attitude error of the trajectory moves a point off its plane by more than
///                   half of the point's own noise, and exceeds 0.01 deg in roll or pitch or
///                   0.02 deg in heading,
///   contradicted    the points have more than twice their stated variance about the planes, or an
///                   angle exceeds 15 deg,
///   calibrated      else.
/// Errors of the lidar (time tags, lever arm, ranges, scan angles) are not looked for.
/// Throws InvalidConfig when `estimate` does not name the boresight; InvalidInput; RankDeficient as
/// ExpectEnoughPlanes, or where a direction is free; NotConverged; Interrupted.
PlaneCalibration CalibratePlanes(const Flight& flight, std::vector<SeenPlane> planes,
                                 const GaussHelmertFlightOptions& options = {});

}  // namespace dn
