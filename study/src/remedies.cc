#include "remedies.h"

#include <dn/error.h>
#include <dn/sim/extra_lines.h>
#include <dn/solvers/marginals.h>

#include <algorithm>
#include <atomic>
#include <future>
#include <map>

#include "joint_covariance.h"

namespace dn {
namespace {

constexpr double kWorthWhile = 0.95;

using Sigmas = std::map<std::string, double>;

/// Sigmas of the calibration unknowns by name, in their units; none where there are none to be had.
Sigmas SigmasWith(const Scenario& scenario, const DesignOptions& options) {
  try {
    const StudyDesign design = DesignOf(scenario, options);
    const FlightNetwork network = Build(design.flight, design.states);
    const JointCovariance joint =
        CalibrationCovariance(network, Marginals(network.net, {.threads = options.threads}));
    Sigmas sigmas;
    for (std::size_t i = 0; i < joint.unknowns.size(); ++i) {
      const JointUnknown& unknown = joint.unknowns[i];
      sigmas[unknown.name] = joint.sigma(static_cast<Eigen::Index>(i)) * unknown.per_si;
    }
    return sigmas;
  } catch (const InvalidConfig&) {  // it cannot be flown, say for a hill in the way
    return {};
  } catch (const RankDeficient&) {
    return {};
  }
}

std::vector<Sigmas> SigmasOfAll(const std::vector<Remedy>& remedies, const DesignOptions& options) {
  DesignOptions each = options;
  each.threads = 1;
  std::vector<Sigmas> sigmas(remedies.size());
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t k = next++; k < remedies.size(); k = next++) {
      sigmas[k] = SigmasWith(remedies[k].scenario, each);
    }
  };
  std::vector<std::future<void>> workers;
  const auto threads = std::min(static_cast<std::size_t>(options.threads), remedies.size());
  for (std::size_t k = 1; k < threads; ++k) workers.push_back(std::async(std::launch::async, work));
  work();
  for (std::future<void>& worker : workers) worker.get();
  return sigmas;
}

}  // namespace

std::optional<TriedRemedy> StudyDirection::remedy() const {
  if (tried.empty() || tried.front().sigma > kWorthWhile * sigma) return std::nullopt;
  return tried.front();
}

std::vector<Remedy> RemediesFor(const Scenario& scenario, const FlightGeometry& geometry) {
  if (scenario.plan.lines.empty() || scenario.plan.replay) return {};
  std::vector<Remedy> remedies;
  const auto add_line = [&](RemedyKind kind, const PlannedLine& line) {
    remedies.push_back({kind, scenario});
    remedies.back().scenario.plan.lines.push_back(line);
  };
  const PlannedLine& first = scenario.plan.lines.front();
  if (geometry.parallel) add_line(RemedyKind::kCrossStrip, CrossLine(scenario.plan.lines));
  if (geometry.one_direction) add_line(RemedyKind::kOppositeStrip, Reversed(first));
  if (geometry.one_height) {
    add_line(RemedyKind::kOtherHeight, Higher(first, geometry.strips.front().height_m));
  }
  if (geometry.one_speed) add_line(RemedyKind::kOtherSpeed, Faster(first));
  remedies.push_back({RemedyKind::kMorePairs, scenario});
  remedies.back().scenario.pairs.count *= 2;
  return remedies;
}

void TryRemedies(const std::vector<Remedy>& remedies, const DesignOptions& options,
                 std::vector<StudyDirection>* directions) {
  const std::vector<Sigmas> sigmas = SigmasOfAll(remedies, options);
  for (StudyDirection& direction : *directions) {
    for (std::size_t k = 0; k < remedies.size(); ++k) {
      const auto sigma = sigmas[k].find(direction.leading);
      if (sigma == sigmas[k].end()) continue;
      direction.tried.push_back({remedies[k].kind, sigma->second});
    }
    std::stable_sort(direction.tried.begin(), direction.tried.end(),
                     [](const TriedRemedy& a, const TriedRemedy& b) { return a.sigma < b.sigma; });
  }
}

}  // namespace dn
