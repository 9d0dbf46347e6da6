#include <dn/builder/flight_nodes.h>
#include <dn/error.h>
#include <dn/sim/extra_lines.h>
#include <dn/solvers/marginals.h>
#include <dn/study/remedies.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry.h"
#include "joint_covariance.h"

namespace dn {
namespace {

constexpr double kWorthWhile = 0.95;
// Limit of the node rate in strips. The relative change of a sigma hardly depends on this rate.
constexpr double kNodeRateHz = 2.0;

/// Returns NaN for an unknown without a sigma.
double FindSigma(const std::string& unknown, const std::map<std::string, double>& sigmas) {
  const auto sigma = sigmas.find(unknown);
  return sigma == sigmas.end() ? std::numeric_limits<double>::quiet_NaN() : sigma->second;
}

}  // namespace

std::optional<TriedRemedy> StudyDirection::remedy() const {
  if (tried.empty() || tried.front().sigma > kWorthWhile * sigma) return std::nullopt;
  return tried.front();
}

RemedyTrials::RemedyTrials(const Scenario& scenario, const StudyDesign& design,
                           const DesignOptions& options)
    : options_(options), fewer_nodes_(NodeRateHz(design.flight, true) > kNodeRateHz) {
  options_.threads = 1;
  options_.max_node_rate_hz = kNodeRateHz;
  if (scenario.plan.lines.empty() || scenario.plan.replay) return;
  Prepare(scenario, ComputeGeometry(design));
  const auto threads = std::min(static_cast<std::size_t>(options.threads), scenarios_.size());
  for (std::size_t k = 1; k < threads; ++k) {
    workers_.push_back(std::async(std::launch::async, [this] { Work(); }));
  }
}

/// Trials that have not started are skipped.
RemedyTrials::~RemedyTrials() { next_ = scenarios_.size(); }

void RemedyTrials::Prepare(const Scenario& scenario, const FlightGeometry& geometry) {
  const auto add = [&](RemedyKind kind) -> Scenario& {
    kinds_.push_back(kind);
    return scenarios_.emplace_back(scenario);
  };
  const auto add_line = [&](RemedyKind kind, const PlannedLine& line) {
    add(kind).plan.lines.push_back(line);
  };
  const PlannedLine& first = scenario.plan.lines.front();
  if (geometry.parallel) add_line(RemedyKind::kCrossStrip, CrossLine(scenario.plan.lines));
  if (geometry.one_direction) add_line(RemedyKind::kOppositeStrip, Reversed(first));
  if (geometry.one_height) {
    add_line(RemedyKind::kOtherHeight, Higher(first, geometry.strips.front().height_m));
  }
  if (geometry.one_speed) add_line(RemedyKind::kOtherSpeed, Faster(first));
  add(RemedyKind::kMorePairs).pairs.count *= 2;
  if (fewer_nodes_) scenarios_.push_back(scenario);
  sigmas_.resize(scenarios_.size());
}

RemedyTrials::Sigmas RemedyTrials::SigmasWith(const Scenario& scenario,
                                              const DesignOptions& options) {
  try {
    const StudyDesign design = MakeDesign(scenario, options);
    const FlightNetwork network = Build(design.flight, design.states);
    const JointCovariance joint =
        CalibrationCovariance(network, Marginals(network.net(), {.threads = options.threads}));
    Sigmas sigmas;
    for (std::size_t i = 0; i < joint.unknowns.size(); ++i) {
      const JointUnknown& unknown = joint.unknowns[i];
      sigmas[unknown.name] = joint.sigma(static_cast<Eigen::Index>(i)) * unknown.per_si;
    }
    return sigmas;
  } catch (const InvalidConfig&) {  // it cannot be flown, for example because of a hill
    return {};
  } catch (const RankDeficient&) {
    return {};
  }
}

void RemedyTrials::Work() {
  for (std::size_t k = next_++; k < scenarios_.size(); k = next_++) {
    sigmas_[k] = SigmasWith(scenarios_[k], options_);
  }
}

void RemedyTrials::Finish(StudyResult* study) {
  if (scenarios_.empty()) return;
  Work();
  for (std::future<void>& worker : workers_) worker.get();
  for (StudyDirection& direction : study->weak) {
    const double unchanged =
        fewer_nodes_ ? FindSigma(direction.leading, sigmas_.back()) : direction.sigma;
    for (std::size_t k = 0; k < kinds_.size(); ++k) {
      const double left = FindSigma(direction.leading, sigmas_[k]) / unchanged;
      if (std::isnan(left)) continue;
      direction.tried.push_back({kinds_[k], left * direction.sigma});
    }
    std::stable_sort(direction.tried.begin(), direction.tried.end(),
                     [](const TriedRemedy& a, const TriedRemedy& b) { return a.sigma < b.sigma; });
  }
}

}  // namespace dn
