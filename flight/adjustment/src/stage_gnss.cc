#include <dn/adjustment/left_out_gnss.h>
#include <dn/adjustment/stages.h>
#include <dn/adjustment/words.h>
#include <dn/builder/gnss_factors.h>
#include <dn/builder/keep_in_use.h>
#include <dn/geo/text_table.h>
#include <dn/navigation/gnss_correlation.h>
#include <dn/navigation/gnss_screening.h>
#include <dn/navigation/gnss_steps.h>
#include <dn/report/value_words.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "gnss_clock.h"
#include "gnss_fit.h"
#include "gnss_step_trial.h"
#include "network_at.h"
#include "relinearisations.h"
#include "robust_loss_of.h"

namespace dn {
namespace {

const Loss kUsualGnssLoss{Loss::Type::kHuber, 3.0};
constexpr int kMaxScreenings = 20;
constexpr std::size_t kJumpEnds = 12;
constexpr std::size_t kPositionBlock = 1;  // index in the blocks of a GNSS position factor
// If more than this share of the GNSS epochs contradict, the data are not a good flight with a few
// bad epochs.
constexpr double kLargestRejectedShare = 1.0 / 3.0;
// Residuals of more than this many times their stated noise are not noise.
constexpr double kLargestGnssSigma0 = 10.0;
constexpr double kLargestClockOffsetS = 2.0;
constexpr EffectId kOffset = EffectId::kGnssTimeOffset, kDrift = EffectId::kGnssTimeDrift;
constexpr const char* kScreened = "INS/GNSS, screened";

// Counts of the positions and velocities left out; an epoch may lose one or both.
std::string RejectedCountsText(const LeftOutGnss& out) {
  return std::to_string(out.positions) + " GNSS positions and " + std::to_string(out.velocities) +
         " velocities";
}

std::vector<std::size_t> RejectedGnss(const FlightNetwork& network) {
  std::vector<std::size_t> epochs;
  for (const GnssEdge& edge : network.gnss().edges()) {
    const bool velocity_out = edge.velocity >= 0 && !network.net().factor(edge.velocity).active;
    if (!network.net().factor(edge.position).active || velocity_out) epochs.push_back(edge.epoch);
  }
  return epochs;
}

bool TooManyRejected(const std::vector<std::size_t>& rejected, const FlightNetwork& network) {
  return static_cast<double>(rejected.size()) >
         kLargestRejectedShare * static_cast<double>(network.gnss().edges().size());
}

// Records the rejected epochs; throws InvalidInput if they are too many.
void CountRejected(AdjustmentRun& run) {
  std::vector<std::size_t>& rejected = run.result().gnss_rejected;
  rejected = RejectedGnss(run.network());
  if (!TooManyRejected(rejected, run.network())) return;
  const std::size_t all = run.network().gnss().edges().size();
  const MapGnssEpoch& first = run.flight().gnss->epochs[rejected.front()];
  throw SensorsContradict("GNSS and inertial data contradict each other at " +
                              std::to_string(rejected.size()) + " of " + std::to_string(all) +
                              " GNSS epochs (" +
                              RejectedCountsText(CountLeftOutGnss(run.network())) +
                              "), first at t = " + fmt::format("{:.3f}", first.t_s) + " s: ",
                          "the stated noise is much too small, a clock steps, a reference changes, "
                          "or time tags or axes are wrong; estimate the noise (imu.grade: "
                          "unknown) if it is not from a data sheet, look at the time tags, or "
                          "limit time_span_s to the good part",
                          {run.flight().config.gnss->file, first.line});
}

[[noreturn]] void FailFit(double sigma0, AdjustmentRun& run) {
  std::string hint;
  for (const Finding& warning : run.result().warnings) hint += Words(warning) + "; also ";
  throw SensorsContradict("inertial data and GNSS do not fit each other, their residuals are " +
                              FormatDouble(std::round(sigma0 * 10.0) / 10.0) +
                              " times the stated noise: ",
                          hint + "check axes, units, lever arm, time tags and the stochastic model",
                          {run.flight().config.gnss->file});
}

// Throws InvalidInput if the misfit is too large for any error of the stochastic model.
void ExpectFit(AdjustmentRun& run) {
  const double sigma0 = EvaluateCost(run.network().net(), run.options().threads).sigma0();
  if (!(sigma0 > kLargestGnssSigma0)) return;
  FailFit(sigma0, run);
}

/// Throws SensorsContradict if the GNSS clock is off by more than kLargestClockOffsetS. There is
/// then no node near the true times of the epochs, and no adjustment with the assumed clock
/// converges.
void ExpectNearClock(AdjustmentRun& run) {
  const auto& clock = run.result().gnss_clock;
  if (!clock || std::abs(clock->offset_s) <= kLargestClockOffsetS) return;
  adjustment_internal::FailFarClock(run.flight(), clock->offset_s, clock->sigma_offset_s);
}

// Returns the largest ratio, over the axes, of time-correlated to white variance at the first
// epoch.
double CorrelatedOverWhite(const GnssProcess& process, const Flight& flight) {
  const Eigen::Matrix3d& R_m_enu = flight.gnss->epochs.front().R_m_enu;
  const Eigen::Matrix3d white =
      GnssPositionCovariance(flight.gnss->epochs.front(), *flight.config.gnss);
  return process.sigma_enu_m.cwiseAbs2()
      .cwiseQuotient((R_m_enu.transpose() * white * R_m_enu).diagonal())
      .maxCoeff();
}

// Returns the variance of white noise and stated time-correlated errors together, divided by that
// of the white noise. Errors that grow with the bank are left out: most positions do not have them.
double StatedNoiseRatio(const Flight& flight) {
  GnssProcess sum;
  for (const GnssProcess& process : flight.config.gnss->processes) {
    if (process.growth != GnssErrorGrowth::kNone) continue;
    sum.sigma_enu_m = (sum.sigma_enu_m.cwiseAbs2() + process.sigma_enu_m.cwiseAbs2()).cwiseSqrt();
  }
  return 1.0 + CorrelatedOverWhite(sum, flight);
}

// Solves without the epochs of the jump, then restores those that are closer to the other epochs
// than to the jump. Returns whether any epoch is left out for good.
bool TakeOut(const GnssJump& jump, AdjustmentRun& run, std::set<FactorId>* out_for_good) {
  FlightNetwork& network = run.network();
  const std::size_t out_before = out_for_good->size();
  for (std::size_t e = jump.first; e <= jump.last; ++e) {
    network.net().SetActive(network.gnss().edges()[e].position, false);
  }
  run.Solve(kScreened, run.options().max_iterations);
  for (std::size_t e = jump.first; e <= jump.last; ++e) {
    const FactorId id = network.gnss().edges()[e].position;
    Eigen::VectorXd r;
    std::vector<Eigen::MatrixXd> J;
    network.net().EvaluateFactor(id, &r, &J);
    const bool agrees = r.norm() < (r + J[kPositionBlock] * jump.offset_m).norm();
    network.net().SetActive(id, agrees);
    if (!agrees) out_for_good->insert(id);
  }
  return out_for_good->size() > out_before;
}

/// Screens the GNSS epochs of one flight.
class EpochScreener {
 public:
  EpochScreener(AdjustmentRun& run, bool clock_may_step)
      : run_(run), noise_ratio_(StatedNoiseRatio(run.flight())), clock_may_step_(clock_may_step) {}

