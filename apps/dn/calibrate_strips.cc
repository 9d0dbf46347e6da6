#include "calibrate_strips.h"

#include <dn/error.h>
#include <dn/files/scanners.h>
#include <dn/files/strip_files.h>
#include <dn/lidar/pairs.h>

#include <algorithm>

#include "match_flight.h"

namespace dn::apps {
namespace {

constexpr const char* kSmoothed = "smoothed/trajectory.out";

bool HasPairs(const FlightConfig& config) {
  std::vector<std::string> patterns = config.lidar->p2p;
  if (patterns == LidarConfig().p2p) patterns.emplace_back("lidar/*.txt");
  return std::any_of(patterns.begin(), patterns.end(), [&](const std::string& pattern) {
    try {
      return !FindPairFiles(config.folder, {pattern}).empty();
    } catch (const InvalidInput&) {
      return false;
    }
  });
}

}  // namespace

bool HasStripsAlone(const FlightConfig& config) {
  return NumScanners(config) == 1 && config.strips_crs != "none" && !HasPairs(config) &&
         !FindStripFiles(config).empty();
}

void CalibrateStrips(const FlightConfig& config, const std::string& trajectory, Run& run,
                     const std::function<void(const FlightConfig&)>& calibrate) {
  run.progress().Warn("no file of lidar.p2p exists: pairs are computed by matching the strips");
  const MatchedFlight matched =
      MatchFlightStrips(config, trajectory, MakeRunMatchOptions(run), {}, run);
  AddMatches(matched, run);
  if (matched.smoothed) AddSmoothedTrajectory(*matched.smoothed, "smoothed/", run);
  if (matched.result.pairs() == 0) FailNoPairs();
  // The calibration reads the staged files, but the written configuration must name the paths of
  // the published files.
  const FlightConfig published = WithMatches(matched, run.files().path(), kSmoothed);
  const auto correct = [&] { run.AddFile("config.resolved.yaml", FormatFlightConfig(published)); };
  try {
    calibrate(WithMatches(matched, run.files().staging(), kSmoothed));
  } catch (const FailedWithResults&) {
    correct();
    throw;
  }
  correct();
}

}  // namespace dn::apps
