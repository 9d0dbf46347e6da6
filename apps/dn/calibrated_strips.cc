#include "calibrated_strips.h"

#include <dn/adjustment/words.h>
#include <fmt/format.h>

#include <utility>

#include "given_trajectory.h"
#include "new_strips.h"

namespace dn::apps {
namespace {

/// Returns whether points can be computed with the boresights; tells the user if not.
bool AreUsable(const BoresightByScanner& boresights, Run* run) {
  for (const auto& [scanner, boresight] : boresights) {
    const Verdict verdict = boresight->verdict;
    if (verdict != Verdict::kContradicted && verdict != Verdict::kNotObservable) continue;
    run->progress().Warn(fmt::format("the strips are not georeferenced: the boresight{} is {}",
                                     scanner.empty() ? "" : " of scanner " + scanner,
                                     Word(verdict)));
    return false;
  }
  return true;
}

}  // namespace

void AddNewStrips(const FlightConfig& config, const BoresightByScanner& boresights,
                  const std::vector<BeamCorrections>& beams, const Trajectory* adjusted, Run* run) {
  if (!AreUsable(boresights, run)) return;
  NewStrips work;
  work.config = config;
  const bool own = HasTrajectory(config);
  Flight flight = ReadFlight(config, {.trajectory = own});
  work.frame = flight.frame;
  GeoreferenceOptions trajectories;
  trajectories.threads = run->options().threads;
  if (adjusted != nullptr) {
    trajectories.trajectory = *adjusted;
    work.config = WithTrajectory(config, (run->options().out / "trajectory.out").string());
    trajectories.made_by = std::move(flight.trajectory);
  } else {
    trajectories.trajectory = std::move(*flight.trajectory);
  }
  work.scanners = StatedStrips(work.config, std::move(trajectories));
  for (auto& [scanner, options] : work.scanners) {
    const auto estimate = boresights.find(scanner.lidar->name);
    if (estimate != boresights.end()) {
      options.mounting.boresight_rad = estimate->second->angles_rad;
    }
    options.beams = ObservedErrors(beams, *scanner.lidar);
  }
  GeoreferenceStrips(std::move(work), *run);
}

}  // namespace dn::apps
