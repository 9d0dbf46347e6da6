#pragma once

#include <dn/diagnosis/diagnose.h>
#include <dn/files/flight.h>

#include <memory>
#include <optional>
#include <vector>

#include "gap_source.h"
#include "network_fit.h"

namespace dn::diagnosis_internal {

/// Compares the residuals of a network with linear replicates of them.
Comparison CompareNetwork(const NetworkFit& fit, const ReplicateOptions& options);

/// The residuals of the network of a flight with inertial and GNSS data.
class NetworkSource : public GapSource {
 public:
  /// Both arguments must outlive the object.
  NetworkSource(const Flight& flight, const GapOptions& options);

  bool adjusts() const override { return true; }

  /// Throws as Adjust, and InvalidInput if the flight is too short to test its model.
  std::unique_ptr<ExtendedFit> Fit(const std::vector<HypothesisEvidence>& chosen) override;
  HypothesisEvidence Refine(const ExtendedFit& fit, HypothesisEvidence effect) const override;
  Comparison Compare(const ExtendedFit& fit) const override;

  long observations(const ExtendedFit& fit) const override;
  GapMeasure Measure(const ExtendedFit& base, const Comparison& before) const override;
  bool GapRemains(const ExtendedFit& final, const Comparison& after,
                  double threshold_nats) const override;
  GapShrinkage Shrinkage(const BeforeAndAfter& fits) const override;
  std::optional<HeldOutGains> HeldOut(const ExtendedFit& base,
                                      const ExtendedFit& final) const override;

  void ListPlaces(const ExtendedFit& base, const Comparison& before, const ExtendedFit& last,
                  GapDiagnosis* diagnosis) const override;
  std::optional<NoiseShape> Shape(const ExtendedFit& base, EffectId outliers) const override;
  std::vector<DetectionLimit> Limits(const ExtendedFit& base, double threshold_nats) const override;
  std::vector<std::string> Notes(const ExtendedFit& base) const override;

  Trajectory MakeTrajectory(const ExtendedFit& fit) const override;
  Eigen::Vector3d Boresight(const ExtendedFit& fit) const override;

 private:
  const GapOptions& options_;
  NetworkFitter fitter_;
};

}  // namespace dn::diagnosis_internal
