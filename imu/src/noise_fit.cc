#include <dn/error.h>
#include <dn/imu/allan.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace dn {
namespace {

// Quantiles 99.9 % of chi-square with 1 and 2 degrees of freedom.
constexpr double kKeep1 = 10.83, kKeep2 = 13.82;
// Limits of the correlation time: a faster Gauss-Markov process looks like white noise, a slower
// one like a random walk.
constexpr double kShortestCorrelation = 2.0;  // times the shortest cluster time
constexpr double kLongestCorrelation = 1.0;   // times the longest cluster time
// Over fewer samples than this, filters and resolution add noise that is not white.
constexpr double kFewestSamples = 10.0;
// Relative accuracy of the deviation to which a real sensor follows the three terms.
constexpr double kModelAccuracy = 0.02;

enum Term : std::size_t { kWhite, kGaussMarkov, kRandomWalk, kTerms };
using Chosen = std::array<bool, kTerms>;

double UnitVariance(std::size_t term, double tau_s, double correlation_s) {
  switch (term) {
    case kWhite:
      return 1.0 / tau_s;
    case kGaussMarkov:
      return GaussMarkovAllanVariance(tau_s, correlation_s);
    default:
      return tau_s / 3.0;
  }
}

/// Amplitudes (variances) of the chosen terms, and the correlation time. They are fitted in
/// logarithms: all remain positive, and factors of 2 and 1/2 are equally far away.
struct TermModel {
  Chosen chosen{};
  std::array<double, kTerms> amplitude{};
  double correlation_s = 1.0;
  double chi2 = 1e300;
  Eigen::MatrixXd covariance;  // covariance of the logarithms, in the order of Gradient

  double Variance(double tau_s) const {
    double sum = 0.0;
    for (std::size_t term = 0; term < kTerms; ++term) {
      if (chosen[term]) sum += amplitude[term] * UnitVariance(term, tau_s, correlation_s);
    }
    return sum;
  }
  int NumParameters() const {
    return static_cast<int>(std::count(chosen.begin(), chosen.end(), true)) +
           (chosen[kGaussMarkov] ? 1 : 0);
  }
};

class Fitter {
 public:
  explicit Fitter(const std::vector<AllanPoint>& curve) : curve_(curve) {}

  /// Returns the best fit of a choice of terms, over several initial correlation times.
  TermModel Fit(const Chosen& chosen) const {
    TermModel best;
    const double shortest_s = Shortest(), longest_s = Longest();
    const int starts = chosen[kGaussMarkov] ? 8 : 1;
    for (int k = 0; k < starts; ++k) {
      TermModel model;
      model.chosen = chosen;
      model.correlation_s = shortest_s * std::pow(longest_s / shortest_s, (k + 0.5) / starts);
      Start(&model);
      Minimise(&model);
      if (model.chi2 < best.chi2) best = model;
    }
    return best;
  }

 private:
  double Shortest() const { return kShortestCorrelation * curve_.front().tau_s; }
  double Longest() const { return kLongestCorrelation * curve_.back().tau_s; }

  // Starts with equal shares of the largest amplitude that each term can have alone.
  void Start(TermModel* model) const {
    const auto terms =
        static_cast<double>(std::count(model->chosen.begin(), model->chosen.end(), true));
    for (std::size_t term = 0; term < kTerms; ++term) {
      double most = 1e300;
      for (const AllanPoint& p : curve_) {
        most = std::min(most, p.variance / UnitVariance(term, p.tau_s, model->correlation_s));
      }
      model->amplitude[term] = most / terms;
    }
  }

  // This uses that the logarithm of a variance with d degrees of freedom has mean -1/d and variance
  // 2/d.
  double Residual(const TermModel& model, const AllanPoint& p) const {
    return std::sqrt(0.5 * p.dof) *
           (std::log(p.variance) + 1.0 / p.dof - std::log(model.Variance(p.tau_s)));
  }

  double Chi2(const TermModel& model) const {
    double sum = 0.0;
    for (const AllanPoint& p : curve_) sum += std::pow(Residual(model, p), 2);
    return std::isfinite(sum) ? sum : 1e300;
  }

