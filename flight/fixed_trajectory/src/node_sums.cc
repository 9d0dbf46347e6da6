#include "node_sums.h"

#include <dn/rotation.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "gauss_helmert_pair.h"

namespace dn::fixed_trajectory_internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

Matrix3d MisclosureWeight(const GaussHelmertPair& pair, const PairLinearisation& linear) {
  Matrix3d M = pair.covariance_m2;
  int column = 3;
  for (const GaussHelmertEnd* end : {&pair.i, &pair.j}) {
    const PoseNoise noise = EvaluateNoise(*end);
    const Matrix3d L = linear.B.middleCols<3>(column) * noise.attitude_factor;
    M += noise.position + L * L.transpose();
    column += 6;
  }
  return M.inverse();
}

/// d w / d the unknowns that a pair has: the boresight, then the laser unknowns of its ends.
class UnknownColumns {
 public:
  static constexpr int kMost = 3 + LaserColumns::kMost;

  UnknownColumns(const Matrix3d& boresight, const LaserColumns& laser) : A_(3, 3 + laser.size()) {
    A_ << boresight, laser.A;
    for (std::size_t k = 0; k < static_cast<std::size_t>(laser.size()); ++k) {
      at_[3 + k] = 3 + laser.unknown[k];
    }
  }

  /// Calls work(unknown, column) for each.
  template <class Work>
  void ForEach(const Work& work) const {
    for (Eigen::Index k = 0; k < A_.cols(); ++k) {
      work(at_[static_cast<std::size_t>(k)], Vector3d(A_.col(k)));
    }
  }

 private:
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMost> A_;
  std::array<Eigen::Index, kMost> at_{0, 1, 2};
};

/// Accumulates NodeSums with error c of node n at index 6 n + c, and only the lower triangle of H.
class NodeAccumulator {
 public:
  NodeAccumulator(const TimeNodes& nodes, Eigen::Index unknowns)
      : nodes_(nodes), sums_(nodes.size(), unknowns), headings_(nodes) {}

  void Add(const GaussHelmertPair& pair, const UnknownColumns& columns, const EndJacobian& J_i,
           const EndJacobian& J_j, const Matrix3d& S, const Vector3d& w) {
    columns.ForEach([&](Eigen::Index row, const Vector3d& a) {
      const Vector3d Sa = S * a;
      sums_.g[row] += Sa.dot(w);
      columns.ForEach(
          [&](Eigen::Index column, const Vector3d& b) { sums_.N(row, column) += Sa.dot(b); });
    });
    sums_.chi2 += w.dot(S * w);
    const Ends ends = Spread(nodes_.At(pair.i.t_s), J_i, nodes_.At(pair.j.t_s), J_j);
    headings_.Add(pair.i);
    headings_.Add(pair.j);
    for (const End& end : ends) {
      const Eigen::Matrix<double, 6, 3> JtS = end.weight * end.J->transpose() * S;
      columns.ForEach([&](Eigen::Index column, const Vector3d& a) {
        sums_.N_e.col(column).segment<6>(6 * end.node) += JtS * a;
      });
      sums_.b.segment<6>(6 * end.node) += JtS * w;
      for (const End& other : ends) {
        if (other.node > end.node) continue;
        sums_.H.block<6, 6>(6 * end.node, 6 * other.node) += JtS * (other.weight * *other.J);
      }
    }
  }

  /// Returns the sums in the order of NodeSums.
  NodeSums Sums(const std::optional<Vector3d>& boresight_sigma_rad,
                const Eigen::MatrixXd& laser_information) {
    sums_.OrderByComponent();
    sums_.heading_rad = headings_.heading_rad();
    if (boresight_sigma_rad) {
      sums_.N.topLeftCorner<3, 3>() += boresight_sigma_rad->cwiseAbs2().cwiseInverse().asDiagonal();
    }
    const Eigen::Index laser = laser_information.rows();
    sums_.N.bottomRightCorner(laser, laser) += laser_information;
    return std::move(sums_);
  }

 private:
  struct End {
    int node;
    double weight;
    const EndJacobian* J;
  };
  using Ends = std::array<End, 4>;

