#include <dn/error.h>
#include <dn/factors/point_to_control.h>

#include <utility>

#include "vector_kind.h"

namespace dn {
namespace {

using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr std::size_t kControlMounting = 3;
constexpr std::size_t kControlDeviation = 6;

std::size_t BridgeBlock(const PreparedControl& control) {
  return kControlDeviation + (control.with_datum_shift ? 2 : 1);
}

LidarPointBlocks MakeBlocks(const PreparedControl& control, LidarEffects lidar,
                            std::vector<GravitationBasis> attraction) {
  return {BridgeBlock(control) + (control.end.bridge ? 1 : 0), std::move(lidar),
          control.end.partial.linearisation.effects, std::move(attraction)};
}

std::vector<BlockKind> Kinds(const PreparedControl& control, const LidarPointBlocks& blocks) {
  std::vector<BlockKind> kinds{Rotation::kKind,
                               Vec<3>::kKind,
                               Vec<3>::kKind,
                               LeftRotation::kKind,
                               Vec<3>::kKind,
                               Vec<1>::kKind,
                               factors_internal::VectorKind(control.directions.cols())};
  if (control.with_datum_shift) kinds.push_back(Vec<3>::kKind);
  if (control.end.bridge) kinds.push_back(Rotation::kKind);
  blocks.AppendEffectKinds(&kinds);
  return kinds;
}

void Check(const PreparedControl& control) {
  factors_internal::CheckMounting("control point", control.R_bs_nominal);
  factors_internal::CheckEnd("control point", control.end);
  const Eigen::Index size = control.directions.cols(), rows = control.sqrt_information.rows();
  if (!control.z_m.allFinite() || !control.directions.allFinite() ||
      !control.sqrt_information.allFinite()) {
    throw InvalidInput("control point: its position, directions or information are not finite");
  }
  if ((size != 1 && size != 3) || (rows != 1 && rows != 3)) {
    throw InvalidInput("control point: " + std::to_string(size) + " directions and " +
                       std::to_string(rows) + " residuals, must be 1 or 3 each");
  }
}

}  // namespace

PointToControl::PointToControl(const LocalFrame& frame, const PreparedControl& control,
                               LidarEffects lidar, std::vector<GravitationBasis> attraction)
    : PointToControl(frame, control, MakeBlocks(control, std::move(lidar), std::move(attraction))) {
}

PointToControl::PointToControl(const LocalFrame& frame, const PreparedControl& control,
                               LidarPointBlocks blocks)
    : DynamicFactor(static_cast<int>(control.sqrt_information.rows()), Kinds(control, blocks)),
      blocks_(std::move(blocks)),
      end_(frame, control.end, {kControlMounting, control.R_bs_nominal}, 0, BridgeBlock(control)),
      z_m_(control.z_m),
      directions_(control.directions),
      W_(control.sqrt_information),
      with_datum_shift_(control.with_datum_shift) {
  Check(control);
}

bool PointToControl::Evaluate(double const* const* x, double* r, double** J) const {
  const LidarPointBetweenNodes::State at = end_.At(blocks_, x);
  const LidarPoint::Derivatives of = at.point.DifferentiateAt(at.arguments);
  const Eigen::Map<const Eigen::VectorXd> deviation(x[kControlDeviation], directions_.cols());
  Vector3d distance = of.x - at.arguments.ddt_s * of.rate - z_m_ - directions_ * deviation;
  if (with_datum_shift_) distance += Eigen::Map<const Vector3d>(x[kControlDeviation + 1]);
  Eigen::Map<Eigen::VectorXd>(r, residual_size()) = W_ * distance;
  if (J == nullptr) return true;

  Eigen::Matrix3d J_q = of.q;
  if (end_.has_bridge()) {
    const Eigen::Matrix<double, 3, 9> by_increments = at.IncrementJacobian();
    J_q += by_increments * at.bridged.J_q;
    Put(static_cast<int>(end_.node_after()), x, J,
        MatrixXd(W_ * by_increments * at.bridged.J_q_after));
  }
  Put(0, x, J, MatrixXd(W_ * J_q));
  Put(1, x, J, MatrixXd(W_ * of.p));
  Put(2, x, J, MatrixXd(W_ * of.v));
  Put(3, x, J,
      MatrixXd(W_ * of.theta *
               factors_internal::FromBoresightBlock(at.theta, x[kControlMounting])));
  Put(4, x, J, MatrixXd(W_ * of.a_b));
  Put(5, x, J, MatrixXd(-W_ * of.rate));
  Put(static_cast<int>(kControlDeviation), x, J, MatrixXd(-W_ * directions_));
  if (with_datum_shift_) Put(static_cast<int>(kControlDeviation) + 1, x, J, MatrixXd(W_));
  if (blocks_.num_effects() == 0) return true;

  Matrix3Xd J_x_c = Matrix3Xd::Zero(3, blocks_.NumEffectValues());
  end_.AddEffects(blocks_, at, end_.Sensitivity(at, of, Eigen::Matrix3d::Identity()), &J_x_c);
  Eigen::Index column = 0;
  for (std::size_t block = blocks_.first_effect; block < block_kinds().size(); ++block) {
    const int size = block_kinds()[block].stored_size;
    Put(static_cast<int>(block), x, J, MatrixXd(W_ * J_x_c.middleCols(column, size)));
    column += size;
  }
  return true;
}

}  // namespace dn