  // Returns d residual / d log parameter, first for the chosen terms, then for the correlation
  // time.
  Eigen::VectorXd Gradient(const TermModel& model, const AllanPoint& p) const {
    constexpr double kStep = 1e-4;
    Eigen::VectorXd gradient(model.NumParameters());
    const double weight = -std::sqrt(0.5 * p.dof) / model.Variance(p.tau_s);
    Eigen::Index column = 0;
    for (std::size_t term = 0; term < kTerms; ++term) {
      if (!model.chosen[term]) continue;
      gradient[column++] =
          weight * model.amplitude[term] * UnitVariance(term, p.tau_s, model.correlation_s);
    }
    if (model.chosen[kGaussMarkov]) {
      const double up = GaussMarkovAllanVariance(p.tau_s, model.correlation_s * (1.0 + kStep));
      const double down = GaussMarkovAllanVariance(p.tau_s, model.correlation_s * (1.0 - kStep));
      gradient[column] = weight * model.amplitude[kGaussMarkov] * (up - down) / (2.0 * kStep);
    }
    return gradient;
  }

  TermModel Moved(const TermModel& model, const Eigen::VectorXd& step) const {
    TermModel moved = model;
    Eigen::Index column = 0;
    for (std::size_t term = 0; term < kTerms; ++term) {
      if (model.chosen[term]) moved.amplitude[term] *= std::exp(step[column++]);
    }
    if (model.chosen[kGaussMarkov]) {
      moved.correlation_s =
          std::clamp(model.correlation_s * std::exp(step[column]), curve_.front().tau_s, Longest());
    }
    moved.chi2 = Chi2(moved);
    return moved;
  }

  void Minimise(TermModel* model) const {
    constexpr int kIterations = 200;
    constexpr double kConverged = 1e-9, kLongestStep = 2.0;
    double damping = 1e-3;
    model->chi2 = Chi2(*model);
    const Eigen::Index n = model->NumParameters();
    Eigen::MatrixXd N(n, n);
    for (int iteration = 0; iteration < kIterations && damping < 1e12; ++iteration) {
      N.setZero();
      Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
      for (const AllanPoint& p : curve_) {
        const Eigen::VectorXd gradient = Gradient(*model, p);
        N += gradient * gradient.transpose();
        b += gradient * Residual(*model, p);
      }
      Eigen::MatrixXd damped = N;
      damped.diagonal() += damping * (N.diagonal().array() + 1e-12).matrix();
      Eigen::VectorXd step = -damped.ldlt().solve(b);
      step *= std::min(1.0, kLongestStep / std::max(1e-300, step.cwiseAbs().maxCoeff()));
      const TermModel moved = Moved(*model, step);
      if (moved.chi2 > model->chi2) {
        damping *= 5.0;
        continue;
      }
      const bool converged = model->chi2 - moved.chi2 < kConverged * (1.0 + moved.chi2);
      *model = moved;
      damping = std::max(1e-9, 0.2 * damping);
      if (converged) break;
    }
    N.diagonal().array() += 1e-12;
    model->covariance = N.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
  }

