#include <dn/builder/flight_network.h>
#include <dn/builder/gnss_factors.h>
#include <dn/imu/preintegration.h>
#include <dn/navigation/alignment.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "in_flight_alignment.h"

namespace dn {
namespace {

using navigation_internal::AlignInFlight;
using navigation_internal::Antenna;
using navigation_internal::AntennaTrack;
using navigation_internal::InFlight;

// Limits of the window of the in-flight alignment: it must be long enough for a turn and short
// enough for the drift of the gyros.
constexpr double kLongestWindowS = 180.0;
constexpr double kDriftLimitRad = 5.0 * kRadPerDeg;
// Sum of velocity changes that is sufficient to decide between heading hypotheses.
constexpr double kEnoughVelocityChangeMps = 60.0;
constexpr double kMinDecisionS = 120.0;
constexpr double kHuberSigmas = 4.0;
// Floors of the measurement sigmas of the filter: the first while headings are compared, the others
// in the refinements.
constexpr double kCoarseFloor[] = {0.5, 0.1, 0.02};

double TypicalBias(const SensorNoise& sensor) {
  double variance = 0.0;
  for (const BiasProcess& process : sensor.processes) {
    if (process.type != BiasProcess::Type::kRandomWalk) variance += process.sigma * process.sigma;
  }
  return std::sqrt(variance);
}

struct StillStart {
  bool still = false;
  double t_end_s = 0.0;
  Eigen::Vector3d mean_w_b = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_f_b = Eigen::Vector3d::Zero();
};

// The vehicle is at rest as long as no second differs from the previous mean by more than handling
// or a running engine can cause.
StillStart FindStillStart(const Flight& flight, double t0_s) {
  constexpr double kFirstS = 2.0, kMinS = 5.0, kGyroRadps = 0.02, kAccelMps2 = 0.2;
  const ImuData& imu = *flight.imu;
  StillStart result;
  Eigen::Vector3d sum_w = Eigen::Vector3d::Zero(), sum_f = Eigen::Vector3d::Zero();
  Eigen::Vector3d second_w = Eigen::Vector3d::Zero(), second_f = Eigen::Vector3d::Zero();
  double n = 0.0, n_second = 0.0;
  double second_end_s = t0_s + 1.0;
  for (std::size_t k = SampleRange(imu, t0_s, imu.t_end_s()).first; k < imu.samples.size(); ++k) {
    const ImuSample& sample = imu.samples[k];
    second_w += sample.w_ib_b_radps;
    second_f += sample.f_b_mps2;
    n_second += 1.0;
    if (sample.t_s < second_end_s) continue;
    second_w /= n_second;
    second_f /= n_second;
    if (sample.t_s - t0_s > kFirstS && ((second_w - sum_w / n).norm() > kGyroRadps ||
                                        (second_f - sum_f / n).norm() > kAccelMps2)) {
      break;
    }
    sum_w += n_second * second_w;
    sum_f += n_second * second_f;
    n += n_second;
    result.t_end_s = sample.t_s;
    second_w.setZero();
    second_f.setZero();
    n_second = 0.0;
    second_end_s += 1.0;
  }
  if (n < 1.0 || result.t_end_s - t0_s < kMinS) return result;
  const std::vector<Antenna> track = AntennaTrack(flight, {t0_s, result.t_end_s});
  const double moved_m = track.size() < 2 ? 0.0 : (track.back().p_m - track.front().p_m).norm();
  result.still = moved_m < 0.2 + 5.0 * TypicalGnssSigma(flight);
  result.mean_w_b = sum_w / n;
  result.mean_f_b = sum_f / n;
  return result;
}

// Returns the rotation body -> map from two pairs of directions; the first pair is matched exactly.
Eigen::Quaterniond FromTwoDirections(const Eigen::Vector3d& up_b, const Eigen::Vector3d& other_b,
                                     const Eigen::Vector3d& up_m, const Eigen::Vector3d& other_m) {
  const auto triad = [](const Eigen::Vector3d& first, const Eigen::Vector3d& second) {
    Eigen::Matrix3d M;
    M.col(0) = first.normalized();
    M.col(1) = first.cross(second).normalized();
    M.col(2) = M.col(0).cross(M.col(1));
    return M;
  };
  return Eigen::Quaterniond(
      Eigen::Matrix3d(triad(up_m, other_m) * triad(up_b, other_b).transpose()));
}

struct Candidate {
  Eigen::Quaterniond q_mb;
  double sigma_heading_rad;
  std::string method;
};

std::vector<Candidate> AllHeadings(const Eigen::Quaterniond& q_mb, const std::string& method) {
  std::vector<Candidate> candidates;
  for (int k = 0; k < 8; ++k) {
    const Eigen::Quaterniond turn = Exp(Eigen::Vector3d(0.0, 0.0, k * std::numbers::pi / 4.0));
    candidates.push_back({turn * q_mb, 25.0 * kRadPerDeg, method});
  }
  return candidates;
}

double WindowFor(const Flight& flight, const StillStart& still) {
  if (still.still) return kLongestWindowS;
  const double drift_radps = TypicalBias(flight.config.imu->model.gyro);
  return std::clamp(kDriftLimitRad / std::max(drift_radps, 1e-9), 20.0, kLongestWindowS);
}

std::vector<Candidate> Candidates(const Flight& flight, const TimeInterval& span,
                                  const StillStart& still, const ImuCorrection& bias) {
  std::vector<Candidate> candidates;
  if (flight.initial_guess && flight.initial_guess->Covers(span.t0_s)) {
    const MapPose pose = InterpolatePose(flight.initial_guess->ToMapPoses(flight.frame), span.t0_s);
    candidates.push_back({pose.q_mb, 5.0 * kRadPerDeg, "initial guess"});
  }
  if (still.still) {
    const double bias_radps = TypicalBias(flight.config.imu->model.gyro);
    const Eigen::Vector3d up_m(0.0, 0.0, 1.0);
    const Eigen::Vector3d w_m = flight.frame.w_ie_m();
    if (bias_radps < 0.1 * kEarthRateRadps) {
      candidates.push_back({FromTwoDirections(still.mean_f_b, still.mean_w_b, up_m, w_m),
                            std::max(bias_radps / w_m.head<2>().norm(), 0.2 * kRadPerDeg),
                            "gyrocompass"});
    }
    const Eigen::Vector3d forward_b(1.0, 0.0, 0.0), east_m(1.0, 0.0, 0.0);
    const auto levelled =
        AllHeadings(FromTwoDirections(still.mean_f_b, forward_b, up_m, east_m), "levelling");
    candidates.insert(candidates.end(), levelled.begin(), levelled.end());
    return candidates;
  }
  const double t1_s = std::min(span.t1_s, span.t0_s + WindowFor(flight, still));
  const InFlight in_flight = AlignInFlight(flight, {span.t0_s, t1_s}, bias);
  if (in_flight.valid) {
    candidates.push_back(
        {in_flight.q_mb,
         std::clamp(3.0 * in_flight.sigma_heading_rad, 3.0 * kRadPerDeg, 25.0 * kRadPerDeg),
         "in-flight"});
    const auto turned = AllHeadings(in_flight.q_mb, "levelling");
    candidates.insert(candidates.end(), turned.begin() + 1, turned.end());
  }
  if (candidates.empty()) {
    throw InvalidInput(
        "alignment: no attitude can be found at the start of the flight: it is not at rest, and "
        "too few GNSS epochs have no gap in the GNSS or IMU data; begin time_span_s after the "
        "gaps, or give initial_guess.txt");
  }
  return candidates;
}

MapPose StartPose(const Flight& flight, const TimeInterval& span, const Eigen::Quaterniond& q_mb) {
  const std::vector<Antenna> track = AntennaTrack(flight, span);
  MapPose pose;
  pose.t_s = span.t0_s;
  pose.q_mb = q_mb;
  pose.p_mb = track.front().p_m - q_mb * flight.config.gnss->lever_arm_b_m;
  const double spacing_s = std::max(1.0, 2.0 * TypicalGnssSigma(flight));
  std::size_t j = 1;
  while (j + 1 < track.size() && track[j].t_s - track[0].t_s < spacing_s - 1e-3) ++j;
  pose.v_m = (track[j].p_m - track[0].p_m) / (track[j].t_s - track[0].t_s);
  const MapGnssEpoch* first = nullptr;
  for (const MapGnssEpoch& epoch : flight.gnss->epochs) {
    if (std::abs(epoch.t_s - track.front().t_s) < 1e-6) first = &epoch;
  }
  if (first != nullptr && UsesVelocity(*first, *flight.config.gnss)) {
    pose.v_m = first->R_m_enu * *first->velocity_enu_mps;
  }
  return pose;
}

double DecisionTime(const Flight& flight, const TimeInterval& span) {
  constexpr double kStepS = 5.0;
  const std::vector<Antenna> track = AntennaTrack(flight, span);
  double changes = 0.0;
  Eigen::Vector3d v_before = Eigen::Vector3d::Zero();
  std::size_t i = 0;
  const double noise_mps = 2.0 * TypicalGnssSigma(flight) / kStepS;
  for (std::size_t j = 1; j < track.size(); ++j) {
    if (track[j].t_s - track[i].t_s < kStepS - 1e-3) continue;
    const Eigen::Vector3d v = (track[j].p_m - track[i].p_m) / (track[j].t_s - track[i].t_s);
    changes += std::max(0.0, (v - v_before).norm() - noise_mps);
    v_before = v;
    i = j;
    if (changes > kEnoughVelocityChangeMps && track[j].t_s > span.t0_s + kMinDecisionS)
      return track[j].t_s;
  }
  return span.t1_s;
}

FilterState StartState(const Flight& flight, const TimeInterval& span, const Candidate& candidate,
                       const ImuCorrection& bias, double sigma_tilt_rad) {
  const double sigma_m = TypicalGnssSigma(flight);
  return MakeFilterState(flight, StartPose(flight, span, candidate.q_mb), bias.gyro_bias_radps,
                         bias.accel_bias_mps2,
                         {sigma_tilt_rad, sigma_tilt_rad, candidate.sigma_heading_rad},
                         3.0 * sigma_m, 5.0 + 2.0 * sigma_m);
}

// Returns the attitude at the start that follows from the last attitude of the filter, integrated
// back with the gyros alone.
Eigen::Quaterniond BackToStart(const Flight& flight, const FilterState& last, double t0_s) {
  const ImuCorrection bias{last.TotalGyroBias(), last.TotalAccelBias()};
  const InertialIncrements whole = IntegrateMotion(*flight.imu, t0_s, last.pose.t_s, bias);
  const Eigen::Quaterniond C = Exp(Eigen::Vector3d(flight.frame.w_ie_m() * (last.pose.t_s - t0_s)));
  return (C * last.pose.q_mb) * whole.delta_q.conjugate();
}

}  // namespace

Alignment Align(const Flight& flight, const std::vector<double>& times,
                const std::function<bool()>& interrupted) {
  const TimeInterval span{times.front(), times.back()};
  const StillStart still = FindStillStart(flight, span.t0_s);
  ImuCorrection bias;
  if (still.still && TypicalBias(flight.config.imu->model.gyro) > kEarthRateRadps) {
    bias.gyro_bias_radps = still.mean_w_b;
  }
  const std::vector<Candidate> candidates = Candidates(flight, span, still, bias);
  FilterOptions options;
  options.interrupted = interrupted;
  options.huber_sigmas = kHuberSigmas;
  options.t_end_s = DecisionTime(flight, span);
  const auto set_floor = [&](int pass) {
    options.position_floor_m = options.velocity_floor_mps = kCoarseFloor[pass];
  };
  set_floor(0);

  Candidate best = candidates.front();
  FilterRun best_run;
  best_run.log_likelihood = -1e300;
  for (const Candidate& candidate : candidates) {
    FilterRun run = RunForwardFilter(
        flight, times, StartState(flight, span, candidate, bias, 3.0 * kRadPerDeg), options);
    if (!(run.log_likelihood > best_run.log_likelihood)) continue;
    best = candidate;
    best_run = std::move(run);
  }
  for (int pass = 1; pass < 3 && !HasGap(*flight.imu, span.t0_s, best_run.last.pose.t_s); ++pass) {
    set_floor(pass);
    best.q_mb = BackToStart(flight, best_run.last, span.t0_s);
    best_run = RunForwardFilter(flight, times,
                                StartState(flight, span, best, bias, 3.0 * kRadPerDeg), options);
  }
  options.position_floor_m = options.velocity_floor_mps = 0.0;
  Alignment result;
  options.t_end_s = 1e300;
  result.run = RunForwardFilter(flight, times,
                                StartState(flight, span, best, bias, 3.0 * kRadPerDeg), options);
  result.method = best.method;
  result.candidates = static_cast<int>(candidates.size());
  result.heading_rad =
      RollPitchHeading(ToNavPoint(result.run.states.front().pose, flight.frame).q_nb).z();
  return result;
}

}  // namespace dn
