#include "noise_output.h"

#include <dn/report/value_words.h>
#include <fmt/format.h>

namespace dn::apps {
namespace {

// Noise that has grown more than this may be an error that the model leaves out.
constexpr double kUsualGrowth = 5.0;

void WarnIfGrown(const NoiseSize& size, Run* run) {
  if (!size.name.ends_with(".white") || size.value <= kUsualGrowth * size.start) return;
  run->progress().Warn(
      fmt::format("the residuals need {} of {} {}, {:.0f} times the value in flight.yaml: an "
                  "error that the model leaves out looks the same (clock, axes, lever arm, "
                  "vibration); run dn check and dn gap",
                  size.name, FormatWithSigma(size.value, size.value * size.relative_sigma),
                  size.unit, size.value / size.start));
}

}  // namespace

std::optional<NoiseSizes> EstimateUnknownNoise(AdjustOptions options, Flight* flight, Run* run) {
  if (!HasUnknownNoise(flight->config)) return std::nullopt;
  options.progress = [run](const std::string& stage, int iterations) {
    run->progress().Stage("estimating noise: " + stage,
                          iterations > 0 ? fmt::format("{} iterations", iterations) : "");
  };
  NoiseSizes noise = EstimateNoise(options, flight);
  if (!noise.converged) {
    run->progress().Warn(
        fmt::format("imu.grade is unknown, and the estimated noise still changes after {} rounds; "
                    "state the figures of a data sheet (imu.gyro, imu.accel)",
                    noise.rounds));
  }
  for (const NoiseSize& size : noise.sizes) WarnIfGrown(size, run);
  return noise;
}

void AddNoise(const NoiseSizes& noise, Json* json) {
  Json& list = (*json)["noise"] = Json::array();
  for (const NoiseSize& size : noise.sizes) {
    list.push_back({{"name", size.name},
                    {"unit", size.unit},
                    {"start", size.start},
                    {"value", size.value},
                    {"sigma", size.value * size.relative_sigma},
                    {"redundancy", size.redundancy}});
  }
  if (!noise.slow_gnss) return;
  (*json)["slow_gnss"] = {{"sigma_enu_m", ToJson(noise.slow_gnss->sigma_enu_m)},
                          {"tau_s", noise.slow_gnss->tau_s}};
}

void PrintNoise(const std::optional<NoiseSizes>& noise) {
  if (!noise) return;
  fmt::print("noise estimated from the data ({} rounds)\n", noise->rounds);
  for (const NoiseSize& size : noise->sizes) {
    fmt::print("  {:<24} {} {}\n", size.name,
               FormatWithSigma(size.value, size.value * size.relative_sigma),
               size.unit == "1" ? "" : size.unit);
  }
  if (!noise->slow_gnss) return;
  const Eigen::Vector3d& sigma_m = noise->slow_gnss->sigma_enu_m;
  fmt::print("  {:<24} {:.2g}, {:.2g}, {:.2g} m (east, north, up), correlated over {:.2g} s\n",
             "gnss.processes, slow", sigma_m.x(), sigma_m.y(), sigma_m.z(),
             noise->slow_gnss->tau_s);
}

}  // namespace dn::apps
