#include "linear_pairs.h"

#include <dn/rotation.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "end_derivatives.h"

namespace dn::diagnosis_internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// More pairs give no additional information on the effects.
constexpr std::size_t kMaxLinearPairs = 20000;

/// Returns P^-1 of an end: position in map, attitude in body.
Eigen::Matrix<double, 6, 6> EndCovariance(const GaussHelmertEnd& end, const ErrorScale& scale) {
  const Matrix3d L = scale.position * end.q_mn.toRotationMatrix() * end.sigma_ned_m.asDiagonal();
  const Matrix3d F =
      scale.attitude * BodyFromEulerRates(end.down_b()) * end.sigma_rph_rad.asDiagonal();
  Eigen::Matrix<double, 6, 6> noise = Eigen::Matrix<double, 6, 6>::Zero();
  noise.topLeftCorner<3, 3>() = L * L.transpose();
  noise.bottomRightCorner<3, 3>() = F * F.transpose();
  return noise;
}

/// Returns a square root of the stated covariance of an error of the trajectory.
Eigen::Matrix<double, 6, 6> ErrorSqrt(const GaussHelmertCalibration& calibration) {
  const TrajectoryAccuracy& accuracy = calibration.accuracy;
  const Eigen::Quaterniond& q_mn = calibration.problem.pairs.front().i.q_mn;
  Eigen::Matrix<double, 6, 6> root = Eigen::Matrix<double, 6, 6>::Zero();
  root.topLeftCorner<3, 3>() = q_mn.toRotationMatrix() * accuracy.sigma_ned_m.asDiagonal();
  root.bottomRightCorner<3, 3>() = accuracy.attitude_covariance_rad2.llt().matrixL();
  return root;
}

BoresightPrior MakeBoresightPrior(const GaussHelmertCalibration& calibration) {
  BoresightPrior prior;
  if (const auto& sigma_rad = calibration.problem.boresight_sigma_rad) {
    prior.weight = sigma_rad->cwiseAbs2().cwiseInverse().asDiagonal();
    prior.gradient = prior.weight * DeviationFromPrior(calibration);
  }
  return prior;
}

/// Linearises pairs and collects them.
class Lineariser {
 public:
  Lineariser(const Flight& flight, const GaussHelmertCalibration& calibration)
      : calibration_(calibration),
        derivatives_(flight, calibration.problem.lever_arm_b_m,
                     calibration.adjustment.boresight_rad) {}

  LinearPairs Run() {
    out_.error_sqrt = ErrorSqrt(calibration_);
    out_.prior = MakeBoresightPrior(calibration_);
    const auto kept = static_cast<std::size_t>(calibration_.adjustment.pairs_kept);
    const std::size_t every = 1 + kept / kMaxLinearPairs;
    std::size_t seen = 0;
    for (std::size_t k = 0; k < calibration_.problem.pairs.size(); ++k) {
      if (calibration_.adjustment.weights[k] > 0.0 && seen++ % every == 0) Add(k);
    }
    if (all_ > 0.0) out_.pair_noise_share = own_ / all_;
    return std::move(out_);
  }

 private:
  void Add(std::size_t k) {
    const GaussHelmertPair& pair = calibration_.problem.pairs[k];
    const PairCorrection& v = calibration_.adjustment.corrections[k];
    const PairLinearisation at =
        LinearisePair(pair, calibration_.problem.lever_arm_b_m, calibration_.options.model,
                      calibration_.adjustment.boresight_rad, v);
    const Matrix3d covariance = MisclosureCovariance(pair, at);
    own_ += pair.covariance_m2.trace();
    all_ += covariance.trace();
    const Matrix3d root = covariance.llt().matrixL();
    const Matrix3d W = std::sqrt(calibration_.adjustment.weights[k]) * Matrix3d(root.inverse());
    out_.rows.push_back({pair.i.t_s, pair.j.t_s, W * (at.w - at.B * v), W * at.A,
                         W * at.B.leftCols<6>(), W * at.B.rightCols<6>()});
    out_.whiten.push_back(W);
    out_.pair.push_back(k);
    out_.ends.push_back({static_cast<FactorId>(out_.ends.size()),
                         derivatives_.At(pair.i, v.segment<3>(3), W),
                         derivatives_.At(pair.j, v.segment<3>(9), -W)});
  }

  const GaussHelmertCalibration& calibration_;
  EndDerivatives derivatives_;
  LinearPairs out_;
  double own_ = 0.0, all_ = 0.0;  // m^2
};

}  // namespace

Matrix3d MisclosureCovariance(const GaussHelmertPair& pair, const PairLinearisation& at,
                              const ErrorScale& scale) {
  const auto B_i = at.B.leftCols<6>(), B_j = at.B.rightCols<6>();
  return pair.covariance_m2 + B_i * EndCovariance(pair.i, scale) * B_i.transpose() +
         B_j * EndCovariance(pair.j, scale) * B_j.transpose();
}

Vector3d DeviationFromPrior(const GaussHelmertCalibration& calibration) {
  return Log(Eigen::Quaterniond(Exp(calibration.boresight.angles_rad) *
                                Exp(calibration.problem.boresight_rad).conjugate()));
}

LinearPairs LinearisePairs(const Flight& flight, const GaussHelmertCalibration& calibration) {
  return Lineariser(flight, calibration).Run();
}

}  // namespace dn::diagnosis_internal
