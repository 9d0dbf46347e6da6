#include "fleet_clouds.h"

#include <dn/geo/local_frame.h>
#include <fmt/format.h>

#include "flight_processes.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

/// Georeferences the strips of one flight; returns why that failed, if it did.
std::string GeoreferenceOne(const FleetClouds& clouds, const std::vector<std::string>& changes,
                            int threads) {
  const Eigen::Vector3d deg = clouds.boresight_rad * kDegPerRad;
  const fs::path out = clouds.folder / "clouds";
  const int exit_code =
      RunIntoFolder({"georef", clouds.flight,
                     fmt::format("--boresight={:.12g},{:.12g},{:.12g}", deg.x(), deg.y(), deg.z()),
                     "--result", (clouds.folder / "result.json").string(), "--anyway"},
                    changes, threads, out);
  if (exit_code != 0) return FailureText(exit_code, out, "its georeferencing");
  std::error_code none;
  fs::remove(LogFile(out), none);
  return {};
}

}  // namespace

void GeoreferenceFlights(const std::vector<FleetClouds>& flights,
                         const std::vector<std::string>& changes, int at_once, Run* run) {
  std::vector<std::string> failures(flights.size());
  ForFlights(flights.size(), at_once, "georeferencing flights", run,
             [&](std::size_t k, int threads) {
               failures[k] = GeoreferenceOne(flights[k], changes, threads);
             });
  std::string failed;
  for (std::size_t k = 0; k < flights.size(); ++k) {
    const FleetClouds& clouds = flights[k];
    if (failures[k].empty()) {
      fmt::print("clouds of flight {}: {}\n", clouds.name, (clouds.folder / "clouds").string());
    } else {
      failed += (failed.empty() ? "" : "; ") + clouds.name + ": " + failures[k];
    }
  }
  if (failed.empty()) return;
  throw FailedWithResults("clouds_failed", "not all flights could be georeferenced: " + failed);
}

}  // namespace dn::apps
