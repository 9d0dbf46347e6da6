// The noise of a sensor from a record at rest: Allan variance and fitted terms.
//
// Four hours of a gyro are simulated, with white noise and a Gauss-Markov process. Prints some
// points of the curve, and the terms with sigmas. Fails unless the terms are within four sigmas of
// the truth.
#include <dn/imu/allan.h>
#include <dn/sim/error_process.h>
#include <dn/sim/random.h>

#include <cmath>
#include <cstdio>
#include <vector>

/// Prints a term and returns true if it is within four sigmas of the truth.
bool Check(const char* name, const std::optional<dn::NoiseTerm>& term, double truth,
           const char* unit, double per_si) {
  if (!term) {
    std::printf("%s was not found\n", name);
    return false;
  }
  std::printf("%s %.4f, sigma %.4f %s (truth %.4f)\n", name, per_si * term->value,
              per_si * term->sigma, unit, per_si * truth);
  return std::abs(term->value - truth) < 4.0 * term->sigma;
}

int main() {
  constexpr double kDt_s = 0.1, kTau_s = 20.0;
  const double white = dn::RadPerSqrtSFromDegPerSqrtHour(0.05);
  const double sigma = dn::RadpsFromDegPerHour(5.0);
  dn::Random random(1, "gyro");
  dn::ErrorProcess slow({dn::BiasProcess::Type::kGaussMarkov, sigma, kTau_s}, kDt_s, random);
  std::vector<double> rates_radps;
  for (int k = 0; k < 4 * 36000; ++k) {
    rates_radps.push_back(slow.NextMean(random) + white / std::sqrt(kDt_s) * random.Normal());
  }

  const std::vector<dn::AllanPoint> curve = dn::AllanVariance(rates_radps, kDt_s);
  for (std::size_t k = 3; k < curve.size(); k += 3) {
    std::printf("tau %6.1f s  deviation %.2f deg/h, sigma %.2f deg/h\n", curve[k].tau_s,
                dn::DegPerHourFromRadps(curve[k].deviation()),
                dn::DegPerHourFromRadps(curve[k].sigma_of_deviation()));
  }
  const dn::NoiseFit fit = dn::FitNoise(curve);
  const bool right[] = {
      Check("white noise", fit.white, white, "deg/sqrt(h)",
            1.0 / dn::RadPerSqrtSFromDegPerSqrtHour(1.0)),
      Check("Gauss-Markov sigma", fit.gauss_markov, sigma, "deg/h", dn::DegPerHourFromRadps(1.0)),
      Check("correlation time", fit.gauss_markov_tau_s, kTau_s, "s", 1.0)};
  return right[0] && right[1] && right[2] ? 0 : 1;
}
