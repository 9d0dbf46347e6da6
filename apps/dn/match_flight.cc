#include "match_flight.h"

#include <dn/error.h>
#include <dn/files/flight.h>
#include <dn/files/scanners.h>
#include <dn/files/strip_files.h>
#include <dn/lidar/strip_io.h>
#include <dn/matching/loop_redundancy.h>
#include <dn/matching/match_output.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "given_trajectory.h"
#include "swath_files.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

constexpr double kLeastSharedError = 0.3;  // of a stated sigma: adds less than 5 % to it

void WarnIf(const std::string& warning, Run& run) {
  if (!warning.empty()) run.progress().Warn(warning);
}

/// Checks the strips and returns the least reliable origin of their laser vectors.
VectorOrigin CheckStrips(const std::vector<fs::path>& files, const std::string& strips_crs,
                         const StripGeoreferencing& made_with, Run& run) {
  VectorOrigin weakest;
  std::string first;
  std::size_t assumed = 0;
  for (const fs::path& file : files) {
    const auto strip = OpenStrip(file);
    WarnIf(CheckStripCrs(strip->crs(), strips_crs, file), run);
    const VectorOrigin origin = FindVectorOrigin(*strip, made_with, file);
    weakest = Weaker(weakest, origin);
    if (origin.kind != VectorOrigin::Kind::kAssumed) continue;
    if (++assumed == 1) first = file.filename().string();
  }
  const std::string others = assumed > 1 ? fmt::format(" (as {} more)", assumed - 1) : "";
  WarnIf(VectorWarning(weakest, first + others), run);
  return weakest;
}

std::string Triple(const Json& v) {
  return fmt::format("{:.3f}, {:.3f}, {:.3f}", v[0].get<double>(), v[1].get<double>(),
                     v[2].get<double>());
}

std::string Strips(const Json& strips) {
  std::string text;
  for (const Json& strip : strips) text += (text.empty() ? "" : "-") + strip.get<std::string>();
  return text;
}

void Print(const Json& match) {
  const auto rms = [](const Json& pair, const char* when) {
    const Json& misalignment = pair["misalignment"];
    return misalignment.is_null() || misalignment[when].is_null()
               ? std::string("-")
               : fmt::format("{:.3f}", misalignment[when]["rms_m"].get<double>());
  };
  const auto offset = [](const Json& pair, const char* what) {
    return pair["offset"].is_null() ? std::string("-") : Triple(pair["offset"][what]);
  };
  std::size_t width = 12;
  for (const Json& pair : match["strip_pairs"]) {
    width = std::max(width, Strips(pair["strips"]).size());
  }
  fmt::print("{:<{}} {:>10} {:>6} {:>10} {:>6} {:>8} {:>13} {:>7} {:>22} {:>22}\n", "strips", width,
             "candidates", "found", "registered", "pairs", "surfaces", "apart rms [m]", "after",
             "shift E, N, U [m]", "scatter E, N, U [m]");
  for (const Json& pair : match["strip_pairs"]) {
    const Json& counts = pair["counts"];
    fmt::print("{:<{}} {:>10} {:>6} {:>10} {:>6} {:>8} {:>13} {:>7} {:>22} {:>22}\n",
               Strips(pair["strips"]), width, counts["candidates"].get<long>(),
               counts["found"].get<long>(), counts["registered"].get<long>(),
               counts["pairs"].get<long>(), counts["surface_pairs"].get<long>(),
               rms(pair, "before"), rms(pair, "after"), offset(pair, "shift_enu_m"),
               offset(pair, "scatter_enu_m"));
  }
  for (const Json& loop : match["loops"]) {
    fmt::print("loop {:<12} closes to {} m (sigma {})\n", Strips(loop["strips"]),
               Triple(loop["closure_enu_m"]), Triple(loop["sigma_enu_m"]));
  }
}

/// Returns the less reliable origin of the laser vectors of two strips.
VectorOrigin WeakerOrigin(const MatchResult& result, const StripPairMatch& match) {
  return Weaker(*result.strips[match.i].origin, *result.strips[match.j].origin);
}

/// Returns the name of the file of two strips in a folder.
std::string FileIn(const std::string& folder, const MatchSource& source,
                   const StripPairMatch& match) {
  return folder + "/" + source.strips()[match.i].name + "_" + source.strips()[match.j].name +
         ".txt";
}

std::string PairFile(const MatchSource& source, const StripPairMatch& match) {
  return FileIn("lidar", source, match);
}

std::string SurfaceFile(const MatchSource& source, const StripPairMatch& match) {
  return FileIn("surfaces", source, match);
}

