// Robust losses: a trend from readings, one in five of them grossly wrong.
//
// The same readings are adjusted by least squares, with the loss of Huber and with that of Cauchy.
// Prints offset and slope with their errors in sigmas. Fails unless Cauchy is within four sigmas of
// the truth and nearer to it than Huber, which must be nearer than least squares.
#include <dn/network.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <cstdio>
#include <random>
#include <vector>

constexpr double kOffset = 2.0, kSlope = 0.5, kSigma = 0.1;

/// Returns the errors of offset and slope in units of their sigmas.
Eigen::Vector2d Fit(const char* name, const std::vector<double>& readings, const dn::Loss& loss) {
  dn::Network net;
  const auto offset = net.AddScalar("offset", 0.0), slope = net.AddScalar("slope", 0.0);
  for (std::size_t k = 0; k < readings.size(); ++k) {
    const double t = 0.1 * static_cast<double>(k), y = readings[k];
    const dn::FactorId id = net.Add([=](const auto& a, const auto& b) { return a + b * t - y; },
                                    dn::Noise<1>::Sigma(kSigma), offset, slope);
    net.SetLoss(id, loss);
  }
  if (!dn::Solve(net).converged) std::printf("not converged\n");
  const dn::Marginals marginals(net);
  const Eigen::Vector2d errors((net.Value(offset) - kOffset) / marginals.Sigma(offset),
                               (net.Value(slope) - kSlope) / marginals.Sigma(slope));
  std::printf("%-13s  offset %.2f +- %.2f (truth %.2f), slope %.3f +- %.3f (truth %.3f)\n", name,
              net.Value(offset), marginals.Sigma(offset), kOffset, net.Value(slope),
              marginals.Sigma(slope), kSlope);
  return errors;
}

int main() {
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, kSigma);
  std::uniform_real_distribution<double> uniform;
  std::vector<double> readings;
  for (int k = 0; k < 200; ++k) {
    readings.push_back(kOffset + kSlope * 0.1 * k + noise(random));
    if (uniform(random) < 0.2) readings.back() += 10.0 * uniform(random);  // too large, never small
  }
  const double plain = Fit("least squares", readings, {}).norm();
  const double huber = Fit("Huber", readings, dn::Loss::Huber(1.5)).norm();
  const Eigen::Vector2d cauchy = Fit("Cauchy", readings, dn::Loss::Cauchy(1.0));
  std::printf("errors in sigmas: least squares %.0f, Huber %.0f, Cauchy %.1f\n", plain, huber,
              cauchy.norm());
  return cauchy.cwiseAbs().maxCoeff() < 4.0 && cauchy.norm() < huber && huber < plain ? 0 : 1;
}
