// The same factor in three ways: a function, a class that defines its residual, and a class with
// its own Jacobians. The factor is a bearing to a landmark from a place in the plane.
//
// Prints the landmark and its sigmas for each way; they are the same.
#include <dn/network.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <cmath>
#include <cstdio>

constexpr double kSigma_rad = 0.001;

/// Second way: r = (bearing of the landmark from (x, y) - measured) / sigma      [1], unitless; rad
struct Bearing : dn::AutoFactor<Bearing, 1, dn::Vec<2>, dn::Vec<2>> {
  double measured_rad = 0.0, sigma_rad = 1.0;

  template <class T>
  bool Residual(const T* from, const T* to, T* r) const {
    using std::atan2;
    r[0] = (atan2(to[1] - from[1], to[0] - from[0]) - measured_rad) / sigma_rad;
    return true;
  }
};

/// Third way: the same with analytic Jacobians -u and u, u = (-dy, dx) / (dx^2 + dy^2) / sigma.
class AnalyticBearing final : public dn::Factor<AnalyticBearing, 1, dn::Vec<2>, dn::Vec<2>> {
 public:
  AnalyticBearing(double measured_rad, double sigma_rad)
      : measured_rad_(measured_rad), sigma_rad_(sigma_rad) {}

  bool Evaluate(double const* const* x, double* r, double** J) const override {
    const Eigen::Vector2d d(x[1][0] - x[0][0], x[1][1] - x[0][1]);
    if (d.isZero(0.0)) return false;  // undefined: the adjustment reports it and names the factor
    const Eigen::RowVector2d u = Eigen::RowVector2d(-d.y(), d.x()) / (d.squaredNorm() * sigma_rad_);
    Put<0>(x, J, -u);
    Put<1>(x, J, u);
    r[0] = (std::atan2(d.y(), d.x()) - measured_rad_) / sigma_rad_;
    return true;
  }

 private:
  double measured_rad_, sigma_rad_;
};

/// Solves for a landmark from three known places; add(net, place, landmark, bearing) adds a factor.
template <class Add>
void Locate(const char* way, const Add& add) {
  dn::Network net;
  const auto landmark = net.AddVector<2>("landmark", {50.0, 50.0});
  const double seen[3][3] = {{0, 0, 0.9273}, {100, 0, 2.0344}, {0, 100, -0.3217}};
  for (const auto& row : seen) {
    const auto place = net.AddVector<2>(std::to_string(net.num_blocks()), {row[0], row[1]});
    net.Hold(place);
    add(net, place, landmark, row[2]);
  }
  const bool converged = dn::Solve(net).converged;
  const Eigen::Vector2d sigma_m = dn::MarginalSigma(net, landmark);
  std::printf("%-9s %s %.4f %.4f m, sigma %.4f %.4f m\n", way, converged ? "at" : "not solved",
              net.Value(landmark).x(), net.Value(landmark).y(), sigma_m.x(), sigma_m.y());
}

int main() {
  Locate("function", [](auto& net, auto place, auto landmark, double measured_rad) {
    net.Add(
        [=](const auto& from, const auto& to) {
          using std::atan2;
          return atan2(to[1] - from[1], to[0] - from[0]) - measured_rad;
        },
        dn::Noise<1>::Sigma(kSigma_rad), place, landmark);
  });
  Locate("residual", [](auto& net, auto place, auto landmark, double measured_rad) {
    Bearing factor;
    factor.measured_rad = measured_rad;
    factor.sigma_rad = kSigma_rad;
    net.Add(factor, place, landmark);
  });
  Locate("Jacobians", [](auto& net, auto place, auto landmark, double measured_rad) {
    net.Add(AnalyticBearing(measured_rad, kSigma_rad), place, landmark);
  });
  return 0;
}
