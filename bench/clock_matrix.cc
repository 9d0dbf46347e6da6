/// clock_matrix [DATA_DIR]: estimates clock errors between sensors, of simulated flights, and of
/// measured flights whose GNSS tags are shifted. Its figures are in docs/validation/clocks.md.
#include <dn/adjustment/unknown_noise.h>
#include <dn/diagnosis/solution.h>
#include <dn/imu/unknown_imu.h>
#include <dn/report/value_words.h>
#include <dn/sim/random.h>
#include <dn/sim/simulate.h>
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "testing/short_flights.h"

namespace dn::bench {
namespace {

namespace fs = std::filesystem;

/// A clock error to find.
struct ClockCase {
  std::string platform;  ///< drone or aircraft
  std::string sensor;    ///< gnss or lidar
  double sigma_m;        ///< horizontal, of a GNSS position
  double offset_s;
  double drift_ppm;
  double jitter_s;  ///< rms of the errors of single tags
};

void Jitter(double rms_s, SimulatedFlight* sim) {
  if (rms_s == 0.0) return;
  Random random(7, "jitter");
  for (MapGnssEpoch& epoch : sim->flight.gnss->epochs) epoch.t_s += rms_s * random.Normal();
}

SimulatedFlight FlyCase(const ClockCase& one, unsigned seed) {
  const std::string effects = fmt::format(
      "effects: [{{effect: {0}_time_offset, value: {1}}}, "
      "{{effect: {0}_time_drift, value: {2}}}]\n",
      one.sensor, one.offset_s, one.drift_ppm);
  Scenario scenario = one.platform == "drone" ? testing::DroneScenario(effects)
                                              : testing::AircraftScenario(effects);
  scenario.gnss.sigma_enu_m = one.sigma_m * Eigen::Vector3d(1.0, 1.0, 1.5);
  SimulatedFlight sim = testing::Fly(scenario, seed);
  Jitter(one.jitter_s, &sim);
  return sim;
}

/// Returns the clock that the adjustment of a flight reports.
std::optional<ClockEstimate> FindClock(const Flight& flight, bool with_pairs, bool of_gnss) {
  AdjustOptions options;
  options.with_pairs = with_pairs;
  options.threads = 2;
  const Solution solution(flight, options);
  const Clocks& clocks = solution.model_check().clocks;
  return of_gnss ? clocks.gnss : clocks.lidar;
}

/// Returns the beginning of a message, without its advice.
std::string Finding(const std::string& message) { return message.substr(0, message.find(": ")); }

/// Returns the estimate, or what the program says instead. An offset is compared without a drift
/// if there is none.
std::string Outcome(const Flight& flight, bool with_pairs, const ClockCase& truth,
                    double known_s = 0.0) {
  try {
    const auto both = FindClock(flight, with_pairs, truth.sensor == "gnss");
    if (!both) return "not determined";
    const ClockEstimate clock = truth.drift_ppm == 0.0 ? both->WithoutDrift() : *both;
    const double off = (clock.offset_s - known_s - truth.offset_s) / clock.sigma_offset_s;
    std::string text = fmt::format("{} s, off by {:.1f} sigma",
                                   FormatWithSigma(clock.offset_s, clock.sigma_offset_s), off);
    if (truth.drift_ppm == 0.0) return text;
    return text + fmt::format("; {} ppm, off by {:.1f} sigma",
                              FormatWithSigma(1e6 * clock.drift, 1e6 * clock.sigma_drift),
                              (1e6 * clock.drift - truth.drift_ppm) / (1e6 * clock.sigma_drift));
  } catch (const Error& error) {
    return Finding(error.what());
  }
}

void RunSimulated() {
  for (const char* platform : {"drone", "aircraft"}) {
    for (const double sigma_m : {0.015, 2.0}) {
      for (const double offset_s : {1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0}) {
        for (const auto& [drift_ppm, jitter_s] : {std::pair(0.0, 0.0), {200.0, 0.0}, {0.0, 3e-3}}) {
          const ClockCase one{platform, "gnss", sigma_m, offset_s, drift_ppm, jitter_s};
          const SimulatedFlight sim = FlyCase(one, 3);
          fmt::print("{:<9} gnss  {:5.3f} m {:>7g} s {:>4g} ppm {:>5g} s jitter: {}\n", platform,
                     sigma_m, offset_s, drift_ppm, jitter_s, Outcome(sim.flight, false, one));
          std::fflush(stdout);
        }
      }
    }
    for (const double offset_s : {1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0}) {
      const ClockCase one{platform, "lidar", 0.015, offset_s, 0.0, 0.0};
      const SimulatedFlight sim = FlyCase(one, 3);
      fmt::print("{:<9} lidar {:>7g} s: {}\n", platform, offset_s, Outcome(sim.flight, true, one));
      std::fflush(stdout);
    }
  }
}

Flight ReadUnknown(const fs::path& folder) {
  Flight flight = ReadFlight(folder, {.imu = true, .gnss = true});
  flight.config.imu->grade = kUnknownGrade;
  flight.config.imu->model = UnknownImu();
  return flight;
}

void RunMeasured(const fs::path& data) {
  AdjustOptions options;
  options.with_pairs = false;
  options.threads = 2;
  for (const char* name : {"thor75", "walk", "psins-car"}) {
    Flight flight = ReadUnknown(data / name);
    EstimateNoise(options, &flight);
    const auto own = FindClock(flight, false, true);
    const double own_s = own ? own->WithoutDrift().offset_s : 0.0;
    fmt::print("{:<9} as it is: {:.4f} s\n", name, own_s);
    for (const double offset_s : {1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0}) {
      Flight shifted = ReadUnknown(data / name);
      for (MapGnssEpoch& epoch : shifted.gnss->epochs) epoch.t_s += offset_s;
      const ClockCase one{name, "gnss", 0.0, offset_s, 0.0, 0.0};
      std::string outcome;
      try {
        EstimateNoise(options, &shifted);
        outcome = Outcome(shifted, false, one, own_s);
      } catch (const Error& error) {
        outcome = Finding(error.what());
      }
      fmt::print("{:<9} {:>7g} s: {}\n", name, offset_s, outcome);
      std::fflush(stdout);
    }
  }
}

}  // namespace
}  // namespace dn::bench

int main(int argc, char** argv) {
  try {
    if (argc > 1) {
      dn::bench::RunMeasured(argv[1]);
    } else {
      dn::bench::RunSimulated();
    }
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "clock_matrix: error: {}\n", error.what());
    return 1;
  }
}
