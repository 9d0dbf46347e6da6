#include <dn/adjustment/trajectory_sigma.h>
#include <dn/diagnosis/solution.h>
#include <dn/error.h>
#include <dn/files/strip_at.h>
#include <dn/study/remedies.h>
#include <dn/study/study.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "geometry.h"
#include "joint_covariance.h"
#include "observability.h"
#include "weak_directions.h"

namespace dn {
namespace {

StripSigmas SigmasOnStrips(const std::vector<TrajectorySigma>& trajectory,
                           const std::vector<StripInterval>& strips) {
  StripSigmas sum;
  double n = 0.0;
  for (const TrajectorySigma& sigma : trajectory) {
    if (StripAt(strips, sigma.t_s) == nullptr) continue;
    sum.roll_pitch_rad += 0.5 * sigma.rph_rad.head<2>().squaredNorm();
    sum.yaw_rad += sigma.rph_rad.z() * sigma.rph_rad.z();
    sum.position_m += sigma.position_enu_m.squaredNorm() / 3.0;
    ++n;
  }
  const auto root_mean = [&](double squares) { return n > 0.0 ? std::sqrt(squares / n) : 0.0; };
  return {root_mean(sum.roll_pitch_rad), root_mean(sum.yaw_rad), root_mean(sum.position_m)};
}

void FillCounts(const Solution& solution, StudyResult* result) {
  const FlightNetwork& network = solution.network();
  result->nodes = static_cast<long>(network.nodes().size());
  result->parameters = solution.marginals().num_parameters();
  const auto [first, past] =
      SampleRange(*network.flight().imu, network.trajectory().node_times().front(),
                  network.trajectory().node_times().back());
  result->imu_epochs = static_cast<long>(past - first);
  result->gnss_epochs = static_cast<long>(network.gnss().edges().size());
  result->pairs = static_cast<long>(network.pairs().edges().size());
}

}  // namespace

bool StudyResult::observable() const {
  const bool scanners = std::all_of(mountings.scanners.begin(), mountings.scanners.end(),
                                    [](const ScannerBoresight& scanner) {
                                      return scanner.boresight.verdict != Verdict::kNotObservable;
                                    });
  return scanners && boresight.verdict != Verdict::kNotObservable && unobservable.empty();
}

Solution SolveAtStates(const StudyDesign& design, int threads) {
  Adjustment adjustment;
  adjustment.network = std::make_unique<FlightNetwork>(Build(design.flight, design.states));
  adjustment.converged = true;
  return Solution(std::move(adjustment), threads);
}

StudyResult Study(const StudyDesign& design, const Solution& solution) {
  const FlightNetwork& network = solution.network();
  const Marginals& marginals = solution.marginals();
  StudyResult result;
  result.name = design.flight.config.name;
  result.source = design.source;
  result.geometry = ComputeGeometry(design);
  result.boresight = solution.PredictedBoresight();
  result.mountings = solution.PredictedMountings();
  result.beams = solution.PredictedBeams();
  result.correlations = BiasCorrelationOverTime(
      network, marginals, marginals.SolveColumns({network.calibration().boresight().id}));
  result.trajectory = TrajectorySigmas(network, marginals);
  result.strips = SigmasOnStrips(result.trajectory, design.strips);
  const JointCovariance joint = CovarianceWithErrors(network, marginals);
  result.unknowns = ListUnknowns(joint, design.flight.config);
  result.unobservable = FindUnobservable(joint, design.flight.config);
  result.weak = StudyDirections(joint);
  FillCounts(solution, &result);
  return result;
}

StudyResult Study(const Scenario& scenario, const StudyOptions& options) {
  const StudyDesign design = MakeDesign(scenario, options.design);
  std::optional<RemedyTrials> trials;
  if (options.remedies) trials.emplace(scenario, design, options.design);
  StudyResult result = Study(design, SolveAtStates(design, options.design.threads));
  if (trials) trials->Finish(&result);
  return result;
}

StudyResult Study(Flight flight, const StudyOptions& options) {
  const StudyDesign design = MakeDesign(std::move(flight), options.design);
  return Study(design, SolveAtStates(design, options.design.threads));
}

}  // namespace dn
