#pragma once

#include <dn/calibration/gauss_helmert_flight.h>
#include <dn/rotation.h>

#include <vector>

namespace dn::internal {

/// What the methods on a fixed trajectory share.

/// Throws InvalidInput where the trajectory was adjusted with the lidar data.
void CheckTrajectory(const Flight& flight);

/// Throws InvalidConfig when `estimate` does not name the boresight. method: "the plane adjustment".
void CheckEstimate(const FlightConfig& config, const char* method);

/// ReadTrajectoryAccuracy at any ends.
TrajectoryAccuracy ReadAccuracyAt(const Flight& flight,
                                  const std::vector<const GaussHelmertEnd*>& ends);

TrajectoryScatterOptions MakeScatterOptions(const TrajectoryAccuracy& accuracy,
                                            const std::vector<StripInterval>& strips);

/// The geometry of strips that the scanner sees from mean_range_m.
StripDiversity DescribeStrips(const Flight& flight, const std::vector<StripInterval>& strips,
                              double mean_range_m);

/// The sizes of an attitude error that changes what is compared by change_m, against its own
/// noise_m: noise, held, absorbed.
facts::AttitudeInPairs::Size SizeOfAttitudeError(double change_m, double noise_m,
                                                 const Eigen::Vector3d& sigma_rph_rad);

/// Fills in what follows from the adjustment and the scatter: the boresight, its covariances, the
/// figures that do not depend on the kind of observations.
template <class Calibration>
void FillBoresight(const TrajectoryScatter& scatter, Calibration* calibration) {
  const auto& adjustment = calibration->adjustment;
  BoresightResult& boresight = calibration->boresight;
  boresight.angles_rad = adjustment.boresight_rad;
  boresight.euler_zyx_rad = RollPitchHeading(Exp(adjustment.boresight_rad));
  calibration->constant_rad2 =
      scatter.constant_share * calibration->accuracy.attitude_covariance_rad2;
  boresight.covariance_rad2 = ReliableCovariance(adjustment, scatter, calibration->constant_rad2);
  boresight.condition_number = adjustment.condition_number;
  boresight.sigma_apriori_rad = adjustment.covariance_apriori_rad2.diagonal().cwiseSqrt();
  boresight.sigma_scaled_rad = adjustment.covariance_scaled_rad2.diagonal().cwiseSqrt();
  AdjustmentFigures& figures = calibration->figures;
  figures.sigma0 = adjustment.sigma0;
  figures.chi2 = adjustment.chi2;
  figures.redundancy = adjustment.redundancy;
  figures.iterations = adjustment.iterations;
  figures.converged = adjustment.converged;
}

/// Adds why the reliable sigmas are wider than those of the normal matrix, where they are.
void AddWhyWider(const TrajectoryScatter& scatter, const TrajectoryAccuracy& accuracy,
                 const Eigen::Matrix3d& constant_rad2, BoresightResult* boresight);

/// The sum of squares of an adjustment against what the stated errors of the trajectory, which last,
/// make of it.
GroupCheck GroupOf(const char* name, long observations, const AdjustmentFigures& figures,
                   const TrajectoryScatter& scatter);

}  // namespace dn::internal
