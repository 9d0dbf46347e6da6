#pragma once

#include <dn/calibration/adjust.h>
#include <dn/calibration/model_check.h>
#include <dn/calibration/result.h>
#include <dn/calibration/trajectory_covariance.h>
#include <dn/solvers/marginals.h>

#include <optional>
#include <vector>

namespace dn {

/// A solved flight: its network as it was linearised at the solution, with the marginal covariances
/// of every unknown, from which all results are read.
///
///   const dn::Solution solution(flight);
///   const dn::BoresightResult boresight = solution.Boresight();
///
/// What takes time is computed when it is first asked for, and kept: one object is for one thread
/// at a time. The flight must outlive the solution.
class Solution {
 public:
  /// Adjusts the flight. Throws as Adjust, and RankDeficient where the data leave an unknown free.
  explicit Solution(const Flight& flight, const AdjustOptions& options = {});
  Solution(Flight&& flight, const AdjustOptions& options = {}) = delete;

  /// Of a flight that is adjusted.
  explicit Solution(Adjustment adjustment, int threads = 1);

  const Adjustment& adjustment() const { return adjustment_; }
  const FlightNetwork& network() const { return *adjustment_.network; }
  /// With their selected inverse.
  const Marginals& marginals() const { return marginals_; }
  const LinearizedNetwork& linearized() const { return marginals_.linearized(); }

  /// Sigmas of poses and biases, figures of the adjustment, statistics of its residuals.
  const TrajectoryResult& trajectory() const;

  /// Whether the data are those that the assumed model would produce.
  const ModelCheck& model_check() const;

  /// The boresight with the verdict of its geometry. Throws RankDeficient when it is held.
  BoresightResult Boresight() const;
  /// The same with the verdict of the model check before it.
  BoresightResult CheckedBoresight() const;

  /// The other estimated unknowns.
  std::vector<UnknownEstimate> Unknowns() const;

  /// Joint covariance of poses on the strips, as ExtractTrajectoryCovariance chooses them.
  TrajectoryCovariance PoseCovariance(const std::vector<StripInterval>& strips) const;

 private:
  Adjustment adjustment_;
  int threads_;
  Marginals marginals_;
  mutable std::optional<TrajectoryResult> trajectory_;
  mutable std::optional<ModelCheck> model_check_;
};

}  // namespace dn