  const std::vector<AllanPoint>& curve_;
};

// Adds terms as long as chi-square improves enough, then removes the terms that are no longer
// needed.
TermModel ChooseTerms(const Fitter& fitter) {
  const auto price = [](std::size_t term) { return term == kGaussMarkov ? kKeep2 : kKeep1; };
  const auto with = [](const TermModel& model, std::size_t term, bool chosen) {
    Chosen changed = model.chosen;
    changed[term] = chosen;
    return changed;
  };
  TermModel best;
  for (std::size_t term : {kWhite, kRandomWalk}) {
    const TermModel alone = fitter.Fit(with(TermModel{}, term, true));
    if (alone.chi2 < best.chi2) best = alone;
  }
  for (bool changed = true; changed;) {
    changed = false;
    TermModel next = best;
    double gain = 0.0;
    for (std::size_t term = 0; term < kTerms; ++term) {
      if (best.chosen[term]) continue;
      const TermModel more = fitter.Fit(with(best, term, true));
      const double more_gain = best.chi2 - more.chi2 - price(term);
      if (more_gain <= gain) continue;
      gain = more_gain;
      next = more;
    }
    if (gain > 0.0) {
      best = next;
      changed = true;
    }
  }
  for (std::size_t term = 0; term < kTerms; ++term) {
    if (!best.chosen[term] || best.NumParameters() == 1) continue;
    const Chosen fewer_terms = with(best, term, false);
    if (std::none_of(fewer_terms.begin(), fewer_terms.end(), [](bool c) { return c; })) continue;
    const TermModel fewer = fitter.Fit(fewer_terms);
    if (fewer.chi2 - best.chi2 < price(term)) best = fewer;
  }
  return best;
}

NoiseFit ToFit(const TermModel& model, const std::vector<AllanPoint>& curve) {
  NoiseFit fit;
  fit.chi2 = model.chi2;
  fit.dof = static_cast<int>(curve.size()) - model.NumParameters();
  const double scale2 = fit.dof > 0 ? std::max(1.0, fit.chi2 / fit.dof) : 1.0;
  Eigen::Index column = 0;
  const auto root = [&](std::size_t term) -> std::optional<NoiseTerm> {
    if (!model.chosen[term]) return std::nullopt;
    const double value = std::sqrt(model.amplitude[term]);
    const double sigma_log = std::sqrt(scale2 * model.covariance(column, column));
    ++column;
    return NoiseTerm{value, 0.5 * value * sigma_log};
  };
  fit.white = root(kWhite);
  fit.gauss_markov = root(kGaussMarkov);
  fit.random_walk = root(kRandomWalk);
  if (model.chosen[kGaussMarkov]) {
    const double sigma_log = std::sqrt(scale2 * model.covariance(column, column));
    fit.gauss_markov_tau_s = NoiseTerm{model.correlation_s, model.correlation_s * sigma_log};
  }
  const auto lowest = std::min_element(
      curve.begin(), curve.end(),
      [](const AllanPoint& a, const AllanPoint& b) { return a.variance < b.variance; });
  fit.floor = lowest->deviation();
  fit.floor_tau_s = lowest->tau_s;
  fit.longest_tau_s = curve.back().tau_s;
  return fit;
}

// Returns the points of the curve to fit. The accuracy of each is limited to that of the model.
std::vector<AllanPoint> Usable(const std::vector<AllanPoint>& curve) {
  constexpr double kModelDof = 1.0 / (2.0 * kModelAccuracy * kModelAccuracy);
  std::vector<AllanPoint> usable;
  for (AllanPoint p : curve) {
    if (p.tau_s < kFewestSamples * curve.front().tau_s || !(p.variance > 0.0)) continue;
    p.dof = 1.0 / (1.0 / p.dof + 1.0 / kModelDof);
    usable.push_back(p);
  }
  return usable;
}

double Square(const std::optional<NoiseTerm>& term) {
  return term ? term->value * term->value : 0.0;
}

}  // namespace

double NoiseFit::Variance(double tau_s) const {
  double sum = Square(white) / tau_s + Square(random_walk) * tau_s / 3.0;
  if (gauss_markov) {
    sum += Square(gauss_markov) * GaussMarkovAllanVariance(tau_s, gauss_markov_tau_s->value);
  }
  return sum;
}

SensorNoise NoiseFit::ToSensorNoise() const {
  SensorNoise noise;
  if (white) noise.white = white->value;
  if (gauss_markov) {
    noise.processes.push_back(
        {BiasProcess::Type::kGaussMarkov, gauss_markov->value, gauss_markov_tau_s->value});
  }
  if (random_walk) {
    noise.processes.push_back({BiasProcess::Type::kRandomWalk, random_walk->value, 0.0});
  }
  return noise;
}

NoiseFit FitNoise(const std::vector<AllanPoint>& curve) {
  constexpr std::size_t kFewestPoints = 4;
  const std::vector<AllanPoint> usable = Usable(curve);
  if (usable.size() < kFewestPoints) {
    throw InvalidInput("noise terms: an Allan curve of " + std::to_string(usable.size()) +
                       " usable points is too short; make a longer recording");
  }
  return ToFit(ChooseTerms(Fitter(usable)), usable);
}

}  // namespace dn
