#include "fixed_trajectory.h"

#include <dn/adjustment/adjust.h>
#include <dn/distributions.h>
#include <dn/error.h>
#include <dn/interrupted.h>
#include <dn/names.h>
#include <dn/rotation.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

namespace dn::adjustment_internal {
namespace {

using Eigen::Vector3d;

constexpr double kCrossingRad = 20.0 * kRadPerDeg;
constexpr double kHeightPerRange = 0.05;
constexpr double kEvidentNats = 3.0;  // odds of 20 to 1
// An error of half the pairs' sigma increases the misclosures by 12 %; a smaller one counts as
// noise.
constexpr double kNoiseLevel = 0.5;
// Twice the attitude accuracy of the tactical-grade flights in the paper, which is the lowest
// accuracy within its operating envelope.
constexpr double kEnvelopeDeg[] = {0.01, 0.01, 0.02};
// If the reliable sigma over the formal one is larger than this, the result says why.
constexpr double kMuchWider = 1.2;

struct StripMotion {
  double course_rad = 0.0;
  double height_m = 0.0;
};

std::vector<StripMotion> Motions(const Flight& flight, const std::vector<StripInterval>& strips) {
  std::vector<StripMotion> motions;
  for (const StripInterval& strip : strips) {
    const double t_s = 0.5 * (strip.t0_s + strip.t1_s);
    if (!flight.trajectory->Covers(t_s)) continue;
    const NavPoint& point = flight.trajectory->FirstPointAtOrAfter(t_s);
    motions.push_back({std::atan2(point.v_ned_mps.y(), point.v_ned_mps.x()), point.position.h_m});
  }
  return motions;
}

}  // namespace

void Announce(const GaussHelmertFlightOptions& options, const std::string& stage) {
  if (options.interrupted && options.interrupted()) throw Interrupted();
  if (options.progress) options.progress(stage);
}

void ExpectConverged(bool converged, int iterations, const char* method, const char* data) {
  if (converged) return;
  throw NotConverged(std::string(method) + " did not converge in " + std::to_string(iterations) +
                     " iterations; check the mounting matrix, and that the " + data +
                     " belong to this flight");
}

void CheckTrajectory(const Flight& flight) {
  if (!flight.trajectory || !flight.trajectory->notes().adjusted_with_lidar) return;
  throw InvalidInput(
      "the trajectory was adjusted together with lidar pairs (by `dn calibrate`), and the lidar "
      "data would be used a second time; make one without them with `dn smooth " +
          QuoteForShell(flight.config.folder.string()) +
          " --out DIR` and give it with --trajectory DIR/trajectory.out",
      {(flight.config.folder / flight.config.trajectory->file).string()});
}

void CheckEstimate(const FlightConfig& config, const char* method) {
  const auto is_boresight = [](const EstimateEntry& entry) { return entry.unknown == "boresight"; };
  if (std::none_of(config.estimate.begin(), config.estimate.end(), is_boresight)) {
    throw InvalidConfig(std::string(method) +
                        " estimates the boresight, which `estimate` does not name; add it there");
  }
}

TrajectoryErrorOptions MakeScatterOptions(const TrajectoryAccuracy& accuracy,
                                          const std::vector<StripInterval>& strips) {
  TrajectoryErrorOptions options;
  options.covariance = accuracy.covariance;
  options.sigma_ned_m = accuracy.sigma_ned_m;
  options.sigma_rph_rad = accuracy.sigma_rph_rad;
  options.sigma_source = accuracy.sigma_source;
  for (const StripInterval& strip : strips) options.strip_begin_s.push_back(strip.t0_s);
  std::sort(options.strip_begin_s.begin(), options.strip_begin_s.end());
  return options;
}

StripDiversity DescribeStrips(const Flight& flight, const std::vector<StripInterval>& strips,
                              double mean_range_m) {
  const std::vector<StripMotion> motions = Motions(flight, strips);
  StripDiversity diversity;
  diversity.strips = static_cast<int>(strips.size());
  for (const StripMotion& a : motions) {
    for (const StripMotion& b : motions) {
      const double turn = std::remainder(a.course_rad - b.course_rad, std::numbers::pi);
      if (std::abs(turn) >= kCrossingRad) diversity.crossing = true;
      if (a.height_m - b.height_m >= kHeightPerRange * mean_range_m) diversity.heights = true;
    }
  }
  return diversity;
}

facts::AttitudeInPairs::Size ClassifyAttitudeError(double change_m, double noise_m,
                                                   const Vector3d& sigma_rph_rad) {
  using Size = facts::AttitudeInPairs::Size;
  if (change_m <= kNoiseLevel * noise_m) return Size::kNoise;
  const Vector3d envelope_rad = kRadPerDeg * Eigen::Map<const Vector3d>(kEnvelopeDeg);
  const bool tactical = (sigma_rph_rad.array() <= envelope_rad.array()).all();
  return tactical ? Size::kCovered : Size::kAbsorbed;
}

void AddGeometryReasons(const facts::AttitudeInPairs& attitude, const StripDiversity& diversity,
                        BoresightResult* boresight) {
  if (attitude.size == facts::AttitudeInPairs::Size::kAbsorbed &&
      boresight->verdict == Verdict::kCalibrated) {
    boresight->verdict = Verdict::kAbsorbed;
  }
  boresight->reasons.push_back({attitude});
  if (!diversity.sufficient()) {
    boresight->reasons.push_back({facts::StripsAlike{diversity.strips}});
  }
}

void AddNotEstimated(const FlightConfig& config, const std::vector<std::string>& estimated,
                     const char* because, BoresightResult* boresight) {
  for (const EstimateEntry& entry : config.estimate) {
    if (HasName(estimated, entry.unknown)) continue;
    boresight->reasons.push_back({facts::NotEstimated{entry.unknown, because}});
  }
}

void AddBeamsNotEstimated(const FlightConfig& config, const std::vector<BeamCorrections>& beams,
                          BoresightResult* boresight) {
  if (!config.lidar || !config.lidar->beams || !beams.empty()) return;
  boresight->reasons.push_back({facts::NotEstimated{
      "the error of each beam", config.gh.libor_compat
                                    ? "gh.libor_compat has the model of libor, without beams"
                                    : "the data name no beams, or lidar.beams has sigmas of 0"}});
}

void AddWideningReason(const CorrelatedErrorCovariance& scatter, const TrajectoryAccuracy& accuracy,
                       const Eigen::Matrix3d& constant_rad2, BoresightResult* boresight) {
  facts::SigmasWidened fact;
  fact.ratio = boresight->sigma_rad().cwiseQuotient(*boresight->sigma_scaled_rad);
  if (fact.ratio.maxCoeff() < kMuchWider) return;
  fact.scaled_rad = *boresight->sigma_scaled_rad;
  fact.correlated_rad = scatter.covariance_rad2.diagonal().cwiseSqrt();
  fact.constant_rad = constant_rad2.diagonal().cwiseSqrt();
  fact.source = accuracy.source;
  fact.tau_stated = accuracy.covariance.has_value();
  fact.tau_shown = scatter.evidence_nats > kEvidentNats;
  fact.tau_s = scatter.tau_s;
  boresight->reasons.push_back({std::move(fact)});
}

}  // namespace dn::adjustment_internal