  /// Makes one pass; returns false if nothing is left to change.
  bool Once() {
    FlightNetwork& network = run_.network();
    Marginals marginals(network.net(), {.threads = run_.options().threads});
    marginals.ComputeSelectedInverse();
    if (const auto misfit = Explain(marginals)) {
      if (misfit->cause != GnssMisfit::Cause::kClock) return Tell(*misfit);
      if (run_.has_swapped_network()) ExpectHope();
      FreeClock(misfit->estimate);
      return true;
    }
    ExpectHope();
    const GnssScreening screening(network, marginals);
    const std::optional<GnssJump> jump =
        jumps_ ? FindGnssJump(network, marginals, screening.WorstPositions(kJumpEnds), noise_ratio_)
               : std::nullopt;
    if (jump && jump->statistic > screening.Worst()) {
      // The other epochs refute a jump if none of its epochs is closer to it than to them. It would
      // be found again in every pass.
      jumps_ = TakeOut(*jump, run_, &rejected_);
    } else if (screening.Apply(rejected_, noise_ratio_, &network.net()) == 0) {
      run_.result().gnss_correlation = TestGnssCorrelation(network, marginals);
      return run_.result().gnss_correlation.significant() && RestoreCorrelatedErrors();
    }
    if (TooManyRejected(RejectedGnss(network), network) && RestoreCorrelatedErrors()) return true;
    run_.Solve(kScreened, run_.options().max_iterations);
    return true;
  }

