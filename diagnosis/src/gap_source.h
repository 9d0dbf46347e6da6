#pragma once

#include <dn/diagnosis/diagnose.h>
#include <dn/geo/trajectory.h>

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "forward_selection.h"
#include "held_out.h"
#include "hypothesis_evidence.h"
#include "noise_shape.h"
#include "replicates.h"

namespace dn::diagnosis_internal {

/// A flight compared with its linear replicates.
struct Comparison {
  ResidualSummary appearance;
  ReplicateSet replicates;
  std::vector<LocationStatistic> statistics;
  ReplicateTest test;
};

/// Figures of the gap at the fit without effects.
struct GapMeasure {
  double p_value = 1.0;
  GapSize size;
  GapUserUnits user_units;
  double replicate_consistency_p = 1.0;  ///< test of replicates against replicates
};

/// Fits and comparisons of a gap, before and after the effects are in the model.
struct BeforeAndAfter {
  const ExtendedFit& base;
  const Comparison& before;
  const ExtendedFit& final;
  const Comparison& after;
};

/// The residuals that a diagnosis explains: those of the network, or those of pairs on a fixed
/// trajectory. A fit that is passed to a source must be one that the source made.
class GapSource {
 public:
  virtual ~GapSource() = default;

  /// Returns whether each fit adjusts the flight again. A source that does not is linear in the
  /// effects, and its flight cannot be simulated.
  virtual bool adjusts() const = 0;

  /// Fits the data with the chosen effects in the model and evaluates all others.
  virtual std::unique_ptr<ExtendedFit> Fit(const std::vector<HypothesisEvidence>& chosen) = 0;
  /// Refines the times of an effect that a fit lacks.
  virtual HypothesisEvidence Refine(const ExtendedFit& /*fit*/, HypothesisEvidence effect) const {
    return effect;
  }
  /// Compares a fit with linear replicates of it.
  virtual Comparison Compare(const ExtendedFit& fit) const = 0;

  virtual long observations(const ExtendedFit& fit) const = 0;
  virtual GapMeasure Measure(const ExtendedFit& base, const Comparison& before) const = 0;
  /// Returns whether a significant part of the gap remains after the effects are in the model.
  virtual bool GapRemains(const ExtendedFit& final, const Comparison& after,
                          double threshold_nats) const = 0;
  /// Returns the reduction of the gap, with the states before and after.
  virtual GapShrinkage Shrinkage(const BeforeAndAfter& fits) const = 0;
  /// Returns the gain in the prediction of held-out data; nullopt if it is not measured.
  virtual std::optional<HeldOutGains> HeldOut(const ExtendedFit& /*base*/,
                                              const ExtendedFit& /*final*/) const {
    return std::nullopt;
  }

  /// Lists the places of the gap, and the statistics of the flight, in a diagnosis that states
  /// whether there is a gap.
  virtual void ListPlaces(const ExtendedFit& base, const Comparison& before,
                          const ExtendedFit& last, GapDiagnosis* diagnosis) const = 0;
  /// Returns the shape of the noise of the measurements whose outliers are `outliers`; nullopt if
  /// they are too few.
  virtual std::optional<NoiseShape> Shape(const ExtendedFit& /*base*/,
                                          EffectId /*outliers*/) const {
    return std::nullopt;
  }
  /// Returns the detection limits of the flight. `threshold_nats` is the least evidence for a name.
  virtual std::vector<DetectionLimit> Limits(const ExtendedFit& base,
                                             double threshold_nats) const = 0;
  /// Returns notes on the validity of the diagnosis.
  virtual std::vector<std::string> Notes(const ExtendedFit& /*base*/) const { return {}; }

  virtual Trajectory MakeTrajectory(const ExtendedFit& fit) const = 0;
  /// Returns the total boresight of a fit; zero if it has none.
  virtual Eigen::Vector3d Boresight(const ExtendedFit& fit) const = 0;
};

/// Appends the statistics of a flight that differ most from those of its replicates to the
/// fingerprint, at most `most` of them.
void FillFingerprint(const Comparison& comparison, std::size_t most, GapDiagnosis* diagnosis);

/// Appends the places where a flight differs significantly from its replicates.
void AppendPlaces(const Comparison& comparison, double alpha, GapDiagnosis* diagnosis);

}  // namespace dn::diagnosis_internal
