#include "plant_offset.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace dn::matching_internal {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kRelativeSpread = 0.2;  // of the offset between strip pairs

// Order of the unknowns: offset, boresight, then position and attitude of each strip.
constexpr Index kBoresight = 1, kFirstStrip = 4, kPerStrip = 6;

Index StripUnknown(std::size_t strip) {
  return kFirstStrip + kPerStrip * static_cast<Index>(strip);
}

VectorXd PriorInformation(const PlantOptions& options) {
  const auto information = [](double sigma) { return 1.0 / (sigma * sigma); };
  VectorXd prior(StripUnknown(options.strips));
  prior[0] = information(options.offset_sigma_m);
  prior.segment<3>(kBoresight).setConstant(information(options.boresight_sigma_rad));
  for (std::size_t s = 0; s < options.strips; ++s) {
    const Index at = StripUnknown(s);
    prior.segment<3>(at).setConstant(information(options.strip_position_sigma_m));
    prior.segment<3>(at + 3).setConstant(information(options.strip_attitude_sigma_rad));
  }
  return prior;
}

/// Returns the derivative of p_i - p_j with respect to the unknowns.
MatrixXd PlantJacobian(const PlantPair& pair, const PairLinearisation& at, Index unknowns) {
  MatrixXd J = MatrixXd::Zero(3, unknowns);
  J.col(0) = pair.Effect();
  J.middleCols<3>(kBoresight) = -at.A;
  J.middleCols<kPerStrip>(StripUnknown(pair.strip_i)) -= at.B.leftCols<kPerStrip>();
  J.middleCols<kPerStrip>(StripUnknown(pair.strip_j)) -= at.B.rightCols<kPerStrip>();
  return J;
}

}  // namespace

PlantOffset EstimatePlantOffset(const std::vector<PlantPair>& pairs, const PlantOptions& options) {
  MatrixXd N = PriorInformation(options).asDiagonal();
  VectorXd h = VectorXd::Zero(N.rows());
  for (const PlantPair& pair : pairs) {
    const PairLinearisation at =
        LinearisePair(pair.pair, options.lever_arm_b_m, BoresightModel::kExponential,
                      options.boresight_rad, PairCorrection::Zero());
    const MatrixXd J = PlantJacobian(pair, at, N.rows());
    const MatrixXd WJ = pair.pair.covariance_m2.llt().solve(J);
    N += J.transpose() * WJ;
    h += WJ.transpose() * at.w;
  }
  const Eigen::LDLT<MatrixXd> solver(N);
  const double offset_m = solver.solve(h)[0];
  const double variance_m2 = solver.solve(VectorXd::Unit(N.rows(), 0))[0];
  return {offset_m, std::hypot(std::sqrt(variance_m2), kRelativeSpread * offset_m)};
}

}  // namespace dn::matching_internal
