#pragma once

#include <dn/adjustment/gauss_helmert_flight.h>
#include <dn/diagnosis/diagnose.h>
#include <dn/files/flight.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "gap_source.h"
#include "linear_pairs.h"
#include "pair_fit.h"
#include "pair_library.h"

namespace dn::diagnosis_internal {

/// The misclosures of the pairs of a flight on its given trajectory, with time-correlated errors of
/// the trajectory in the model. Tests effects of the lidar and its mount; the trajectory absorbs
/// all others. Effects are linearised at the Gauss-Helmert adjustment.
class FixedTrajectorySource : public GapSource {
 public:
  /// Adjusts the pairs. Both arguments must outlive the object. Throws InvalidInput without a
  /// trajectory and with too few pairs, and as CalibrateGaussHelmert.
  FixedTrajectorySource(const Flight& flight, const GapOptions& options);

  bool adjusts() const override { return false; }

  std::unique_ptr<ExtendedFit> Fit(const std::vector<HypothesisEvidence>& chosen) override;
  Comparison Compare(const ExtendedFit& fit) const override;

  long observations(const ExtendedFit& fit) const override;
  GapMeasure Measure(const ExtendedFit& base, const Comparison& before) const override;
  bool GapRemains(const ExtendedFit& final, const Comparison& after,
                  double threshold_nats) const override;
  GapShrinkage Shrinkage(const BeforeAndAfter& fits) const override;

  void ListPlaces(const ExtendedFit& base, const Comparison& before, const ExtendedFit& last,
                  GapDiagnosis* diagnosis) const override;
  /// The trajectory absorbs all effects but those of the lidar and its mount. Without measured
  /// values its errors have their stated size.
  std::vector<DetectionLimit> Limits(const ExtendedFit& base, double threshold_nats) const override;
  std::vector<std::string> Notes(const ExtendedFit& base) const override;

  Trajectory MakeTrajectory(const ExtendedFit& fit) const override;
  Eigen::Vector3d Boresight(const ExtendedFit& fit) const override;

 private:
  /// Scores of the pairs at one scale of the trajectory errors.
  struct ScaledScores {
    const Screen& screen;
    double chi2 = 0.0;
    double white = 1.0;
    double outlier_sigmas = 0.0;  ///< excess of the number of outliers over that of good pairs
  };

  bool Wanted(EffectId effect) const;
  BoresightEstimate TotalBoresight(const PairFit& fit) const;
  bool ScreensNoise() const;
  ErrorScale ScaleAtPairEnds(const ErrorScale& scale) const;
  void AddOutliers(PairFit* fit) const;
  double OutlierExcess(const PairFit& fit) const;
  double PairSigma() const;
  Eigen::VectorXd StandardisedPlaces(const JointScore& score, const Eigen::VectorXd& s) const;
  std::vector<LocationStatistic> Statistics() const;
  ResidualSummary Summarise(const ScaledScores& at, const Eigen::VectorXd& s) const;
  Comparison Compare(const ScaledScores& at) const;

  const Flight& flight_;
  const GapOptions& options_;
  GaussHelmertCalibration calibration_;
  std::vector<StripInterval> strips_;
  LinearPairs pairs_;
  PairLibrary library_;
  PairFitter fitter_;
};

}  // namespace dn::diagnosis_internal
