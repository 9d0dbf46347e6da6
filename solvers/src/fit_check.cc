#include <dn/distributions.h>
#include <dn/error.h>
#include <dn/median.h>
#include <dn/solvers/fit_check.h>
#include <dn/solvers/prediction.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace dn {
namespace {

// Below this redundancy number a row is fully absorbed by the fit and cannot be tested.
constexpr double kFittedAway = 1e-6;
constexpr double kLeastRedundancy = 1e-12;

void RequireProbability(const char* option, double value) {
  if (value > 0.0 && value < 1.0) return;
  throw InvalidConfig(std::string("row test: option ") + option + " is " + std::to_string(value) +
                      ", must be in (0, 1)");
}

/// Returns the row with the largest |w| among the rows accepted by `wanted`.
template <class Wanted>
RowFit Worst(const LinearizedNetwork& linearized, const Eigen::VectorXd& residual,
             const Eigen::VectorXd& redundancy, const Wanted& wanted) {
  Eigen::Index worst_row = -1;
  double worst = 0.0;
  for (Eigen::Index row = 0; row < redundancy.size(); ++row) {
    if (redundancy[row] <= kFittedAway || !wanted(row)) continue;
    const double w = residual[row] / std::sqrt(redundancy[row]);
    if (std::abs(w) <= std::abs(worst)) continue;
    worst = w;
    worst_row = row;
  }
  if (worst_row < 0) return {};
  return {FindRow(linearized, worst_row), worst, redundancy[worst_row]};
}

double MedianDetectable(const ResidualForm& form, const Eigen::VectorXd& redundancy,
                        const OutlierTest& test) {
  std::vector<double> numbers;
  for (std::size_t row = 0; row < form.label.size(); ++row) {
    if (form.label[row] >= 0) numbers.push_back(redundancy[static_cast<Eigen::Index>(row)]);
  }
  return test.MinimalDetectableBias(Median(std::move(numbers)));
}

double TwoSided(double above, double below) { return std::min(1.0, 2.0 * std::min(above, below)); }

}  // namespace

double OutlierTest::NonCentrality() const {
  RequireProbability("alpha", alpha);
  RequireProbability("power", power);
  return NormalQuantile(1.0 - 0.5 * alpha) + NormalQuantile(power);
}

double OutlierTest::MinimalDetectableBias(double redundancy) const {
  if (redundancy <= kFittedAway) return std::numeric_limits<double>::infinity();
  return NonCentrality() / std::sqrt(redundancy);
}

double ChannelPValue(double redundancy, const FormMoments& moments, double energy) {
  const FormMoments exact_mean{redundancy, moments.variance, moments.samples};
  return TwoSided(exact_mean.UpperTail(energy), exact_mean.LowerTail(energy));
}

ChannelFit TestChannel(const LinearizedNetwork& linearized, const Eigen::VectorXd& residual,
                       const ResidualForm& form, const FormMoments& moments,
                       const Eigen::VectorXd& redundancy, const OutlierTest& test) {
  const auto takes_part = [&](Eigen::Index row) {
    return form.label[static_cast<std::size_t>(row)] >= 0;
  };
  ChannelFit fit;
  fit.name = form.name;
  for (Eigen::Index row = 0; row < redundancy.size(); ++row) {
    if (!takes_part(row)) continue;
    ++fit.observations;
    fit.redundancy += redundancy[row];
  }
  const double energy = form.Energy(residual);
  fit.variance_ratio = energy / std::max(fit.redundancy, kLeastRedundancy);
  fit.p_value = ChannelPValue(fit.redundancy, moments, energy);
  fit.worst = Worst(linearized, residual, redundancy, takes_part);
  fit.minimal_detectable = MedianDetectable(form, redundancy, test);
  return fit;
}

FitCheck CheckFit(const Marginals& marginals, const OutlierTest& test) {
  const LinearizedNetwork& linearized = marginals.linearized();
  const Eigen::VectorXd redundancy = RedundancyNumbers(marginals);
  FitCheck check;
  check.chi2 = linearized.residual().squaredNorm();
  check.redundancy = static_cast<long>(linearized.rows()) - linearized.parameters();
  if (check.redundancy > 0) {
    const auto dof = static_cast<double>(check.redundancy);
    check.sigma0 = std::sqrt(check.chi2 / dof);
    check.p_value = TwoSided(ChiSquareTail(check.chi2, dof), ChiSquareCdf(check.chi2, dof));
  }
  const std::vector<ResidualForm> forms = ChannelForms(linearized);
  const std::vector<FormMoments> moments = ComputeFormMoments(marginals, forms);
  for (std::size_t i = 0; i < forms.size(); ++i) {
    check.channels.push_back(
        TestChannel(linearized, linearized.residual(), forms[i], moments[i], redundancy, test));
  }
  check.worst =
      Worst(linearized, linearized.residual(), redundancy, [](Eigen::Index) { return true; });
  const double w = check.worst.standardised;
  if (w != 0.0) {
    check.worst_p_value =
        std::min(1.0, static_cast<double>(linearized.rows()) * ChiSquareTail(w * w, 1.0));
  }
  return check;
}

}  // namespace dn
