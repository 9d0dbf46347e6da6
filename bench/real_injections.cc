/// real_injections DATA_DIR: inserts known errors into measured flights and diagnoses them with `dn
/// gap`; its figures are in docs/validation/real-data.md.
///
/// A measured flight differs from its model even without inserted errors. It is therefore diagnosed
/// first, and the effects found are added to the model. Then one error after the other is inserted
/// into the data, and the flight is diagnosed again. The size of an error is a multiple of that
/// above which its effect should be named. The size of the error is estimated as the difference of
/// the estimates with and without it.
#include <dn/diagnosis/adapt.h>
#include <dn/diagnosis/diagnose.h>
#include <dn/diagnosis/solution.h>
#include <dn/effects/effect_table.h>
#include <dn/geo/nearest_pose.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dn::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kTimesIdentifiable = 4.0;

/// An effect along one of its axes.
struct Error {
  std::string effect;
  int axis = 0;
  /// Seconds after the first epoch; applies between epochs.
  std::optional<std::pair<double, double>> window_s = std::nullopt;
};

AdjustOptions InsGnss() {
  AdjustOptions options;
  options.with_pairs = false;
  return options;
}

GapDiagnosis DiagnoseQuickly(const Flight& flight, FlightConfig* adapted = nullptr) {
  GapOptions options;
  options.depth = GapOptions::Depth::kQuick;
  const GapResult result = Diagnose(flight, options);
  if (adapted != nullptr) *adapted = result.adapted;
  return result.diagnosis;
}

void PrintVerdict(const std::string& what, const GapDiagnosis& diagnosis) {
  fmt::print("  {}: {}, {} [{}]\n", what, Word(diagnosis.verdict.kind),
             fmt::join(diagnosis.verdict.effects, ", "),
             fmt::join(diagnosis.verdict.credible_set, ", "));
  std::fflush(stdout);
}

// ---- Errors in data -----------------------------------------------------------------------------

void ShiftTags(double offset_s, Flight* flight) {
  std::vector<MapGnssEpoch>& epochs = flight->gnss->epochs;
  for (MapGnssEpoch& epoch : epochs) epoch.t_s += offset_s;
  std::erase_if(epochs, [&](const MapGnssEpoch& epoch) {
    return epoch.t_s < flight->imu->t_begin_s() || epoch.t_s > flight->imu->t_end_s();
  });
}

/// Moves the antenna; the attitude is that of the measured flight.
void MoveAntenna(const Eigen::Vector3d& arm_b_m, const Solution& measured, Flight* flight) {
  std::vector<MapPose> poses;
  for (std::size_t k = 0; k < measured.network().nodes().size(); ++k) {
    poses.push_back(measured.network().trajectory().NodePose(k));
  }
  const std::vector<ImuSample>& samples = flight->imu->samples;
  for (MapGnssEpoch& epoch : flight->gnss->epochs) {
    const Eigen::Quaterniond q_mb = NearestPose(poses, epoch.t_s).q_mb;
    epoch.p_m += q_mb * arm_b_m;
    if (!epoch.velocity_enu_mps) continue;
    const auto sample =
        std::lower_bound(samples.begin(), samples.end() - 1, epoch.t_s,
                         [](const ImuSample& one, double time_s) { return one.t_s < time_s; });
    *epoch.velocity_enu_mps += q_mb * sample->w_ib_b_radps.cross(arm_b_m);
  }
}

void StepPositions(const Eigen::Vector3d& step_m, const std::pair<double, double>& window_s,
                   Flight* flight) {
  for (MapGnssEpoch& epoch : flight->gnss->epochs) {
    if (epoch.t_s < window_s.first || epoch.t_s > window_s.second) continue;
    epoch.p_m += step_m;
  }
}

void ScaleRates(const Eigen::Vector3d& scale, Flight* flight) {
  for (ImuSample& sample : flight->imu->samples) {
    sample.w_ib_b_radps += scale.cwiseProduct(sample.w_ib_b_radps);
  }
}

/// Returns the flight with an error; `value` is in SI.
Flight WithError(const Flight& flight, const Solution& measured, const Error& error,
                 const EffectTimes& times, double value) {
  Flight out = flight;
  const Eigen::Vector3d vector = value * Eigen::Vector3d::Unit(error.axis);
  if (error.effect == "gnss_time_offset") {
    ShiftTags(value, &out);
  } else if (error.effect == "gnss_lever_arm") {
    MoveAntenna(vector, measured, &out);
  } else if (error.effect == "gnss_position_step") {
    StepPositions(vector, *times.window_s, &out);
  } else {
    ScaleRates(vector, &out);
  }
  return out;
}

