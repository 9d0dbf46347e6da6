#include <dn/factors/preintegrated_inertial.h>
#include <dn/rotation.h>

#include <functional>

#include "candidate_effects.h"

namespace dn::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix93 = Eigen::Matrix<double, 9, 3>;

constexpr double kPpm = 1e-6;
constexpr double kMrad = 1e-3;
constexpr double kDegPerHour = kRadPerDeg / 3600.0;
constexpr double kArcsec = kRadPerDeg / 3600.0;
constexpr double kMgal = 1e-5;

/// How the residual of one inertial edge depends on errors of its data.
struct EdgeDerivatives {
  FactorId factor = -1;
  Matrix93 J_r_w, J_r_f;  ///< to a rate and a specific force added to the measured ones
  Matrix93 J_r_scale;     ///< to the scale factor of the gyros
  Matrix93 J_r_g;         ///< to an attraction added to the assumed one, map axes
  Vector3d w_b, f_b;      ///< mean rate and specific force of the edge
  Vector3d p_m;
};

EdgeDerivatives Differentiate(const FlightNetwork& network,
                              const FlightNetwork::InertialEdge& edge) {
  constexpr std::size_t kPositionBlock = 1, kVelocityBlock = 2, kFirstBias = 6;
  const Network& net = network.net;
  const auto& factor = static_cast<const PreintegratedInertial&>(*net.factor(edge.id).factor);
  const Preintegrated& increments = factor.increments();
  const MapPose i = network.NodePose(edge.node_i), j = network.NodePose(edge.node_i + 1);
  const PreintegratedInertial with_all(increments, network.flight().frame, i.p_mb, j.p_mb, 1, 1,
                                       true);
  std::vector<const double*> x = ValuesOf(net, edge.id);
  x.resize(kFirstBias);
  x.push_back(increments.linearisation.gyro_bias_radps.data());
  x.push_back(increments.linearisation.accel_bias_mps2.data());
  x.push_back(increments.gyro_scale.data());
  Eigen::VectorXd r;
  std::vector<Eigen::MatrixXd> J;
  EvaluateInTangent(with_all, x, &r, &J);
  const double dt_s = increments.dt_s();
  EdgeDerivatives out;
  out.factor = edge.id;
  out.J_r_w = J[kFirstBias];
  out.J_r_f = J[kFirstBias + 1];
  out.J_r_scale = J[kFirstBias + 2];
  out.J_r_g = dt_s * J[kVelocityBlock] - 0.5 * dt_s * dt_s * J[kPositionBlock];
  out.w_b = Log(increments.delta_q) / dt_s;
  out.f_b = increments.delta_v / dt_s;
  out.p_m = i.p_mb;
  return out;
}

EffectModel ModelOf(const std::vector<EdgeDerivatives>& edges,
                    const std::function<Eigen::MatrixXd(const EdgeDerivatives&)>& L) {
  EffectModel model;
  for (const EdgeDerivatives& edge : edges) model.push_back({edge.factor, L(edge)});
  return model;
}

}  // namespace

void AddInertialCandidates(const FlightNetwork& network, std::vector<CandidateEffect>* effects) {
  std::vector<EdgeDerivatives> edges;
  for (const FlightNetwork::InertialEdge& edge : network.inertial_edges) {
    if (network.net.factor(edge.id).active) edges.push_back(Differentiate(network, edge));
  }
  const LocalFrame& frame = network.flight().frame;
  const auto add = [&](const char* name, const char* unit, double unit_si, int components,
                       double typical, const char* remedy,
                       const std::function<Eigen::MatrixXd(const EdgeDerivatives&)>& L) {
    effects->push_back({name, unit, 1.0 / unit_si,
                        Eigen::VectorXd::Constant(components, typical * unit_si), remedy,
                        ModelOf(edges, L)});
  };
  const char* const sensor =
      "the data sheet or a laboratory calibration of the sensor has it; correct imu.file";
  if (network.gyro_scale_factor.id < 0) {
    add("gyro_scale_factor", "ppm", kPpm, 3, 300.0, "estimate gyro_scale_factor",
        [](const auto& e) { return Eigen::MatrixXd(e.J_r_scale); });
  }
  add("gyro_misalignment", "mrad", kMrad, 3, 0.3,
      "check imu.R_imu_to_body and the axes of imu.file; correct imu.file",
      [](const auto& e) { return Eigen::MatrixXd(e.J_r_w * Skew(e.w_b)); });
  add("gyro_g_sensitivity", "deg/h/g", kDegPerHour / kStandardGravityMps2, 3, 1.0, sensor,
      [](const auto& e) { return Eigen::MatrixXd(e.J_r_w * e.f_b.asDiagonal()); });
  add("accel_scale_factor", "ppm", kPpm, 3, 300.0, sensor,
      [](const auto& e) { return Eigen::MatrixXd(e.J_r_f * e.f_b.asDiagonal()); });
  add("accel_misalignment", "mrad", kMrad, 3, 0.3,
      "check imu.R_imu_to_body and the axes of imu.file; correct imu.file",
      [](const auto& e) { return Eigen::MatrixXd(e.J_r_f * Skew(e.f_b)); });
  const char* const gravity =
      "gravity departs from the normal one there; give accelerometers a process that covers it";
  add("gravity_tilt", "arcsec", kArcsec, 2, 10.0, gravity, [&](const auto& e) {
    Eigen::Matrix<double, 3, 2> north_east;
    north_east << 0.0, 1.0, 1.0, 0.0, 0.0, 0.0;
    const double g_mps2 = frame.Gravity(e.p_m).norm();
    return Eigen::MatrixXd(e.J_r_g * (g_mps2 * frame.R_m_enu(e.p_m) * north_east));
  });
  add("gravity_disturbance", "mGal", kMgal, 1, 30.0, gravity, [&](const auto& e) {
    return Eigen::MatrixXd(e.J_r_g * (frame.R_m_enu(e.p_m) * -Vector3d::UnitZ()));
  });
}

}  // namespace dn::internal
