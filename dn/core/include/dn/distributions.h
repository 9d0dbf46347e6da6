#pragma once

#include <vector>

namespace dn {

/// A two-sided interval.
struct Interval {
  double low = 0.0;
  double high = 0.0;
  bool Contains(double x) const { return x >= low && x <= high; }
};

/// Returns the probability that a chi-square variable with dof > 0 degrees of freedom is below x.
double ChiSquareCdf(double x, double dof);

/// Returns the probability that a chi-square variable exceeds x. Tiny probabilities also have full
/// relative accuracy.
double ChiSquareTail(double x, double dof);

/// Returns the inverse of ChiSquareCdf for 0 < p < 1.
double ChiSquareQuantile(double p, double dof);

/// Returns the interval that contains a chi-square variable divided by its dof with the given
/// probability; both tails are equal. If the covariance is correct, the mean NEES of n independent
/// errors of dimension d is in ChiSquareInterval(p, n d) with probability p.
Interval ChiSquareInterval(double probability, double dof);

/// Returns the quantile of the standard normal distribution for 0 < p < 1.
double NormalQuantile(double p);

/// Returns the interval that contains the success rate of n trials of probability p with at least
/// the given probability. Both tails are equal (exact binomial).
Interval BinomialInterval(double probability, long n, double p);

/// Returns the p-value of the Kolmogorov-Smirnov test that the values are uniform on [0, 1]. Each
/// value is a rank among `reference_size` other values, so its resolution is one step of these.
/// `values` must not be empty.
double UniformityPValue(std::vector<double> values, double reference_size);

}  // namespace dn