  static Ends Spread(const TimeNodes::Place& i, const EndJacobian& J_i, const TimeNodes::Place& j,
                     const EndJacobian& J_j) {
    return {{{i.node, 1.0 - i.next, &J_i},
             {i.next_node, i.next, &J_i},
             {j.node, 1.0 - j.next, &J_j},
             {j.next_node, j.next, &J_j}}};
  }

  const TimeNodes& nodes_;
  NodeSums sums_;
  NodeHeadings headings_;
};

}  // namespace

NodeSums::NodeSums(Eigen::Index nodes, Eigen::Index unknowns) {
  H.setZero(6 * nodes, 6 * nodes);
  N_e.setZero(6 * nodes, unknowns);
  b.setZero(6 * nodes);
  N.setZero(unknowns, unknowns);
  g.setZero(unknowns);
}

void NodeSums::OrderByComponent() {
  const Eigen::Index T = b.size() / 6;
  Eigen::PermutationMatrix<Eigen::Dynamic> order(6 * T);
  for (Eigen::Index n = 0; n < T; ++n) {
    for (Eigen::Index c = 0; c < 6; ++c) {
      order.indices()[6 * n + c] = static_cast<int>(c * T + n);
    }
  }
  H.triangularView<Eigen::StrictlyUpper>() = H.transpose();
  H = order * H * order.transpose();
  N_e = order * N_e;
  b = order * b;
}

EndJacobian ErrorJacobian(const GaussHelmertEnd& end, const Matrix3d& J_phi,
                          const TrajectoryErrorOptions& options) {
  EndJacobian J;
  if (options.covariance) {
    J << Matrix3d::Identity(), J_phi;
    return J;
  }
  J << end.q_mn.toRotationMatrix() * options.sigma_ned_m.asDiagonal(),
      J_phi * BodyFromEulerRates(end.down_b()) * options.sigma_rph_rad.asDiagonal();
  return J;
}

void NodeHeadings::Add(const GaussHelmertEnd& end) {
  const TimeNodes::Place place = nodes_.At(end.t_s);
  const Vector3d forward_n = end.q_mn.conjugate() * (end.q_mb * Vector3d::UnitX());
  north_east_.row(place.node) += (1.0 - place.next) * forward_n.head<2>();
  north_east_.row(place.next_node) += place.next * forward_n.head<2>();
}

VectorXd NodeHeadings::heading_rad() const {
  return VectorXd::NullaryExpr(north_east_.rows(), [&](Eigen::Index n) {
    return std::atan2(north_east_(n, 1), north_east_(n, 0));
  });
}

NodeSums SumPairConditions(const GaussHelmertProblem& problem, const GaussHelmertResult& result,
                           BoresightModel model, const TrajectoryErrorOptions& options,
                           const TimeNodes& nodes) {
  NodeAccumulator sums(nodes, 3 + problem.laser.size());
  const VectorXd change = result.laser - problem.laser.start;
  for (std::size_t k = 0; k < problem.pairs.size(); ++k) {
    if (result.weights[k] == 0.0) continue;
    GaussHelmertPair pair = problem.pairs[k];
    if (problem.laser.size() > 0) {
      for (GaussHelmertEnd* end : {&pair.i, &pair.j}) end->u_b += VectorChange(end->laser, change);
    }
    const PairCorrection& v = result.corrections[k];
    const PairLinearisation linear =
        LinearisePair(pair, problem.lever_arm_b_m, model, result.boresight_rad, v);
    const EndJacobian J_i = ErrorJacobian(pair.i, linear.B.middleCols<3>(3), options);
    const EndJacobian J_j = -ErrorJacobian(pair.j, -linear.B.middleCols<3>(9), options);
    LaserColumns laser;
    if (problem.laser.size() > 0) {
      laser = PairLaserColumns(pair, model, result.boresight_rad, v);
    }
    sums.Add(pair, UnknownColumns(linear.A, laser), J_i, J_j,
             result.weights[k] * MisclosureWeight(pair, linear), linear.w - linear.B * v);
  }
  return sums.Sums(problem.boresight_sigma_rad, problem.laser.information);
}

}  // namespace dn::fixed_trajectory_internal