  /// Continues with the assumed network, without the rejected epochs.
  void Finish() {
    if (!run_.has_swapped_network()) return;
    if (ClockExplains()) run_.result().gnss_clock = EstimateClockError(run_.network());
    const std::unique_ptr<FlightNetwork> free = run_.SwapNetworkBack();
    KeepInUse(*free, &run_.network());
    run_.Solve(kScreened, run_.options().max_iterations);
  }

 private:
  /// Throws SensorsContradict if the misfit is hopeless. A free clock that halved the cost leaves
  /// hope: a clock that steps needs several passes.
  void ExpectHope() {
    FlightNetwork& network = run_.network();
    const CostSummary now = EvaluateCost(network.net(), run_.options().threads);
    const double before = run_.has_swapped_network() ? held_.cost : now.cost;
    const double after = run_.has_swapped_network() ? free_.cost : now.cost;
    if (!adjustment_internal::ClockMayExplain(network, before, after)) FailFit(now.sigma0(), run_);
  }

  /// Returns the cause of a misfit. A step of the clock must be confirmed.
  std::optional<GnssMisfit> Explain(const Marginals& marginals) {
    auto misfit = ExplainGnssMisfit(run_.network(), marginals, clock_may_step_);
    if (!misfit || misfit->cause != GnssMisfit::Cause::kClockStep) return misfit;
    clock_may_step_ = adjustment_internal::StepExplains(run_, *misfit);
    return clock_may_step_ ? misfit : ExplainGnssMisfit(run_.network(), marginals, false);
  }

  /// Adds a warning and returns false. Throws SensorsContradict if a clock steps, which no constant
  /// correction removes.
  bool Tell(const GnssMisfit& misfit) {
    if (misfit.cause == GnssMisfit::Cause::kLeverArm) {
      run_.result().warnings.push_back({facts::GnssLeverArmOff{misfit.estimate}, true});
      return false;
    }
    const MapGnssEpoch& epoch =
        run_.flight().gnss->epochs[run_.network().gnss().edges()[misfit.first].epoch];
    throw SensorsContradict("a clock steps: from about t = " + fmt::format("{:.3f}", epoch.t_s) +
                                " s on, the GNSS time tags are " +
                                FormatDouble(std::round(std::abs(misfit.estimate[0]) * 1e4) / 1e4) +
                                (misfit.estimate[0] < 0.0 ? " s early" : " s late") +
                                " against those of the inertial data; ",
                            "correct the time tags, or limit time_span_s to one part",
                            {run_.flight().config.gnss->file, epoch.line});
  }

  /// Restores all epochs if the rejected ones have time-correlated errors instead of outliers;
  /// returns whether it did. The bounds then allow for white noise and such errors together.
  bool RestoreCorrelatedErrors() {
    FlightNetwork& network = run_.network();
    if (restored_ || RejectedGnss(network).empty()) return false;
    restored_ = true;
    std::vector<std::pair<FactorId, bool>> in_use;
    for (const GnssEdge& edge : network.gnss().edges()) {
      for (const FactorId id : {edge.position, edge.velocity}) {
        if (id < 0) continue;
        in_use.emplace_back(id, network.net().factor(id).active);
        network.net().SetActive(id, true);
      }
    }
    run_.Solve(kScreened, run_.options().max_iterations);
    Marginals marginals(network.net(), {.threads = run_.options().threads});
    marginals.ComputeSelectedInverse();
    const GnssCorrelation test = TestGnssCorrelation(network, marginals);
    const double ratio = CorrelatedOverWhite(test.process, run_.flight());
    if (!test.significant() || ratio > kLargestGnssSigma0 * kLargestGnssSigma0) {
      for (const auto& [id, active] : in_use) network.net().SetActive(id, active);
      return false;
    }
    noise_ratio_ = 1.0 + ratio;
    rejected_.clear();
    return true;
  }

