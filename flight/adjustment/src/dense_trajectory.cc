#include <dn/adjustment/result.h>
#include <dn/imu/strapdown.h>
#include <dn/parallel.h>

#include <algorithm>
#include <cstddef>

namespace dn {
namespace {

constexpr double kSameTime_s = 1e-6;
constexpr std::size_t kNodesPerTask = 64;

/// A pose with the corrected angular rate and specific force at its time.
struct DensePose {
  MapPose pose;
  Eigen::Vector3d w_b_radps, f_b_mps2;
};

/// Computes the poses at sample epochs between the nodes from the poses of the nodes.
class DenseLegs {
 public:
  DenseLegs(const FlightNetwork& network, double min_spacing_s)
      : network_(network),
        flight_(network.flight()),
        calibration_(network.calibration().State()),
        min_spacing_s_(min_spacing_s),
        has_leg_(network.nodes().size(), false) {
    for (const InertialEdge& edge : network.inertial().edges()) {
      has_leg_[edge.node_i] = true;
    }
  }

  /// Returns the pose of node i and those before the next node.
  std::vector<DensePose> FromNode(std::size_t i) const {
    const MapPose start = network_.trajectory().NodePose(i);
    const ImuCorrection correction = calibration_.ImuAt(network_.trajectory().GyroBias(start.t_s),
                                                        network_.trajectory().AccelBias(start.t_s));
    const Preintegrated here = IdentityIncrement(*flight_.imu, start.t_s, correction);
    std::vector<DensePose> leg{{start, here.w_end_b_radps, here.f_end_b_mps2}};
    if (!has_leg_[i]) return leg;
    const MapPose end = network_.trajectory().NodePose(i + 1);
    IncrementalMotionIntegrator motion(*flight_.imu, start.t_s, correction);
    const Propagation from_start(flight_.frame, start, calibration_.GravitationAt(start.p_mb));
    const auto at = [&](double t_s) {
      const InertialIncrements increments = motion.To(t_s);
      return DensePose{from_start.To(increments), increments.w_end_b_radps,
                       increments.f_end_b_mps2};
    };
    for (const double t_s : EpochsBetween(start.t_s, end.t_s)) leg.push_back(at(t_s));
    Close(at(end.t_s).pose, end, &leg);
    return leg;
  }

 private:
  std::vector<double> EpochsBetween(double t0_s, double t1_s) const {
    std::vector<double> epochs;
    double last_s = t0_s;
    const auto [begin, past] = SampleRange(*flight_.imu, t0_s, t1_s);
    for (std::size_t k = begin; k < past; ++k) {
      const double t_s = flight_.imu->samples[k].t_s;
      if (t_s - last_s < min_spacing_s_ - kSameTime_s) continue;
      if (t1_s - t_s < std::max(kSameTime_s, 0.5 * min_spacing_s_)) continue;
      epochs.push_back(t_s);
      last_s = t_s;
    }
    return epochs;
  }

  static void Close(const MapPose& reached, const MapPose& end, std::vector<DensePose>* leg) {
    const Eigen::Vector3d dphi = Log(Eigen::Quaterniond(reached.q_mb.conjugate() * end.q_mb));
    const Eigen::Vector3d dp = end.p_mb - reached.p_mb;
    const Eigen::Vector3d dv = end.v_m - reached.v_m;
    const double t0_s = leg->front().pose.t_s;
    for (DensePose& inner : *leg) {
      const double share = (inner.pose.t_s - t0_s) / (end.t_s - t0_s);
      inner.pose.q_mb = inner.pose.q_mb * Exp(Eigen::Vector3d(share * dphi));
      inner.pose.p_mb += share * dp;
      inner.pose.v_m += share * dv;
    }
  }

  const FlightNetwork& network_;
  const Flight& flight_;
  CalibrationState calibration_;
  double min_spacing_s_;
  std::vector<bool> has_leg_;  // per node
};

NavPoint ToNavPoint(const DensePose& dense, const LocalFrame& frame) {
  NavPoint point = ToNavPoint(dense.pose, frame);
  point.w_b_radps = dense.w_b_radps;
  point.f_b_mps2 = dense.f_b_mps2;
  return point;
}

}  // namespace

std::vector<NavPoint> DenseTrajectory(const FlightNetwork& network, double min_spacing_s,
                                      int threads) {
  const DenseLegs legs(network, min_spacing_s);
  const std::size_t nodes = network.nodes().size();
  std::vector<std::vector<NavPoint>> parts(NumChunks(nodes, kNodesPerTask));
  ParallelForChunks(nodes, kNodesPerTask, threads,
                    [&](std::size_t chunk, std::size_t first, std::size_t past) {
                      for (std::size_t i = first; i < past; ++i) {
                        for (const DensePose& dense : legs.FromNode(i)) {
                          parts[chunk].push_back(ToNavPoint(dense, network.flight().frame));
                        }
                      }
                    });
  std::vector<NavPoint> points;
  for (const std::vector<NavPoint>& part : parts) {
    points.insert(points.end(), part.begin(), part.end());
  }
  return points;
}

}  // namespace dn
