#include <dn/calibration/stages.h>
#include <dn/geo/text_table.h>
#include <dn/navigation/gnss_correlation.h>
#include <dn/navigation/gnss_screening.h>
#include <dn/navigation/gnss_steps.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "robust_loss_of.h"

namespace dn {
namespace {

constexpr Loss kUsualLoss{Loss::Type::kHuber, 3.0};
constexpr int kMaxRelinearisations = 4;
constexpr int kMaxScreenings = 20;
constexpr std::size_t kJumpEnds = 12;
constexpr std::size_t kPositionBlock = 1;  // of a GNSS position edge
// A network that contradicts more of its GNSS epochs than this is not a good flight with bad
// epochs.
constexpr double kLargestRejectedShare = 1.0 / 3.0;
// Residuals so many times their stated noise come from something else than noise.
constexpr double kLargestSigma0 = 10.0;
constexpr const char* kScreened = "INS/GNSS, screened";

std::vector<std::size_t> RejectedGnss(const FlightNetwork& network) {
  std::vector<std::size_t> epochs;
  for (const FlightNetwork::GnssEdge& edge : network.gnss_edges) {
    const bool velocity_out = edge.velocity >= 0 && !network.net.factor(edge.velocity).active;
    if (!network.net.factor(edge.position).active || velocity_out) epochs.push_back(edge.epoch);
  }
  return epochs;
}

// Notes which epochs are out.
void CountRejected(AdjustmentRun& run) {
  std::vector<std::size_t>& rejected = run.result().gnss_rejected;
  rejected = RejectedGnss(run.network());
  const std::size_t all = run.network().gnss_edges.size();
  if (static_cast<double>(rejected.size()) <= kLargestRejectedShare * static_cast<double>(all)) {
    return;
  }
  const GnssEpoch& first = run.flight().gnss->epochs[rejected.front()];
  throw InvalidInput("GNSS and inertial data contradict each other at " +
                         std::to_string(rejected.size()) + " of " + std::to_string(all) +
                         " GNSS epochs, first at t = " + FormatDouble(first.t_s) +
                         " s: a clock that steps, a changed reference, wrong time tags or wrong "
                         "axes; correct the data, or limit time_span_s to the good part",
                     {run.flight().config.gnss->file, first.line});
}

// Far beyond any doubt about a stochastic model.
void ExpectFit(AdjustmentRun& run) {
  const double sigma0 = EvaluateCost(run.network().net, run.options().threads).sigma0();
  if (!(sigma0 > kLargestSigma0)) return;
  throw InvalidInput("inertial data and GNSS do not fit each other: their residuals are " +
                     FormatDouble(std::round(sigma0 * 10.0) / 10.0) +
                     " times the stated noise; check axes, units, lever arm, time tags and the "
                     "stochastic model");
}

// Solves without the run of epochs, then takes back what lies nearer to the others than to the
// jump.
void TakeOut(const GnssJump& jump, AdjustmentRun& run, std::set<FactorId>* out_for_good) {
  FlightNetwork& network = run.network();
  for (std::size_t e = jump.first; e <= jump.last; ++e) {
    network.net.SetActive(network.gnss_edges[e].position, false);
  }
  run.Solve(kScreened, run.options().max_iterations);
  for (std::size_t e = jump.first; e <= jump.last; ++e) {
    const FactorId id = network.gnss_edges[e].position;
    Eigen::VectorXd r;
    std::vector<Eigen::MatrixXd> J;
    network.net.EvaluateFactor(id, &r, &J);
    const bool agrees = r.norm() < (r + J[kPositionBlock] * jump.offset_m).norm();
    network.net.SetActive(id, agrees);
    if (!agrees) out_for_good->insert(id);
  }
}

// True where a wrong lever arm or wrong time tags lie behind the misfit: a warning. Throws
// InvalidInput when a clock steps, which no single correction undoes.
bool MisfitExplained(const Marginals& marginals, AdjustmentRun& run) {
  const std::optional<GnssMisfit> misfit = ExplainGnssMisfit(run.network(), marginals);
  if (!misfit) return false;
  const auto warn = [&](Fact fact) {
    run.result().warnings.push_back({std::move(fact), true});
    return true;
  };
  switch (misfit->cause) {
    case GnssMisfit::Cause::kLeverArm:
      return warn(facts::GnssLeverArmOff{misfit->estimate});
    case GnssMisfit::Cause::kTimeOffset:
      return warn(facts::GnssTimeOff{misfit->estimate[0]});
    case GnssMisfit::Cause::kClockStep:
      break;
  }
  const GnssEpoch& epoch = run.flight().gnss->epochs[run.network().gnss_edges[misfit->first].epoch];
  throw InvalidInput("a clock steps: from about t = " + FormatDouble(epoch.t_s) +
                         " s on, the GNSS time tags are " +
                         FormatDouble(std::round(misfit->estimate[0] * 1e4) / 1e4) +
                         " s late against those of the inertial data; correct the time tags, or "
                         "limit time_span_s to one part",
                     {run.flight().config.gnss->file, epoch.line});
}

// One pass of the screening; false where nothing is left to change.
bool ScreenOnce(AdjustmentRun& run, std::set<FactorId>* out_for_good) {
  FlightNetwork& network = run.network();
  Marginals marginals(network.net, {.threads = run.options().threads});
  marginals.ComputeSelectedInverse();
  if (MisfitExplained(marginals, run)) return false;
  const GnssScreening screening(network, marginals);
  const std::optional<GnssJump> jump =
      FindGnssJump(network, marginals, screening.WorstPositions(kJumpEnds));
  if (jump && jump->statistic > screening.Worst()) {
    TakeOut(*jump, run, out_for_good);
  } else if (screening.Apply(*out_for_good, &network.net) == 0) {
    run.result().gnss_correlation = TestGnssCorrelation(network, marginals);
    return false;
  }
  run.Solve(kScreened, run.options().max_iterations);
  return true;
}

}  // namespace

void SolveInsGnss(AdjustmentRun& run) {
  run.SetGnssLoss(internal::LossOf(run.flight().config.gnss->robust, kUsualLoss));
  run.Solve("INS/GNSS, robust", run.options().max_iterations);
  for (int k = 0; k < kMaxRelinearisations && run.network().BiasChange() > 1.0; ++k) {
    run.network().Relinearise();
    run.Solve("INS/GNSS, increments anew", run.options().max_iterations);
  }
}

void ScreenGnss(AdjustmentRun& run) {
  std::set<FactorId> out_for_good;
  for (int pass = 0; pass < kMaxScreenings; ++pass) {
    run.Announce("GNSS screening");
    CountRejected(run);
    if (!ScreenOnce(run, &out_for_good)) break;
  }
  CountRejected(run);
  ExpectFit(run);
}

}  // namespace dn
