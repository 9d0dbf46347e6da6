// A manifold of one's own: a direction, three numbers of length 1 that move in two ways.
//
// The direction of a distant beacon is estimated from sightings. Fails unless the error is within
// four sigmas and the covariance is that of the theory. CheckManifold throws if Plus and Minus
// disagree; AddBlock calls it too, for the first block of a kind.
#include <dn/manifold_check.h>
#include <dn/network.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <cstdio>
#include <random>

struct Direction {
  static constexpr int kSize = 3, kTangentSize = 2;
  /// Two unit vectors perpendicular to x and to each other (Duff et al. 2017, JCGT 6).
  template <class T>
  static Eigen::Matrix<T, 3, 2> Basis(const T* x) {
    const T s(x[2] < T(0.0) ? -1.0 : 1.0), a = -1.0 / (s + x[2]), b = a * x[0] * x[1];
    Eigen::Matrix<T, 3, 2> B;
    B << 1.0 + s * x[0] * x[0] * a, b, s * b, s + x[1] * x[1] * a, -s * x[0], -x[1];
    return B;
  }
  template <class T>
  static void Plus(const T* x, const T* d, T* x_plus_d) {
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> from(x);
    const Eigen::Map<const Eigen::Matrix<T, 2, 1>> step(d);
    Eigen::Map<Eigen::Matrix<T, 3, 1>> to(x_plus_d);
    to = (from + Basis(x) * step).normalized();
  }
  static void Minus(const double* y, const double* x, double* y_minus_x) {
    const Eigen::Map<const Eigen::Vector3d> from(x), to(y);
    Eigen::Map<Eigen::Vector2d> step(y_minus_x);
    step = Basis(x).transpose() * to / from.dot(to);
  }
};

int main() {
  constexpr double kSigma = 0.01, kSightings = 50;
  const Eigen::Vector3d truth = Eigen::Vector3d(0.3, -0.5, 0.8).normalized();
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, kSigma);
  dn::CheckManifold(dn::MakeBlockKind<Direction>(), truth.data(), "direction");
  dn::Network net;
  const auto beacon = net.AddBlock<Direction>("beacon", {1.0, 0.0, 0.0});
  for (int k = 0; k < kSightings; ++k) {
    const Eigen::Vector3d seen =
        truth + Eigen::Vector3d::NullaryExpr([&] { return noise(random); });
    net.Add([=](const auto& x) { return (x - seen).eval(); }, dn::Noise<3>::Sigma(kSigma), beacon);
  }
  const bool converged = dn::Solve(net).converged;
  const Eigen::Matrix2d C = dn::MarginalCovariance(net, beacon);
  const double theory = kSigma * kSigma / kSightings;
  Eigen::Vector2d error;
  Direction::Minus(net.Value(beacon).data(), truth.data(), error.data());
  std::printf("error %.1f %.1f mrad, sigma %.1f %.1f mrad\n", 1e3 * error.x(), 1e3 * error.y(),
              1e3 * std::sqrt(C(0, 0)), 1e3 * std::sqrt(C(1, 1)));
  const bool right = (C - theory * Eigen::Matrix2d::Identity()).norm() < 1e-9 * theory;
  return converged && right && error.norm() < 4.0 * std::sqrt(2.0 * theory) ? 0 : 1;
}
