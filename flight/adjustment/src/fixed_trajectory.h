#pragma once

#include <dn/adjustment/gauss_helmert_flight.h>
#include <dn/rotation.h>

#include <string>
#include <vector>

namespace dn::adjustment_internal {

// The methods on a fixed trajectory share the functions of this file.

/// Reports a stage to `progress`. Throws Interrupted if `interrupted` returns true.
void Announce(const GaussHelmertFlightOptions& options, const std::string& stage);

/// Throws NotConverged unless the adjustment converged. `method` and `data` name the adjustment and
/// its lidar data in the message.
void ExpectConverged(bool converged, int iterations, const char* method, const char* data);

/// Throws InvalidInput if the trajectory was adjusted together with the lidar data.
void CheckTrajectory(const Flight& flight);

/// Throws InvalidConfig if `estimate` does not name the boresight. `method` names the adjustment in
/// the message, such as "the plane adjustment".
void CheckEstimate(const FlightConfig& config, const char* method);

/// Reads the accuracy of the trajectory as ReadTrajectoryAccuracy does, for the given ends.
TrajectoryAccuracy ReadAccuracyAt(const Flight& flight,
                                  const std::vector<const GaussHelmertEnd*>& ends);

/// Returns the options of the trajectory covariance: stated accuracy and first epochs of the
/// strips.
TrajectoryErrorOptions MakeScatterOptions(const TrajectoryAccuracy& accuracy,
                                          const std::vector<StripInterval>& strips);

/// Returns the geometry of strips at the mean range mean_range_m.
StripDiversity DescribeStrips(const Flight& flight, const std::vector<StripInterval>& strips,
                              double mean_range_m);

/// Classifies an attitude error that changes a measured quantity with the noise noise_m by
/// change_m: noise, covered or absorbed.
facts::AttitudeInPairs::Size ClassifyAttitudeError(double change_m, double noise_m,
                                                   const Eigen::Vector3d& sigma_rph_rad);

/// Fills in the results that do not depend on the kind of observations: the boresight with its
/// covariances, and the figures.
template <class Calibration>
void FillBoresight(const CorrelatedErrorCovariance& scatter, Calibration* calibration) {
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

/// Adds the reasons of attitude errors and of strips that are too similar. An error that the angles
/// absorb changes the verdict `calibrated`.
void AddGeometryReasons(const facts::AttitudeInPairs& attitude, const StripDiversity& diversity,
                        BoresightResult* boresight);

/// Adds a reason for each unknown under `estimate` that is not among `estimated`. `because` says
/// which ones the method estimates.
void AddNotEstimated(const FlightConfig& config, const std::vector<std::string>& estimated,
                     const char* because, BoresightResult* boresight);

/// Adds a reason if flight.yaml has beams, but their corrections are not estimated.
void AddBeamsNotEstimated(const FlightConfig& config, const std::vector<BeamCorrections>& beams,
                          BoresightResult* boresight);

/// Adds the reason why the reliable sigmas are larger than those of the normal matrix, if they are.
void AddWideningReason(const CorrelatedErrorCovariance& scatter, const TrajectoryAccuracy& accuracy,
                       const Eigen::Matrix3d& constant_rad2, BoresightResult* boresight);

}  // namespace dn::adjustment_internal
