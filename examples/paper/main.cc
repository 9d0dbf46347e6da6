// The experiments of Brun & Skaloud, "Scene-agnostic ALS boresight self-calibration", repeated on
// simulated flights with the paper's geometries. Each table also shows the published figures.
//
//   example_paper --distances
//   example_paper [--seeds N] [--sets leg2,lar3] [--node-rate HZ] [--robustness 0]
//                 [--out DIR]
//
// Every flight is simulated and smoothed from raw inertial and GNSS data alone. It is then
// calibrated twice from the same pairs. GH is the Gauss-Helmert adjustment on the smoothed
// trajectory, and DN the dynamic network from the raw data.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <optional>
#include <string>
#include <vector>

#include "distances.h"
#include "on_the_job.h"
#include "published.h"
#include "robustness.h"

namespace {

struct Options {
  std::uint64_t seeds = 1;
  std::vector<std::string> sets;
  std::optional<double> node_rate_hz;
  bool robustness = true;
  bool distances = false;
  std::filesystem::path out = "paper_flights";
};

std::vector<paper::SetResult> CalibrateOnTheJob(const Options& options) {
  std::vector<paper::SetResult> results;
  for (const std::string& set : options.sets) {
    paper::SetResult result{set, {}};
    for (std::uint64_t seed = 1; seed <= options.seeds; ++seed) {
      fmt::print(stderr, "{} flight {} of {}\n", set, seed, options.seeds);
      result.flights.push_back(
          paper::Calibrate(set, seed, options.out / set, options.node_rate_hz));
    }
    results.push_back(std::move(result));
  }
  return results;
}

void Run(const Options& options) {
  if (options.distances) return paper::PrintDistances();
  fmt::print("Simulated flights, seeds 1 to {}; the paper's figures are of real ones.\n",
             options.seeds);
  const std::vector<paper::SetResult> sets = CalibrateOnTheJob(options);
  paper::PrintAttitude(sets);
  paper::PrintAdjustment(sets);
  paper::PrintErrors(sets);
  paper::PrintConsistency(sets);
  paper::PrintCorrelations(sets);
  if (!options.robustness) return;
  paper::AbsorbOffsets(1, options.out);
  paper::StartFarAway(1, options.out);
  paper::ThinPairs(1, options.out);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  for (const paper::PublishedSet& set : paper::kPublished) options.sets.emplace_back(set.name);
  CLI::App app("The paper's experiments on simulated flights");
  app.add_option("--seeds", options.seeds, "flights of each strip set")->check(CLI::PositiveNumber);
  app.add_option("--sets", options.sets, "strip sets")->delimiter(',');
  app.add_option("--node-rate", options.node_rate_hz,
                 "nodes per second of the network within the strips; default: auto")
      ->check(CLI::PositiveNumber);
  app.add_option("--robustness", options.robustness, "offsets, far start and thinned pairs, too");
  app.add_flag("--distances", options.distances,
               "only the distances of the published boresights from their references");
  app.add_option("--out", options.out, "folder of the smoothed trajectories");
  CLI11_PARSE(app, argc, argv);
  try {
    Run(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
  return 0;
}
