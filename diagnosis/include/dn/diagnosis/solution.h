#pragma once

#include <dn/adjustment/adjust.h>
#include <dn/adjustment/beams.h>
#include <dn/adjustment/result.h>
#include <dn/adjustment/trajectory_covariance.h>
#include <dn/diagnosis/model_check.h>
#include <dn/diagnosis/scanner_mountings.h>
#include <dn/solvers/marginals.h>

#include <optional>
#include <vector>

namespace dn {

/// A solved flight: its network, linearised at the solution, and the marginal covariances of all
/// unknowns. All results are derived from these.
///
///   const dn::Solution solution(flight);
///   const dn::BoresightResult boresight = solution.Boresight();
///
/// Expensive results are computed on first use and cached, so an object may be used by one thread
/// at a time. The flight must outlive the solution.
class Solution {
 public:
  /// Adjusts the flight. Throws as Adjust does, and RankDeficient if an unknown is not determined.
  explicit Solution(const Flight& flight, const AdjustOptions& options = {});
  Solution(const Flight&& flight, const AdjustOptions& options = {}) = delete;

  /// Takes a flight that is already adjusted.
  explicit Solution(Adjustment adjustment, int threads = 1);

  const Adjustment& adjustment() const { return adjustment_; }
  /// Returns the adjustment, to change it; the solution must not be used any more.
  Adjustment TakeAdjustment();
  const FlightNetwork& network() const { return *adjustment_.network; }
  /// The marginals have their selected inverse.
  const Marginals& marginals() const { return marginals_; }
  const LinearizedNetwork& linearized() const { return marginals_.linearized(); }

  /// Returns sigmas of poses and biases, figures of the adjustment, and statistics of its
  /// residuals.
  const TrajectoryResult& trajectory() const;

  /// Returns the results of the tests of the assumed model.
  const ModelCheck& model_check() const;

  /// Returns the boresight of the pure model with the verdict of its geometry. Throws RankDeficient
  /// if it is constant.
  BoresightResult Boresight() const;
  /// Returns the boresight with verdict and findings of the model check (Assess). Angles and
  /// covariance contain the effects that the model leaves out.
  BoresightResult CheckedBoresight() const;

  /// Returns the angles of the pure model, with their covariance if the effects that the model
  /// leaves out are estimated. Uses no residuals: for designs without measured values.
  BoresightResult PredictedBoresight() const;

  /// Returns the mountings of several scanners, with the effects that the model leaves out and the
  /// findings of the model check; empty for one scanner.
  ScannerMountings CheckedMountings() const;

  /// Returns the mountings of several scanners with the covariances that they have if these effects
  /// are estimated; uses no residuals. Empty for one scanner.
  ScannerMountings PredictedMountings() const;

  /// Returns the corrections of the beams of scanners with several beams, with the effects that the
  /// model leaves out.
  std::vector<BeamCorrections> CheckedBeams() const;

  /// Returns these corrections of the pure model with the sigmas that they have if these effects
  /// are estimated; uses no residuals.
  std::vector<BeamCorrections> PredictedBeams() const;

  /// Returns the other estimated unknowns.
  std::vector<UnknownEstimate> Unknowns() const;

  /// The functions below return results of the model with the effects that it leaves out
  /// (UnmodelledEffects). These are the other estimated unknowns, and poses, biases and standard
  /// deviations at the nodes. CheckedTrajectory corrects points that DenseTrajectory returned for
  /// this network.
  std::vector<UnknownEstimate> CheckedUnknowns() const;
  std::vector<MapPose> CheckedPoses() const;
  std::vector<BiasEstimate> CheckedBiases() const;
  std::vector<TrajectorySigma> CheckedSigmas() const;
  std::vector<NavPoint> CheckedTrajectory(std::vector<NavPoint> points) const;

  /// Returns the joint covariance of poses on the strips, at the nodes chosen by
  /// ExtractTrajectoryCovariance, with the effects that the model leaves out.
  TrajectoryCovariance PoseCovariance(const std::vector<StripInterval>& strips) const;

 private:
  /// Returns the covariances that effects outside of the model add; nullopt for the pure model.
  std::optional<UnmodelledEffects> PredictEffects() const;

  Adjustment adjustment_;
  int threads_;
  Marginals marginals_;
  mutable std::optional<TrajectoryResult> trajectory_;
  mutable std::optional<ModelCheck> model_check_;
};

}  // namespace dn