/// Stages the file of the surface pairs of two strips; without any there is no file.
void AddSurfaceFile(const MatchedFlight& matched, const StripPairMatch& match, Run& run) {
  if (match.surfaces.empty()) return;
  std::vector<SurfacePair> pairs;
  const double offset_s = matched.config.lidar->time_offset_s;
  for (const MatchedSurface& surface : match.surfaces) {
    pairs.push_back(surface.pair);
    pairs.back().ends.t_i_s += offset_s;
    pairs.back().ends.t_j_s += offset_s;
  }
  run.AddFile(SurfaceFile(*matched.source, match),
              FormatSurfacePairs(pairs, WeakerOrigin(matched.result, match)));
}

}  // namespace

void ExpectMatchable(const FlightConfig& config) {
  const FileLocation where{config.file.string()};
  if (!config.lidar) {
    throw InvalidConfig("the section 'lidar' is missing, and this command needs it", where);
  }
  if (config.strips_crs == "none") {
    throw InvalidConfig(
        "strips_crs is 'none': such points have no trajectory; match their files alone with "
        "dn match STRIP STRIP --out DIR, or write map, utm:ZONEn, utm:ZONEs or ecef",
        where);
  }
}

FlightPath FindFlightPath(FlightConfig* config, const std::string& trajectory, Run& run) {
  FlightPath path;
  const bool own = HasTrajectory(*config);
  if (own || !trajectory.empty()) {
    run.progress().Stage("reading " + config->folder.string());
    Flight flight =
        ReadFlight(own ? *config : WithTrajectory(*config, trajectory), {.trajectory = true});
    path.frame = flight.frame;
    path.options.trajectory = std::move(*flight.trajectory);
    *config = WithTrajectory(flight.config, trajectory);
    if (own && !trajectory.empty()) {
      path.options.made_by =
          std::exchange(path.options.trajectory, ReadTrajectory(trajectory, TextColumns(*config)));
    }
    return path;
  }
  if (!config->imu || !config->gnss) {
    throw InvalidInput(
        "the flight has neither a trajectory nor inertial and GNSS data to compute one; give one "
        "with --trajectory FILE, or match bare strips: dn match STRIP STRIP --out DIR");
  }
  path.smoothed = AdjustFlight(*config, false, &run);
  path.frame = path.smoothed->flight.frame;
  path.options.trajectory = Trajectory(path.smoothed->trajectory);
  return path;
}

MatchedFlight OpenStrips(FlightConfig config, const FlightPath& path, const PointFilter& filter,
                         Run& run) {
  const std::vector<fs::path> files = RequireStripFiles(config);
  const StripGeoreferencing made_with = StripsGeoreferencing(config);
  MatchedFlight matched;
  matched.origin = CheckStrips(files, config.strips_crs, made_with, run);
  StripSourceOptions options = path.options;
  options.made_with = made_with;
  options.time_span_s = config.time_span_s;
  options.time_offset_s = config.lidar->time_offset_s;
  options.filter = filter;
  matched.source = std::make_unique<FlightMatchSource>(options, path.frame, config.strips_crs,
                                                       FindMatchStrips(files));
  matched.config = std::move(config);
  return matched;
}

MatchedFlight OpenFlightStrips(FlightConfig config, const std::string& trajectory,
                               const PointFilter& filter, Run& run) {
  ExpectMatchable(config);
  ExpectOneScanner(config, "matching");
  run.ReadsStrips();
  FlightPath path = FindFlightPath(&config, trajectory, run);
  MatchedFlight matched = OpenStrips(std::move(config), path, filter, run);
  matched.smoothed = std::move(path.smoothed);
  return matched;
}

void MatchOpened(MatchOptions options, MatchedFlight* matched) {
  const FlightConfig& config = matched->config;
  if (!options.gsd_m) options.gsd_m = config.lidar->gsd_m;
  if (config.lidar->beams) options.beams = static_cast<int>(config.lidar->beams->count);
  const TrajectoryConfig stated = config.trajectory.value_or(TrajectoryConfig());
  options.sigma_ned_m << stated.sigma_xy_m, stated.sigma_xy_m, stated.sigma_z_m;
  options.sigma_rph_rad << stated.sigma_rp_rad, stated.sigma_rp_rad, stated.sigma_y_rad;
  matched->result = MatchFlight(matched->source.get(), options);
}

MatchedFlight MatchFlightStrips(FlightConfig given, const std::string& trajectory,
                                const MatchOptions& options, const PointFilter& filter, Run& run) {
  MatchedFlight matched = OpenFlightStrips(std::move(given), trajectory, filter, run);
  MatchOpened(options, &matched);
  InflateLoops(&matched.result);
  return matched;
}

