#include "calibrate_strips.h"

#include <dn/error.h>
#include <dn/files/scanners.h>
#include <dn/files/strip_files.h>
#include <dn/lidar/pairs.h>

#include <algorithm>

#include "given_trajectory.h"
#include "match_flight.h"
#include "match_scanners.h"

namespace dn::apps {
namespace {

constexpr const char* kSmoothed = "smoothed/trajectory.out";

bool Exists(const FlightConfig& config, const std::string& pattern) {
  try {
    return !FindPairFiles(config.folder, {pattern}).empty();
  } catch (const InvalidInput&) {
    return false;
  }
}

/// Returns whether any pair file of any scanner exists.
bool HasPairs(const FlightConfig& config) {
  std::vector<std::string> patterns;
  for (std::size_t k = 0; k < NumScanners(config); ++k) {
    const std::vector<std::string>& own = ScannerAt(config, k).p2p;
    patterns.insert(patterns.end(), own.begin(), own.end());
  }
  if (patterns == LidarConfig().p2p) patterns.emplace_back("lidar/*.txt");
  for (const PairsBetween& between : config.pairs_between) {
    patterns.insert(patterns.end(), between.p2p.begin(), between.p2p.end());
  }
  return std::any_of(patterns.begin(), patterns.end(),
                     [&](const std::string& pattern) { return Exists(config, pattern); });
}

bool EachHasStrips(const FlightConfig& config) {
  for (std::size_t k = 0; k < NumScanners(config); ++k) {
    if (FindStripFiles(config, k).empty()) return false;
  }
  return true;
}

/// Calls `calibrate` with a flight that names staged files. The written configuration is then
/// replaced by `published`, which names the paths of the published files.
void CalibrateStaged(const FlightConfig& staged, const FlightConfig& published, Run& run,
                     const std::function<void(const FlightConfig&)>& calibrate) {
  const auto correct = [&] { run.AddFile("config.resolved.yaml", FormatFlightConfig(published)); };
  try {
    calibrate(staged);
  } catch (const FailedWithResults&) {
    correct();
    throw;
  }
  correct();
}

/// Stages the matches, and calls `calibrate` with the flight and its pairs.
template <class Matched>
void CalibrateMatched(const Matched& matched, Run& run,
                      const std::function<void(const FlightConfig&)>& calibrate) {
  AddMatches(matched, run);
  if (matched.smoothed) AddSmoothedTrajectory(*matched.smoothed, "smoothed/", run);
  if (matched.result.pairs() == 0) FailNoPairs();
  CalibrateStaged(WithMatches(matched, run.files().staging(), kSmoothed),
                  WithMatches(matched, run.files().path(), kSmoothed), run, calibrate);
}

}  // namespace

bool HasStripsAlone(const FlightConfig& config) {
  return NumScanners(config) > 0 && config.strips_crs != "none" && !HasPairs(config) &&
         EachHasStrips(config);
}

void CalibrateStrips(const FlightConfig& config, const std::string& trajectory, Run& run,
                     const std::function<void(const FlightConfig&)>& calibrate) {
  run.progress().Warn("no file of lidar.p2p exists: pairs are computed by matching the strips");
  const MatchOptions options = MakeRunMatchOptions(run);
  if (NumScanners(config) > 1) {
    CalibrateMatched(MatchScannerStrips(config, trajectory, options, {}, run), run, calibrate);
  } else {
    CalibrateMatched(MatchFlightStrips(config, trajectory, options, {}, run), run, calibrate);
  }
}

void CalibrateSmoothed(const FlightConfig& config, Run& run,
                       const std::function<void(const FlightConfig&)>& calibrate) {
  run.progress().Warn(
      "the flight has no trajectory: it is smoothed from its inertial and GNSS "
      "data, without the pairs");
  AddSmoothedTrajectory(*AdjustFlight(config, false, &run), "smoothed/", run);
  const auto in = [&](const std::filesystem::path& folder) {
    return WithTrajectory(config, (std::filesystem::absolute(folder) / kSmoothed).string());
  };
  CalibrateStaged(in(run.files().staging()), in(run.files().path()), run, calibrate);
}

}  // namespace dn::apps