  /// Continues with offset and drift of the clock as unknowns, with all epochs active.
  void FreeClock(const Eigen::VectorXd& start) {
    rejected_.clear();
    held_ = EvaluateCost(run_.network().net(), run_.options().threads);
    CalibrationState calibration = run_.network().calibration().State();
    adjustment_internal::AddToGnssClock(run_.flight(), start[0], start[1], &calibration);
    run_.SwapNetworkIn(adjustment_internal::RemakeNetwork(run_, calibration));
    for (const EffectId effect : {kOffset, kDrift}) {
      run_.network().net().Hold(run_.network().net().Find(EffectName(effect)), false);
    }
    SolveInsGnss(run_);
    if (adjustment_internal::ClockMayExplain(run_.network(), held_.cost, run_.result().cost)) {
      SettleGnssClock(run_);
    }
    free_ = EvaluateCost(run_.network().net(), run_.options().threads);
  }

  bool ClockExplains() const {
    const double gain = 2.0 * (held_.cost - free_.cost);
    return gain >= adjustment_internal::kExplainedShare * adjustment_internal::Excess(held_) &&
           free_.sigma0() <= kLargestGnssSigma0;
  }

  ClockEstimate EstimateClockError(const FlightNetwork& network) const {
    const Marginals marginals(network.net(), {.threads = run_.options().threads});
    const BlockId offset = network.net().Find(EffectName(kOffset));
    const BlockId drift = network.net().Find(EffectName(kDrift));
    const double sigma_offset_s = std::sqrt(marginals.Covariance(offset)(0, 0));
    const double sigma_drift = std::sqrt(marginals.Covariance(drift)(0, 0));
    return {network.net().block(offset).value[0], sigma_offset_s,
            network.net().block(drift).value[0], sigma_drift,
            marginals.Covariance(offset, drift)(0, 0) / (sigma_offset_s * sigma_drift)};
  }

  AdjustmentRun& run_;
  std::set<FactorId> rejected_;
  double noise_ratio_;  // see GnssScreening::Apply
  bool restored_ = false;
  bool jumps_ = true;  // false: the largest jump was refuted
  bool clock_may_step_;
  CostSummary held_, free_;  // with the assumed clock and with a free one, all epochs in use
};

void Screen(AdjustmentRun& run, bool clock_may_step) {
  EpochScreener screener(run, clock_may_step);
  for (int pass = 0; pass < kMaxScreenings; ++pass) {
    run.Announce("GNSS screening");
    CountRejected(run);
    if (!screener.Once()) break;
  }
  screener.Finish();
  CountRejected(run);
  if (!run.result().gnss_clock) ExpectFit(run);
  ExpectNearClock(run);
}

}  // namespace

LeftOutGnss CountLeftOutGnss(const FlightNetwork& network) {
  LeftOutGnss out;
  for (const GnssEdge& edge : network.gnss().edges()) {
    if (!network.net().factor(edge.position).active) ++out.positions;
    if (edge.velocity >= 0 && !network.net().factor(edge.velocity).active) ++out.velocities;
  }
  return out;
}

void SolveInsGnss(AdjustmentRun& run) {
  Loss usual = kUsualGnssLoss;
  usual.width *= std::sqrt(StatedNoiseRatio(run.flight()));
  run.SetGnssLoss(adjustment_internal::ConfiguredLoss(run.flight().config.gnss->robust, usual));
  run.Solve("INS/GNSS, robust", run.options().max_iterations);
  for (int k = 0; k < adjustment_internal::kMaxRepreintegrations &&
                  run.network().inertial().BiasChange() > 1.0;
       ++k) {
    if (k > 0 && adjustment_internal::IsHopeless(run.network()))
      break;  // another cause drives the biases
    run.network().Repreintegrate();
    run.Solve("INS/GNSS, new increments", run.options().max_iterations);
  }
}

void ScreenGnss(AdjustmentRun& run) { Screen(run, true); }

void adjustment_internal::ScreenGnssOutliers(AdjustmentRun& run) { Screen(run, false); }

}  // namespace dn