// ---- Estimates of the errors --------------------------------------------------------------------

struct Estimate {
  double value = 0.0, sigma = 0.0;
};

/// Returns the estimate of the effect as an unknown, in its unit.
Estimate FindEstimate(const Flight& flight, const Error& error, const EffectTimes& times) {
  GapCause cause;
  cause.effect = error.effect;
  cause.times = times;
  cause.estimate =
      Eigen::VectorXd::Zero(static_cast<Eigen::Index>(FindEffect(error.effect)->components.size()));
  Flight adapted = flight;
  adapted.config = Adapted(flight, {cause});
  const Solution solution(adapted, InsGnss());
  for (const UnknownEstimate& unknown : solution.Unknowns()) {
    const auto axis = static_cast<std::size_t>(error.axis);
    if (unknown.name == error.effect) return {unknown.value[axis], unknown.sigma[axis]};
  }
  throw InvalidInput("no estimate of " + error.effect);
}

const DetectionLimit& Limit(const GapDiagnosis& diagnosis, const std::string& effect) {
  const auto at =
      std::find_if(diagnosis.could_still_hide.begin(), diagnosis.could_still_hide.end(),
                   [&](const DetectionLimit& hidden) { return hidden.effect == effect; });
  if (at == diagnosis.could_still_hide.end()) throw InvalidInput("no limit of " + effect);
  return *at;
}

void PrintEstimates(const Flight& flight, const Flight& with, const Error& error,
                    const EffectTimes& times, double size) {
  try {
    const Estimate a = FindEstimate(with, error, times), b = FindEstimate(flight, error, times);
    const double difference = a.value - b.value;
    fmt::print("    estimate {:.4g} +- {:.2g} with it, {:.4g} without: {:.4g}, {:.2f} sigma off\n",
               a.value, a.sigma, b.value, difference, (difference - size) / a.sigma);
  } catch (const InvalidInput& refused) {
    fmt::print("    with it among the unknowns: {}\n", refused.what());
  }
  std::fflush(stdout);
}

void Try(const Flight& flight, const Solution& measured, const GapDiagnosis& before,
         const Error& error) {
  const DetectionLimit& limit = Limit(before, error.effect);
  const EffectSpec& spec = *FindEffect(error.effect);
  const double size =
      kTimesIdentifiable * limit.minimal_identifiable.value_or(2.0 * limit.minimal_detectable);
  EffectTimes times;
  if (error.window_s) {
    const double t0_s = flight.gnss->epochs.front().t_s;
    times.window_s = {{t0_s + error.window_s->first, t0_s + error.window_s->second}};
  }
  const Flight with = WithError(flight, measured, error, times, size * spec.components[0].to_si);
  fmt::print("\n  {} of {:.3g} {} on axis {}: detectable {:.3g}, identifiable {:.3g}\n",
             error.effect, size, limit.unit, error.axis + 1, limit.minimal_detectable,
             limit.minimal_identifiable.value_or(NAN));
  const GapDiagnosis after = DiagnoseQuickly(with);
  PrintVerdict("with it", after);
  for (const GapCause& cause : after.causes) {
    if (cause.effect != error.effect) continue;
    fmt::print("    probability {:.2f}, {:.1f} nats\n", cause.posterior, cause.log_evidence);
  }
  PrintEstimates(flight, with, error, times, size);
}

void TryAll(const fs::path& folder, const std::vector<Error>& errors) {
  FlightNeeds needs;
  needs.imu = needs.gnss = true;
  Flight flight = ReadFlight(folder, needs);
  fmt::print("\n== {}\n", flight.config.name);
  FlightConfig adapted = flight.config;
  PrintVerdict("as measured", DiagnoseQuickly(flight, &adapted));
  flight.config = adapted;
  const GapDiagnosis before = DiagnoseQuickly(flight);
  PrintVerdict("with that in the model", before);
  const Solution measured(flight, InsGnss());
  for (const Error& error : errors) Try(flight, measured, before, error);
}

void Run(const fs::path& data) {
  TryAll(data / "thor75", {{"gnss_lever_arm", 1},
                           {"gyro_scale_factor", 2},
                           {"gnss_position_step", 0, {{200.5, 260.5}}}});
  TryAll(data / "walk", {{"gnss_time_offset", 0},
                         {"gyro_scale_factor", 2},
                         {"gnss_position_step", 1, {{50.1, 80.1}}}});
}

}  // namespace
}  // namespace dn::bench

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: real_injections DATA_DIR   (the folder with thor75 and walk)\n");
    return 2;
  }
  try {
    dn::bench::Run(argv[1]);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "real_injections: {}\n", error.what());
    return 1;
  }
}
