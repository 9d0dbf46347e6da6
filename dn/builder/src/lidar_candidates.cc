#include <dn/factors/point_to_point.h>
#include <dn/rotation.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "candidate_effects.h"

namespace dn::internal {
namespace {

using Eigen::Vector3d;

constexpr double kPpm = 1e-6;
constexpr double kDegPerHour = kRadPerDeg / 3600.0;
constexpr std::size_t kMostSteps = 6;

/// What an effect is made of at one end of a pair.
struct End {
  PointToPoint::EndDerivatives derivatives;
  double t_s = 0.0;
  Vector3d u_s, axis_b;  // axis_b: the scan axis in body
  double scan_angle_rad = 0.0;
};

/// d residual / d effect by one end.
using EndModel = std::function<Eigen::MatrixXd(const End&)>;

struct PairEnds {
  FactorId factor = -1;
  End i, j;
};

End MakeEnd(const FlightNetwork& network, const PointToPoint::EndDerivatives& derivatives,
            double t_s, const Vector3d& u_s) {
  const LidarConfig& lidar = *network.flight().config.lidar;
  End end;
  end.derivatives = derivatives;
  end.t_s = t_s;
  end.u_s = u_s;
  end.axis_b = network.net.Value(network.boresight) *
               (lidar.mounting.R_bs_nominal * lidar.scan_axis_s.normalized());
  end.scan_angle_rad =
      std::atan2(u_s.dot(lidar.scan_axis_s.cross(lidar.nadir_axis_s)), u_s.dot(lidar.nadir_axis_s));
  return end;
}

std::vector<PairEnds> ActivePairs(const FlightNetwork& network) {
  std::vector<PairEnds> pairs;
  for (const FlightNetwork::PairEdge& edge : network.pair_edges) {
    if (!network.net.factor(edge.id).active) continue;
    const auto& factor = static_cast<const PointToPoint&>(*network.net.factor(edge.id).factor);
    const auto [i, j] = factor.DerivativesOfEnds(ValuesOf(network.net, edge.id).data());
    pairs.push_back({edge.id, MakeEnd(network, i, edge.pair.t_i_s, edge.pair.u_i_s),
                     MakeEnd(network, j, edge.pair.t_j_s, edge.pair.u_j_s)});
  }
  return pairs;
}

EffectModel ModelOf(const std::vector<PairEnds>& pairs, const EndModel& end) {
  EffectModel model;
  for (const PairEnds& pair : pairs) model.push_back({pair.factor, end(pair.i) + end(pair.j)});
  return model;
}

Eigen::MatrixXd ByBoresight(const End& end) {
  return -end.derivatives.J_r_u * Skew(end.derivatives.u_b);
}

/// Times between strips at which the mount may have slipped.
std::vector<double> TimesOfSteps(const FlightNetwork& network) {
  std::vector<StripInterval> strips = FindStrips(network.flight());
  std::sort(strips.begin(), strips.end(),
            [](const StripInterval& a, const StripInterval& b) { return a.t0_s < b.t0_s; });
  std::vector<double> t_s;
  for (std::size_t k = 1; k < strips.size(); ++k) {
    t_s.push_back(0.5 * (strips[k - 1].t1_s + strips[k].t0_s));
  }
  if (t_s.size() > kMostSteps) {
    std::vector<double> some;
    for (std::size_t k = 0; k < kMostSteps; ++k) some.push_back(t_s[k * t_s.size() / kMostSteps]);
    return some;
  }
  return t_s;
}

}  // namespace

void AddLidarCandidates(const FlightNetwork& network, std::vector<CandidateEffect>* effects) {
  if (network.pair_edges.empty()) return;
  const std::vector<PairEnds> pairs = ActivePairs(network);
  double first_s = std::numeric_limits<double>::infinity(), last_s = -first_s;
  std::vector<FactorId> factors;
  for (const PairEnds& pair : pairs) {
    factors.push_back(pair.factor);
    first_s = std::min({first_s, pair.i.t_s, pair.j.t_s});
    last_s = std::max({last_s, pair.i.t_s, pair.j.t_s});
  }
  const double middle_s = 0.5 * (first_s + last_s);
  const auto add = [&](const std::string& name, const char* unit, double unit_si, int components,
                       double typical, const std::string& remedy, EffectModel model) {
    effects->push_back({name, unit, 1.0 / unit_si,
                        Eigen::VectorXd::Constant(components, typical * unit_si), remedy,
                        std::move(model)});
  };
  add("lidar_time_offset", "s", 1.0, 1, 5e-4,
      "check the time tags of the pair files against those of imu.file, or estimate "
      "lidar_time_offset",
      ModelOfBlock(network.net, factors, network.lidar_time_offset.id));
  add("lidar_lever_arm", "m", 1.0, 3, 0.03,
      "check the sign, axes and unit of lidar.lever_arm_m, or estimate lidar_lever_arm",
      ModelOfBlock(network.net, factors, network.lidar_lever_arm.id));
  add("lidar_time_drift", "ppm", kPpm, 1, 1.0,
      "the clock of the scanner drifts: correct the time tags of the pair files",
      ModelOf(pairs, [&](const End& e) {
        return Eigen::MatrixXd(e.derivatives.J_r_t * (e.t_s - first_s));
      }));
  const std::string ranges = "correct the ranges of the pair files (lidar.p2p) and their unit";
  add("lidar_range_offset", "m", 1.0, 1, 0.02, ranges, ModelOf(pairs, [](const End& e) {
        return Eigen::MatrixXd(-e.derivatives.J_r_u * e.derivatives.u_b.normalized());
      }));
  add("lidar_range_scale", "ppm", kPpm, 1, 100.0, ranges, ModelOf(pairs, [](const End& e) {
        return Eigen::MatrixXd(-e.derivatives.J_r_u * e.derivatives.u_b);
      }));
  add("lidar_angle_scale", "ppm", kPpm, 1, 500.0,
      "correct the scan angles of the laser vectors in the pair files (lidar.p2p)",
      ModelOf(pairs, [](const End& e) {
        const Vector3d turned = e.scan_angle_rad * e.axis_b.cross(e.derivatives.u_b);
        return Eigen::MatrixXd(-e.derivatives.J_r_u * turned);
      }));
  add("lidar_scan_cone", "deg", kRadPerDeg, 1, 0.02,
      "the beam leaves the scan plane: correct the laser vectors in the pair files (lidar.p2p)",
      ModelOf(pairs, [](const End& e) {
        return Eigen::MatrixXd(e.derivatives.J_r_u * (e.u_s.norm() * e.axis_b));
      }));
  const std::string mount = "the scanner moves against the inertial unit: fix its mount";
  add("boresight_drift", "deg/h", kDegPerHour, 3, 0.02, mount, ModelOf(pairs, [&](const End& e) {
        return Eigen::MatrixXd(ByBoresight(e) * (e.t_s - middle_s));
      }));
  for (const double t0_s : TimesOfSteps(network)) {
    add("boresight_step", "deg", kRadPerDeg, 3, 0.005, mount, ModelOf(pairs, [&](const End& e) {
          return Eigen::MatrixXd(e.t_s > t0_s ? 1.0 * ByBoresight(e) : 0.0 * ByBoresight(e));
        }));
  }
}

}  // namespace dn::internal
