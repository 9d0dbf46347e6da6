#pragma once

#include <dn/geo/local_frame.h>
#include <dn/geo/trajectory.h>
#include <dn/imu/imu_data.h>
#include <dn/rotation.h>

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <vector>

namespace dn::testing {

/// The signal amplitude sin(2 pi f t + phase), per axis.
struct Harmonic {
  Eigen::Vector3d amplitude = Eigen::Vector3d::Zero();
  double frequency_hz = 1.0;
  Eigen::Vector3d phase_rad = Eigen::Vector3d::Zero();
};

/// The signal offset + rate t + harmonics, with its derivatives.
struct Signal {
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();
  std::vector<Harmonic> harmonics;

  /// Returns the derivative of the given order at t_s.
  Eigen::Vector3d At(double t_s, int order = 0) const {
    Eigen::Vector3d value = Eigen::Vector3d::Zero();
    if (order == 0) value = offset + t_s * rate;
    if (order == 1) value = rate;
    for (const Harmonic& h : harmonics) {
      const double omega = 2.0 * std::numbers::pi * h.frequency_hz;
      for (int i = 0; i < 3; ++i) {
        value[i] += h.amplitude[i] * std::pow(omega, order) *
                    std::sin(omega * t_s + h.phase_rad[i] + 0.5 * std::numbers::pi * order);
      }
    }
    return value;
  }
};

/// A closed-form motion over the rotating Earth, and the measurements of a perfect inertial sensor
/// on it. It is written independently of the estimator: Coriolis form with gravity, Euler angles.
struct EarthMotion {
  LocalFrame frame;
  Signal position_m;  ///< body origin in map
  Signal rph_rad;  ///< roll, pitch, heading with respect to the north-east-down frame of the origin

  Eigen::Quaterniond Attitude(double t_s) const {
    const Eigen::Quaterniond q_mn(frame.R_mn(Eigen::Vector3d::Zero()));
    return (q_mn * QuaternionFromRollPitchHeading(rph_rad.At(t_s))).normalized();
  }

  MapPose Pose(double t_s) const {
    return {t_s, Attitude(t_s), position_m.At(t_s), position_m.At(t_s, 1)};
  }

  Eigen::Vector3d AngularRate(double t_s) const {
    const Eigen::Vector3d e = rph_rad.At(t_s), d = rph_rad.At(t_s, 1);
    const double sr = std::sin(e.x()), cr = std::cos(e.x());
    const double sp = std::sin(e.y()), cp = std::cos(e.y());
    const Eigen::Vector3d w_mb_b(d.x() - sp * d.z(), cr * d.y() + sr * cp * d.z(),
                                 -sr * d.y() + cr * cp * d.z());
    return w_mb_b + Attitude(t_s).conjugate() * frame.w_ie_m();
  }

  Eigen::Vector3d SpecificForce(double t_s) const {
    const Eigen::Vector3d f_m = position_m.At(t_s, 2) +
                                2.0 * frame.w_ie_m().cross(position_m.At(t_s, 1)) -
                                frame.Gravity(position_m.At(t_s));
    return Attitude(t_s).conjugate() * f_m;
  }

  /// Returns mean rates over intervals of 1/rate_hz from t0_s to t1_s, by Gauss-Legendre quadrature
  /// with five nodes. The relative error is below 1e-12 for ten samples per period.
  ImuData Measure(double t0_s, double t1_s, double rate_hz) const {
    static constexpr double kNode[5] = {-0.906179845938663992797627, -0.538469310105683091036314,
                                        0.0, 0.538469310105683091036314,
                                        0.906179845938663992797627};
    static constexpr double kWeight[5] = {0.236926885056189087514264, 0.478628670499366468041292,
                                          0.568888888888888888888889, 0.478628670499366468041292,
                                          0.236926885056189087514264};
    ImuData imu;
    imu.nominal_dt_s = 1.0 / rate_hz;
    const long count = std::lround((t1_s - t0_s) * rate_hz);
    for (long k = 0; k < count; ++k) {
      const double a = t0_s + static_cast<double>(k) / rate_hz;
      const double b = t0_s + static_cast<double>(k + 1) / rate_hz;
      ImuSample sample{b, b - a};
      for (int i = 0; i < 5; ++i) {
        const double t = 0.5 * (a + b) + 0.5 * (b - a) * kNode[i];
        sample.w_ib_b_radps += 0.5 * kWeight[i] * AngularRate(t);
        sample.f_b_mps2 += 0.5 * kWeight[i] * SpecificForce(t);
      }
      imu.samples.push_back(sample);
    }
    return imu;
  }
};

/// Returns the motion of a survey aircraft at 60 m/s and 45 deg north: slow attitude motion,
/// turbulence and a gentle climb.
inline EarthMotion PlaneMotion() {
  EarthMotion motion{LocalFrame({45.0 * kRadPerDeg, 7.0 * kRadPerDeg, 400.0}), {}, {}};
  motion.position_m.offset = {800.0, -300.0, 1000.0};
  motion.position_m.rate = {52.0, 30.0, 0.5};
  motion.position_m.harmonics = {{{3.0, 2.0, 2.0}, 0.1, {0.1, 0.8, 2.0}},
                                 {{0.05, 0.08, 0.1}, 0.9, {1.0, 2.0, 0.3}}};
  motion.rph_rad.offset = {0.05, 0.03, 1.05};
  motion.rph_rad.rate = {0.0, 0.0, 0.02};
  motion.rph_rad.harmonics = {{{0.10, 0.03, 0.05}, 0.15, {0.0, 1.1, 2.2}},
                              {{0.010, 0.006, 0.004}, 0.8, {0.4, 1.9, 0.7}}};
  return motion;
}

/// Returns PlaneMotion on vibration isolators: 0.5 g and 0.2 mrad of coning at 25 Hz.
inline EarthMotion VibratingMotion() {
  EarthMotion motion = PlaneMotion();
  const double omega = 2.0 * std::numbers::pi * 25.0;
  const double amplitude_m = 0.5 * kStandardGravityMps2 / (omega * omega);
  motion.position_m.harmonics.push_back(
      {amplitude_m * Eigen::Vector3d(0.6, 0.5, 0.62), 25.0, {0.0, 0.9, 1.7}});
  motion.rph_rad.harmonics.push_back({{2e-4, 2e-4, 0.0}, 25.0, {0.0, 0.5 * std::numbers::pi, 0}});
  return motion;
}

}  // namespace dn::testing
