#pragma once

#include <dn/fixed_trajectory/gauss_helmert.h>
#include <dn/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

namespace dn::testing {

/// A straight line flown at constant speed.
struct FlightLine {
  Eigen::Vector3d begin_m = Eigen::Vector3d::Zero();  ///< in map
  Eigen::Vector3d end_m = Eigen::Vector3d::Zero();
  double t0_s = 0.0;
  double speed_mps = 45.0;

  Eigen::Vector3d direction() const { return (end_m - begin_m).normalized(); }
  double duration_s() const { return (end_m - begin_m).norm() / speed_mps; }
};

/// Returns two opposite lines and a higher cross line, 250 m above the ground.
inline std::vector<FlightLine> CrossingLines() {
  return {{{-800, 0, 250}, {800, 0, 250}, 1000.0},
          {{800, 100, 250}, {-800, 100, 250}, 1130.0},
          {{0, -800, 300}, {0, 800, 300}, 1260.0}};
}

/// Flight lines, pairs and noise of a synthetic strip flight.
struct StripPairOptions {
  std::vector<FlightLine> lines = CrossingLines();
  int count = 300;
  double relief_m = 60.0;  ///< ground heights are uniform within half of this value up and down
  double half_width_m = 150.0;  ///< of a strip
  double attitude_rad = 0.02;   ///< amplitude of the platform's oscillation
  Eigen::Vector3d boresight_rad = Eigen::Vector3d(0.004, -0.003, 0.006);
  Eigen::Vector3d lever_arm_b_m = Eigen::Vector3d(0.14, -0.02, 0.21);
  Eigen::Vector3d sigma_ned_m = Eigen::Vector3d(0.02, 0.02, 0.03);
  Eigen::Vector3d sigma_rph_rad = Eigen::Vector3d(5e-5, 5e-5, 1e-4);
  double sigma_p_m = 0.05;
  unsigned seed = 1;
};

/// Returns the true attitude of the platform on a line: along the line, with an oscillation.
inline Eigen::Quaterniond PlatformAttitude(const FlightLine& line, double t_s, double swing_rad) {
  const Eigen::Vector3d d = line.direction();
  const double heading = std::atan2(d.x(), d.y());
  const Eigen::Vector3d rph(swing_rad * std::sin(0.7 * t_s), swing_rad * std::sin(0.5 * t_s + 1.0),
                            heading + swing_rad * std::sin(0.3 * t_s + 2.0));
  Eigen::Matrix3d R_m_ned;
  R_m_ned << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  return (Eigen::Quaterniond(R_m_ned) * QuaternionFromRollPitchHeading(rph)).normalized();
}

/// Returns the exact end of a pair that observes the ground point x_m at right angles from a line.
inline GaussHelmertEnd SeePoint(const FlightLine& line, const Eigen::Vector3d& x_m,
                                const StripPairOptions& options) {
  const double along_m = (x_m - line.begin_m).dot(line.direction());
  GaussHelmertEnd end;
  end.t_s = line.t0_s + along_m / line.speed_mps;
  end.p_mb = line.begin_m + along_m * line.direction();
  end.q_mb = PlatformAttitude(line, end.t_s, options.attitude_rad);
  Eigen::Matrix3d R_m_ned;
  R_m_ned << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  end.q_mn = Eigen::Quaterniond(R_m_ned);
  end.sigma_ned_m = options.sigma_ned_m;
  end.sigma_rph_rad = options.sigma_rph_rad;
  const Eigen::Vector3d u = end.q_mb.conjugate() * (x_m - end.p_mb) - options.lever_arm_b_m;
  end.u_b = Exp(options.boresight_rad).conjugate() * u;
  return end;
}

inline bool Sees(const FlightLine& line, const Eigen::Vector3d& x_m, double half_width_m) {
  Eigen::Vector3d horizontal = x_m - line.begin_m;
  horizontal.z() = 0.0;
  const double along_m = horizontal.dot(line.direction());
  const double length_m = (line.end_m - line.begin_m).norm();
  const double across_m = (horizontal - along_m * line.direction()).norm();
  return along_m >= 0.0 && along_m <= length_m && across_m <= half_width_m;
}

/// Returns error-free pairs of points observed from two lines, taken in turn from all overlapping
/// pairs of lines; the initial boresight is zero.
inline GaussHelmertProblem MakeStripPairs(const StripPairOptions& options = {}) {
  std::mt19937 rng(options.seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  GaussHelmertProblem problem;
  problem.lever_arm_b_m = options.lever_arm_b_m;
  const std::size_t n = options.lines.size();
  while (static_cast<int>(problem.pairs.size()) < options.count) {
    for (std::size_t a = 0; a < n; ++a) {
      for (std::size_t b = a + 1; b < n; ++b) {
        for (int attempt = 0; attempt < 100; ++attempt) {
          const FlightLine& line = options.lines[a];
          const double length_m = (line.end_m - line.begin_m).norm();
          Eigen::Vector3d x =
              line.begin_m + 0.5 * (1.0 + uniform(rng)) * length_m * line.direction();
          x += options.half_width_m * uniform(rng) *
               line.direction().cross(Eigen::Vector3d::UnitZ());
          x.z() = 0.5 * options.relief_m * uniform(rng);
          if (!Sees(options.lines[b], x, options.half_width_m)) continue;
          GaussHelmertPair pair;
          pair.i = SeePoint(line, x, options);
          pair.j = SeePoint(options.lines[b], x, options);
          pair.covariance_m2 = options.sigma_p_m * options.sigma_p_m * Eigen::Matrix3d::Identity();
          problem.pairs.push_back(pair);
          break;
        }
      }
    }
  }
  problem.pairs.resize(static_cast<std::size_t>(options.count));
  return problem;
}

/// Trajectory error at an epoch: position in map (m) and attitude, right perturbation (rad).
struct PoseError {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d attitude_rad = Eigen::Vector3d::Zero();
};

inline Eigen::Vector3d NormalVector(std::mt19937& rng, const Eigen::Vector3d& sigma) {
  std::normal_distribution<double> normal;
  Eigen::Vector3d v;
  for (int i = 0; i < 3; ++i) v[i] = sigma[i] * normal(rng);
  return v;
}

/// Adds errors to the pairs: the trajectory error at each epoch, and white noise of sigma_p_m on
/// the second point of each pair.
inline void Disturb(GaussHelmertProblem* problem,
                    const std::function<PoseError(const GaussHelmertEnd&)>& trajectory,
                    double sigma_p_m, std::mt19937& rng) {
  for (GaussHelmertPair& pair : problem->pairs) {
    const Eigen::Vector3d noise_m = NormalVector(rng, Eigen::Vector3d::Constant(sigma_p_m));
    pair.j.u_b += pair.j.q_mb.conjugate() * noise_m;  // neglects the rotation by the boresight
    for (GaussHelmertEnd* end : {&pair.i, &pair.j}) {
      const PoseError error = trajectory(*end);
      end->p_mb += error.position_m;
      end->q_mb = (end->q_mb * Exp(error.attitude_rad)).normalized();
    }
  }
}

/// Returns white trajectory errors with the sigmas of the ends.
inline std::function<PoseError(const GaussHelmertEnd&)> WhiteErrors(std::mt19937& rng) {
  return [&rng](const GaussHelmertEnd& end) {
    PoseError error;
    error.position_m = end.q_mn * NormalVector(rng, end.sigma_ned_m);
    const Eigen::Vector3d down_b = (end.q_mb.conjugate() * end.q_mn) * Eigen::Vector3d::UnitZ();
    error.attitude_rad = BodyFromEulerRates(down_b) * NormalVector(rng, end.sigma_rph_rad);
    return error;
  };
}

/// Returns the error of a boresight in the coordinates of its covariance: the left perturbation
/// from the truth.
inline Eigen::Vector3d BoresightError(const Eigen::Vector3d& estimate_rad,
                                      const Eigen::Vector3d& truth_rad) {
  return Log(Eigen::Quaterniond(Exp(estimate_rad) * Exp(truth_rad).conjugate()));
}

}  // namespace dn::testing
