#include <dn/adjustment/swaths.h>
#include <dn/error.h>
#include <dn/files/flight.h>
#include <dn/files/scanners.h>
#include <dn/geo/text_table.h>
#include <dn/matching/match.h>
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "calibrate_flights.h"
#include "command.h"
#include "flight_run.h"
#include "match_flight.h"
#include "match_flights.h"
#include "match_scanners.h"
#include "option_checks.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

struct MatchCommand {
  CommonOptions common;
  std::vector<std::string> what;  ///< a flight or strip files
  std::string trajectory;
  double gsd_m = 0.0;  ///< 0: from flight.yaml, else from the point density
  double search_deg = 5.0;
  double search_m = 10.0;
  std::size_t most_pairs = 3000;
  double patch_gsd = 6.0;
  std::uint64_t seed = 0;
  bool all_returns = true;
  std::vector<int> classes;
};

MatchOptions MakeMatchOptions(const MatchCommand& command, Run& run) {
  MatchOptions options = MakeRunMatchOptions(run);
  if (command.gsd_m > 0.0) options.gsd_m = command.gsd_m;
  options.search_rad = command.search_deg * kRadPerDeg;
  options.search_m = command.search_m;
  options.most_pairs = command.most_pairs;
  options.patch_gsd = command.patch_gsd;
  options.seed = command.seed;
  return options;
}

PointFilter MakePointFilter(const MatchCommand& command) {
  PointFilter filter;
  filter.last_returns = !command.all_returns;
  for (const int each : command.classes) filter.classes.insert(static_cast<std::uint8_t>(each));
  return filter;
}

bool IsFlight(const std::string& what) {
  return fs::is_directory(what) || fs::path(what).extension() == ".yaml";
}

/// Returns whether all are flights; otherwise they are strip files.
bool AreFlights(const std::vector<std::string>& what) {
  return std::ranges::all_of(what, IsFlight);
}

/// Adds the files of a match of one or several scanners.
template <class Matched>
void AddMatchedFlight(const Matched& matched, Run& run) {
  AddMatches(matched, run);
  if (matched.smoothed) {
    AddTrajectoryFiles(*matched.smoothed, &run);
  } else {
    run.AddFile("config.resolved.yaml", FormatFlightConfig(matched.config));
  }
  run.AddFile("flight.matched.yaml",
              FormatFlightFile(WithMatches(matched, run.files().path(), "trajectory.out")));
  if (matched.result.pairs() == 0) FailNoPairs();
}

void MatchFlightCommand(const MatchCommand& command, Run& run) {
  FlightConfig config = ReadFlightConfig(command.what[0], command.common.changes);
  const MatchOptions options = MakeMatchOptions(command, run);
  const PointFilter filter = MakePointFilter(command);
  if (NumScanners(config) > 1) {
    AddMatchedFlight(
        MatchScannerStrips(std::move(config), command.trajectory, options, filter, run), run);
  } else {
    AddMatchedFlight(MatchFlightStrips(std::move(config), command.trajectory, options, filter, run),
                     run);
  }
}

std::string FormatPositions(const MatchResult& result, const BareMatchSource& source) {
  std::string text = "# t_i [s], t_j [s], p_i (3), p_j (3), as in the strips\n";
  for (const StripPairMatch& match : result.strip_pairs) {
    for (const MatchedPair& pair : match.pairs) {
      text += FormatDouble(pair.pair.t_i_s) + ", " + FormatDouble(pair.pair.t_j_s);
      for (const Vector3d& p_m : {pair.pair.u_i_s, pair.pair.u_j_s}) {
        const Vector3d p_c = source.ToFile(p_m);
        for (int i = 0; i < 3; ++i) text += fmt::format(", {:.4f}", p_c[i]);
      }
      text += "\n";
    }
  }
  return text;
}

