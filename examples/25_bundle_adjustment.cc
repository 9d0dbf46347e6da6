// A bundle adjustment in the BAL format, solved by Ceres, with the sparse covariance of dn.
//
// Usage: example_25_bundle_adjustment [problem]; the default has six cameras and a noise of half a
// pixel. The first camera and a coordinate of the last fix the datum. Fails unless the residuals
// agree with the noise, and a covariance with ceres::Covariance.
#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <dn/solvers/fit_check.h>

#include <cstdio>
#include <fstream>

struct Reprojection {
  double x_px, y_px;

  template <class T>  // camera: rotation vector, translation, focal length, distortion (2)
  bool operator()(const T* camera, const T* point, T* r) const {
    T p[3];
    ceres::AngleAxisRotatePoint(camera, point, p);
    for (int i = 0; i < 3; ++i) p[i] += camera[3 + i];
    const T x = -p[0] / p[2], y = -p[1] / p[2], r2 = x * x + y * y;
    const T scale_px = camera[6] * (1.0 + r2 * (camera[7] + r2 * camera[8]));
    r[0] = (scale_px * x - x_px) / 0.5;
    r[1] = (scale_px * y - y_px) / 0.5;
    return true;
  }
};

int main(int argc, char** argv) {
  std::ifstream in(argc > 1 ? argv[1] : DN_EXAMPLE_BAL);
  int cameras = 0, points = 0, observations = 0;
  in >> cameras >> points >> observations;
  Eigen::MatrixXd camera(9, cameras), point(3, points);
  ceres::Problem problem;
  for (int k = 0, i = 0, j = 0; k < observations; ++k) {
    Reprojection seen{};
    in >> i >> j >> seen.x_px >> seen.y_px;
    using Cost = ceres::AutoDiffCostFunction<Reprojection, 2, 9, 3>;
    problem.AddResidualBlock(new Cost(new Reprojection(seen)), nullptr, camera.col(i).data(),
                             point.col(j).data());
  }
  for (double& x : camera.reshaped()) in >> x;
  for (double& x : point.reshaped()) in >> x;
  double *first = camera.data(), *last = camera.col(cameras - 1).data();
  problem.SetManifold(first, new ceres::SubsetManifold(9, {0, 1, 2, 3, 4, 5}));
  problem.SetManifold(last, new ceres::SubsetManifold(9, {3}));
  ceres::Solver::Summary summary;
  ceres::Solve({}, &problem, &summary);

  dn::Marginals marginals(problem);
  marginals.ComputeSelectedInverse();  // the covariances of all cameras and points
  const dn::FitCheck fit = dn::CheckFit(marginals);
  ceres::Covariance reference({});
  Eigen::Matrix<double, 8, 3, Eigen::RowMajor> C;
  if (!reference.Compute(std::vector{std::pair<const double*, const double*>(last, point.data())},
                         &problem)) {
    return 1;
  }
  reference.GetCovarianceBlockInTangentSpace(last, point.data(), C.data());
  const double difference = (marginals.Covariance(last, point.data()) - C).norm() / C.norm();
  const Eigen::Vector3d sigma_m = marginals.Covariance(point.data()).diagonal().cwiseSqrt();
  std::printf("%d points, sigma0 %.3f, p = %.2f; sigma of the first %.3f %.3f %.3f m\n", points,
              fit.sigma0, fit.p_value, sigma_m.x(), sigma_m.y(), sigma_m.z());
  std::printf("difference from ceres::Covariance %.0e\n", difference);
  return summary.IsSolutionUsable() && fit.p_value > 1e-4 && difference < 1e-6 ? 0 : 1;
}
