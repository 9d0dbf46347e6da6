#include "calibrate_planes.h"

#include <dn/files/strip_files.h>
#include <dn/matching/shared_planes.h>
#include <dn/stopwatch.h>

#include <utility>

#include "match_flight.h"

namespace dn::apps {

std::string WhyNoPlanes(const FlightConfig& config) {
  if (FindStripFiles(config).empty()) return "the flight has no strips";
  if (config.strips_crs == "none") return "strips_crs is 'none': such points have no trajectory";
  return {};
}

PlaneRun CalibrateByPlanes(const Flight& flight, const FlightConfig& config,
                           const std::string& trajectory, Run* run) {
  const Stopwatch watch;
  const MatchedFlight opened = OpenFlightStrips(config, trajectory, kLastReturns, *run);
  SharePlanesOptions options;
  options.strips.gsd_m = flight.config.lidar->gsd_m;
  options.strips.threads = run->options().threads;
  options.strips.progress = [run](const std::string& stage) {
    if (SignalReceived()) throw dn::Interrupted();
    run->progress().Stage(stage);
  };
  SharedPlanes shared = FindSharedPlanes(flight, opened.source.get(), options);
  PlaneRun out;
  Json found = Json::object();
  for (std::size_t s = 0; s < shared.found.size(); ++s) {
    out.strips.push_back(opened.source->strips()[s].name);
    found[out.strips.back()] = shared.found[s];
  }
  out.extraction = {{"found", found},
                    {"matched", shared.matched},
                    {"after_balance", shared.planes.size()},
                    {"spacing_m", shared.spacing_m},
                    {"share_of_overlap", shared.share}};
  run->report()["planes"] = out.extraction;
  out.timings.read_s = watch.seconds();

  GaussHelmertFlightOptions calibrate;
  calibrate.vectors = opened.origin;
  calibrate.threads = run->options().threads;
  calibrate.progress = [run](const std::string& stage) { run->progress().Stage(stage); };
  calibrate.interrupted = [] { return apps::SignalReceived(); };
  out.calibration = CalibratePlanes(flight, std::move(shared.planes), calibrate);
  out.check = AssessModel(flight, &out.calibration);
  out.timings.solve_s = out.calibration.solve_time_s;
  out.timings.covariance_s = out.calibration.covariance_time_s;
  out.timings.total_s = out.timings.read_s + out.timings.solve_s + out.timings.covariance_s;
  return out;
}

}  // namespace dn::apps