/// Returns the error of pairs that the sigma of the range offset of plants leaves, as a sigma of
/// lidar_range_offset: all pairs share it.
double SharedRangeSigma(const MatchResult& result) {
  const auto& plants = result.plant_offset;
  return plants ? plants->share * plants->sigma_m : 0.0;
}

/// Adds a shared error of this size to the prior of lidar_range_offset, unless the flight has the
/// pure model.
void AddRangeOffset(double sigma_m, FlightConfig* config) {
  const double stated_m = MakeUnmodelledPrior(*config).Sigma(EffectId::kLidarRangeOffset)[0];
  if (config->unmodelled.none || sigma_m < kLeastSharedError * stated_m) return;
  std::vector<UnmodelledSize>& sizes = config->unmodelled.sizes;
  std::erase_if(
      sizes, [](const UnmodelledSize& size) { return size.effect == EffectId::kLidarRangeOffset; });
  sizes.push_back({EffectId::kLidarRangeOffset, {std::hypot(stated_m, sigma_m)}});
}

MatchOptions MakeRunMatchOptions(Run& run) {
  MatchOptions options;
  options.threads = run.options().threads;
  options.progress = [&run](const std::string& stage, const std::string& done) {
    if (SignalReceived()) throw dn::Interrupted();
    run.progress().Stage(stage, done);
  };
  return options;
}

FlightConfig WithMatches(const MatchedFlight& matched, const fs::path& folder,
                         const std::string& trajectory) {
  FlightConfig config = matched.config;
  const fs::path absolute = fs::absolute(folder);
  config.lidar->p2p.clear();
  config.lidar->surface_pairs.clear();
  for (const StripPairMatch& match : matched.result.strip_pairs) {
    if (!match.pairs.empty()) {
      config.lidar->p2p.push_back((absolute / PairFile(*matched.source, match)).string());
    }
    if (!match.surfaces.empty()) {
      config.lidar->surface_pairs.push_back(
          (absolute / SurfaceFile(*matched.source, match)).string());
    }
  }
  AddRangeOffset(SharedRangeSigma(matched.result), &config);
  return matched.smoothed ? WithTrajectory(config, (absolute / trajectory).string()) : config;
}

void AddMatchFiles(const std::string& name, const MatchResult& result, const MatchSource& source,
                   Run& run, const Json& more) {
  Json match = MatchJson(name, result, source);
  match.update(more);
  for (const StripPairMatch& pair : result.strip_pairs) {
    run.AddFile(FileIn("matches", source, pair), FormatMatches(pair));
    if (!pair.surfaces.empty()) {
      run.AddFile(FileIn("surface_matches", source, pair), FormatSurfaceMatches(pair));
    }
  }
  run.AddFile("match.json", FormatJson(match));
  run.report()["flight"] = name;
  run.report()["matching"] = match["counts"];
  Print(match);
}

void AddPairFile(const std::string& name, const StripPairMatch& match, const MatchResult& result,
                 const EndOffsets& offsets, Run& run) {
  if (match.pairs.empty()) return;
  std::vector<LidarPair> pairs;
  for (const MatchedPair& pair : match.pairs) {
    pairs.push_back(pair.pair);
    pairs.back().t_i_s += offsets.i_s;
    pairs.back().t_j_s += offsets.j_s;
  }
  run.AddFile(name, FormatPairs(pairs, WeakerOrigin(result, match)));
}

void AddMatches(const MatchedFlight& matched, Run& run) {
  const double offset_s = matched.config.lidar->time_offset_s;
  for (const StripPairMatch& match : matched.result.strip_pairs) {
    AddPairFile(PairFile(*matched.source, match), match, matched.result, {offset_s, offset_s}, run);
    AddSurfaceFile(matched, match, run);
  }
  AddMatchFiles(matched.config.name, matched.result, *matched.source, run);
  AddSwathFiles(matched.result.swaths, matched.source->frame(), &run);
}

void AddSmoothedTrajectory(const FlightRun& smoothed, const std::string& folder, Run& run) {
  run.AddFile(folder + "trajectory.out", FormatSbet(smoothed.trajectory.points(), false));
  run.AddFile(folder + "trajectory_sigma.txt",
              FormatTrajectorySigma(smoothed.solution->CheckedSigmas()));
}

void FailNoPairs() {
  throw FailedWithResults(
      "no_pairs",
      "no correspondence was found; match.json has the counts of every stage. If there "
      "are no candidates, the ground has too little relief (water, flat fields). If candidates "
      "exist but none is "
      "registered, check that gsd_m fits the points and that the strips are of one flight");
}

}  // namespace dn::apps
