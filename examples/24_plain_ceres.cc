// A program of Ceres that takes factors, manifolds and covariances from dn.
//
// A tripod turns an antenna arm through eight attitudes, measured by a compass, while GNSS measures
// the antenna. The arm is unknown. Fails unless dn::Marginals and ceres::Covariance agree, and the
// arm is within four sigmas of the truth.
#include <ceres/covariance.h>
#include <ceres/solver.h>
#include <dn/ceres.h>
#include <dn/factors/gnss_position.h>
#include <dn/factors/prior.h>
#include <dn/solvers/marginals.h>

#include <cmath>
#include <cstdio>
#include <random>

int main() {
  constexpr int kAttitudes = 8;
  const Eigen::Vector3d true_arm_b(0.4, -0.1, -1.1);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sigma) {
    return (sigma * Eigen::Vector3d::NullaryExpr([&] { return normal(random); })).eval();
  };

  Eigen::Quaterniond q[kAttitudes];
  Eigen::Vector3d arm_b(0.0, 0.0, 0.0), origin_m(0.0, 0.0, 0.0);
  ceres::Problem problem;
  for (int k = 0; k < kAttitudes; ++k) {
    const Eigen::Quaterniond truth =
        dn::Exp(Eigen::Vector3d(std::sin(k), std::cos(2 * k), 0.8 * k));
    const Eigen::Quaterniond compass = truth * dn::Exp(noise(0.01));
    const Eigen::Vector3d antenna_m = truth * true_arm_b + noise(0.02);
    q[k] = compass;
    double* q_k = q[k].coeffs().data();
    problem.AddParameterBlock(q_k, 4, dn::MakeCeresManifold<dn::Rotation>().release());
    const dn::PriorRotation attitude(compass, dn::Noise<3>::Sigma(0.01));
    const dn::GnssPosition position(antenna_m, dn::Noise<3>::Sigma(0.02));
    problem.AddResidualBlock(dn::MakeCostFunction(attitude).release(), nullptr, q_k);
    problem.AddResidualBlock(dn::MakeCostFunction(position).release(), nullptr, q_k,
                             origin_m.data(), arm_b.data());
  }
  ceres::Solver::Summary summary;
  ceres::Solve({}, &problem, &summary);

  const dn::Marginals marginals(problem);
  ceres::Covariance reference({});
  if (!reference.Compute({{arm_b.data(), arm_b.data()}, {q[3].coeffs().data(), arm_b.data()}},
                         &problem)) {
    return 1;
  }
  double largest = 0.0;
  for (const double* block : {arm_b.data(), q[3].coeffs().data()}) {
    Eigen::Matrix<double, 3, 3, Eigen::RowMajor> C;
    reference.GetCovarianceBlockInTangentSpace(block, arm_b.data(), C.data());
    largest = std::max(largest, (marginals.Covariance(block, arm_b.data()) - C).norm() / C.norm());
  }
  const Eigen::Vector3d sigma_m = marginals.Covariance(arm_b.data()).diagonal().cwiseSqrt();
  for (int i = 0; i < 3; ++i) std::printf("arm %.3f +- %.3f m\n", arm_b[i], sigma_m[i]);
  std::printf("largest difference from ceres::Covariance %.0e\n", largest);
  const double worst = (arm_b - true_arm_b).cwiseQuotient(sigma_m).cwiseAbs().maxCoeff();
  return summary.IsSolutionUsable() && largest < 1e-8 && worst < 4.0 ? 0 : 1;
}
