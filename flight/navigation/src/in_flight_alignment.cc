#include "in_flight_alignment.h"

#include <dn/builder/gnss_factors.h>
#include <dn/fit_rotation.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace dn::navigation_internal {
namespace {

// Noise of the second differences, as an acceleration, for which their spacing is chosen.
constexpr double kSecondDifferenceMps2 = 0.1;
// Largest ratio of neighbouring spacings for which this noise is still a good approximation.
constexpr double kMostUneven = 2.0;
// A span must contain this many spacings. If the noise asks for longer ones, the tilts still follow
// from gravity, and sigma_heading_rad says how much of the heading is known.
constexpr double kFewestSpacings = 6.0;
constexpr double kShortestSpacingS = 1.0;

}  // namespace

std::vector<Antenna> AntennaTrack(const Flight& flight, const TimeInterval& span) {
  std::vector<Antenna> track;
  for (const MapGnssEpoch& epoch : flight.gnss->epochs) {
    if (epoch.t_s >= span.t0_s - 1e-6 && epoch.t_s <= span.t1_s + 1e-6) {
      track.push_back({epoch.t_s, epoch.p_m});
    }
  }
  return track;
}

double AlignmentSpacing(const Flight& flight) {
  const double sigma_m = TypicalGnssSigma(flight);
  return std::max(kShortestSpacingS, std::sqrt(std::sqrt(6.0) * sigma_m / kSecondDifferenceMps2));
}

InFlight AlignInFlight(const Flight& flight, const TimeInterval& span, const ImuCorrection& bias) {
  const std::vector<Antenna> track = AntennaTrack(flight, span);
  const LocalFrame& frame = flight.frame;
  const Eigen::Vector3d l_b = flight.config.gnss->lever_arm_b_m;
  const double sigma_m = TypicalGnssSigma(flight);
  const double spacing_s =
      std::max(kShortestSpacingS,
               std::min(AlignmentSpacing(flight), (span.t1_s - span.t0_s) / kFewestSpacings));
  Eigen::Matrix3d B = Eigen::Matrix3d::Zero();
  double horizontal2 = 0.0, squares = 0.0;
  int used = 0;
  Eigen::Quaterniond q_a0 = Eigen::Quaterniond::Identity();
  std::size_t i0 = 0;
  const auto inertial = [&](const Antenna& a) {
    const Eigen::Quaterniond C = Exp(Eigen::Vector3d(frame.w_ie_m() * (a.t_s - track.front().t_s)));
    return Eigen::Vector3d(C * (frame.r0_m() + a.p_m));
  };
  const auto later = [&](std::size_t i) {
    std::size_t j = i + 1;
    while (j < track.size() && track[j].t_s - track[i].t_s < spacing_s - 1e-3) ++j;
    return j;
  };
  // The increments of the leg that begins at i0; the second leg of a step is the first leg of the
  // next one.
  std::optional<InertialIncrements> first;
  while (i0 < track.size()) {
    const std::size_t i1 = later(i0);
    const std::size_t i2 = i1 < track.size() ? later(i1) : track.size();
    if (i2 >= track.size() || HasGap(*flight.imu, track[i0].t_s, track[i2].t_s)) break;
    const double D = track[i1].t_s - track[i0].t_s;
    const double D2 = track[i2].t_s - track[i1].t_s;
    const InertialIncrements a =
        first ? *first : IntegrateMotion(*flight.imu, track[i0].t_s, track[i1].t_s, bias);
    first.reset();
    const bool even = std::abs(D2 - D) < 1e-3;
    const double r = even ? 1.0 : D2 / D;
    if (r >= 1.0 / kMostUneven && r <= kMostUneven) {
      const double square = even ? D * D : 0.5 * D2 * (D + D2);
      const double weight = even ? std::pow(D, 4) : square * square;
      const InertialIncrements b =
          first.emplace(IntegrateMotion(*flight.imu, track[i1].t_s, track[i2].t_s, bias));
      const Eigen::Quaterniond q_a1 = q_a0 * a.delta_q;
      const Eigen::Vector3d alpha = r * (q_a0 * (D * a.delta_v - a.delta_p)) + q_a1 * b.delta_p +
                                    (q_a1 * b.delta_q) * l_b - (1.0 + r) * (q_a1 * l_b) +
                                    r * (q_a0 * l_b);
      const Eigen::Quaterniond C =
          Exp(Eigen::Vector3d(frame.w_ie_m() * (track[i1].t_s - track.front().t_s)));
      const Eigen::Vector3d beta = inertial(track[i2]) - (1.0 + r) * inertial(track[i1]) +
                                   r * inertial(track[i0]) -
                                   square * (C * frame.Gravitation(track[i1].p_m));
      B += beta * alpha.transpose() / weight;
      squares += (beta.squaredNorm() + alpha.squaredNorm()) / weight;
      horizontal2 += beta.head<2>().squaredNorm() / weight;
      ++used;
    }
    q_a0 = q_a0 * a.delta_q;
    i0 = i1;
  }
  InFlight result;
  if (used < 3) return result;
  const RotationFit fit = FitRotation(B);
  result.q_mb = Eigen::Quaterniond(fit.R);
  const double explained = 2.0 * fit.singular_values.dot(fit.signs);
  result.misfit_mps2 = std::sqrt(std::max(0.0, squares - explained) / used);
  const double noise_mps2 = std::sqrt(6.0) * sigma_m / (spacing_s * spacing_s);
  const double excess = horizontal2 - 2.0 * used * noise_mps2 * noise_mps2;
  if (excess > 0.0) result.sigma_heading_rad = noise_mps2 / std::sqrt(excess);
  result.valid = true;
  return result;
}

}  // namespace dn::navigation_internal
