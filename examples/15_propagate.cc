// The covariance of a function of several unknowns, compared with Monte Carlo.
//
// Two points and the offset of the instrument are estimated from distances. Wanted are length and
// slope of the line between the points, and their covariance. Prints the sigmas and the correlation
// from Propagate and from 2000 repeated surveys. Fails if they differ by more than chance allows.
#include <dn/network.h>
#include <dn/solvers/propagate.h>
#include <dn/solvers/solve.h>

#include <cmath>
#include <cstdio>
#include <random>

using Measures = Eigen::Vector2d;  // length in m, slope in rad

/// Surveys once, with new errors, and returns length and slope with their covariance.
dn::Propagated<2> Survey(std::mt19937_64& random) {
  constexpr double kSigma_m = 0.01, kOffset_m = 0.05;
  std::normal_distribution<double> noise(0.0, kSigma_m);
  dn::Network net;
  const auto a = net.AddVector<3>("a", {20, 30, 40}), b = net.AddVector<3>("b", {80, 60, 50});
  const auto offset = net.AddScalar("offset", 0.0);
  for (const Eigen::Vector3d& s :
       {Eigen::Vector3d(0, 0, 0), {100, 0, 0}, {0, 100, 5}, {100, 100, 0}, {50, 50, 90}}) {
    for (const auto point : {a, b}) {
      const double measured_m = (net.Value(point) - s).norm() + kOffset_m + noise(random);
      net.Add([=](const auto& p, const auto& o) { return (p - s).norm() + o - measured_m; },
              dn::Noise<1>::Sigma(kSigma_m), point, offset);
    }
  }
  if (!dn::Solve(net).converged) std::printf("not converged\n");
  const auto length_and_slope = [](const auto& p, const auto& q) {
    using std::asin;
    const auto line = (q - p).eval();
    const auto length = line.norm();
    return Eigen::Matrix<std::decay_t<decltype(length)>, 2, 1>(length, asin(line.z() / length));
  };
  return dn::Propagate(dn::Marginals(net), length_and_slope, a, b);
}

int main() {
  constexpr int kSurveys = 2000;
  std::mt19937_64 random(1);
  const Eigen::Matrix2d C = Survey(random).covariance;
  Eigen::Matrix2Xd values(2, kSurveys);
  for (int k = 0; k < kSurveys; ++k) values.col(k) = Survey(random).value;
  values.colwise() -= Measures(values.rowwise().mean());
  const Eigen::Matrix2d sampled = values * values.transpose() / (kSurveys - 1.0);
  for (const auto& [name, M] : {std::pair{"Propagate  ", C}, {"Monte Carlo", sampled}}) {
    std::printf("%s: sigma of the length %.1f mm, of the slope %.3f mrad, correlation %.2f\n", name,
                1e3 * std::sqrt(M(0, 0)), 1e3 * std::sqrt(M(1, 1)),
                M(0, 1) / std::sqrt(M(0, 0) * M(1, 1)));
  }
  const Eigen::Matrix2d L_inverse = Eigen::Matrix2d(C.llt().matrixL()).inverse();
  const Eigen::Matrix2d ratio = L_inverse * sampled * L_inverse.transpose();  // I if they agree
  return (ratio - Eigen::Matrix2d::Identity()).norm() < 4.0 * std::sqrt(6.0 / kSurveys) ? 0 : 1;
}