void MatchBareCommand(const MatchCommand& command, Run& run) {
  if (!command.common.changes.empty()) {
    throw InvalidConfig(
        "--set and --scanner change the flight.yaml of a flight, and strips alone "
        "have none; give the folder of the flight instead");
  }
  std::vector<fs::path> files(command.what.begin(), command.what.end());
  BareMatchSource source(FindMatchStrips(files), MakePointFilter(command));
  const MatchResult result = MatchBareStrips(&source, MakeMatchOptions(command, run));
  run.AddFile("pairs_xyz.txt", FormatPositions(result, source));
  AddMatchFiles(files.front().stem().string(), result, source, run);
  run.AddFile("swaths.json", FormatSwaths(result.swaths));
  if (result.pairs() == 0) FailNoPairs();
}

void MatchFlightsCommand(const MatchCommand& command, Run& run) {
  if (!command.trajectory.empty()) {
    throw InvalidConfig(
        "--trajectory is for one flight: with several flights, each uses its own trajectory (key "
        "trajectory of flight.yaml)");
  }
  MatchFlights(command.what, command.common.changes, MakeMatchOptions(command, run),
               MakePointFilter(command), run);
}

void RunMatch(const MatchCommand& command, Run& run) {
  if (!AreFlights(command.what)) {
    MatchBareCommand(command, run);
  } else if (command.what.size() > 1) {
    MatchFlightsCommand(command, run);
  } else {
    MatchFlightCommand(command, run);
  }
}

Inputs MatchInputs(const MatchCommand& command) {
  if (!AreFlights(command.what)) {
    Inputs inputs;
    for (const std::string& file : command.what) inputs.files.emplace_back(file);
    return inputs;
  }
  if (command.what.size() > 1) return FleetInputs(command.what, command.common.changes, "");
  return FlightInputs(command.what[0], command.common.changes, command.trajectory);
}

}  // namespace

void AddMatch(CLI::App* program, Action* action) {
  auto command = std::make_shared<MatchCommand>();
  CLI::App* app = program->add_subcommand(
      "match", "Finds point-to-point correspondences in overlapping strips");
  app->add_option("FLIGHT|STRIP", command->what,
                  "Flight folder with strips/, or YAML file of a flight; several flights, whose "
                  "strips are matched with each other; or at least two strips (.las, .laz, .txt) "
                  "without a trajectory")
      ->required();
  AddChanges(app, "flight.yaml", "strips_crs=utm:32n", &command->common);
  AddScanner(app, &command->common);
  app->add_option("--trajectory", command->trajectory,
                  "Trajectory (SBET .out or text). Default: that of the flight, else smoothed from "
                  "its inertial and GNSS data");
  app->add_option(
         "--gsd", command->gsd_m,
         "Ground sampling distance [m]. Default: gsd_m of flight.yaml, else from the point "
         "density")
      ->check(PositiveNumber());
  app->add_option("--search-deg", command->search_deg,
                  "Largest boresight error about each axis [deg]")
      ->check(CLI::Range(1e-6, 45.0))
      ->capture_default_str();
  app->add_option("--search-m", command->search_m,
                  "Largest offset between strips without a trajectory [m]")
      ->check(CLI::Range(1e-3, 1e4))
      ->capture_default_str();
  app->add_option("--max-pairs", command->most_pairs, "Maximum number of pairs between two strips")
      ->check(WholeNumber(1, 1000000))
      ->capture_default_str();
  app->add_option("--patch-gsd", command->patch_gsd,
                  "Half the side length of the smallest cells, in ground sampling distances; cells "
                  "are as small as their accuracy permits")
      ->check(CLI::Range(6.0, 200.0))
      ->capture_default_str();
  app->add_option("--classes", command->classes,
                  "Comma-separated LAS classes of the points to use, e.g. 2 for the ground under "
                  "trees. Default: all")
      ->delimiter(',')
      ->check(CLI::Range(0, 255));
  app->add_flag("--all-returns,!--last-returns", command->all_returns,
                "Uses every return of a pulse (default), or only the last");
  app->add_option("--seed", command->seed, "Seed of the random consensus search")
      ->capture_default_str();
  AddCommonOptions(app, &command->common, true);
  app->footer(
      "Example: dn match flight --out matched && dn calibrate matched/flight.matched.yaml --out "
      "result");
  app->callback([command, action] {
    *action = [command] {
      command->common.inputs = MatchInputs(*command);
      return Execute("match", command->common, [&](Run& run) { RunMatch(*command, run); });
    };
  });
}

}  // namespace dn::apps
