#pragma once

#include <vector>

namespace dn {

/// A two-sided interval.
struct Interval {
  double low = 0.0;
  double high = 0.0;
  bool Contains(double x) const { return x >= low && x <= high; }
};

/// Probability that a chi-square variable with dof > 0 degrees of freedom stays below x.
double ChiSquareCdf(double x, double dof);

/// Probability that it exceeds x, to full relative accuracy also where that is tiny.
double ChiSquareTail(double x, double dof);

/// Inverse of ChiSquareCdf for 0 < p < 1.
double ChiSquareQuantile(double p, double dof);

/// Interval that holds a chi-square variable divided by its dof with the given probability, equal
/// tails. The mean NEES of n independent errors of dimension d lies in ChiSquareInterval(p, n d)
/// when the covariance is right.
Interval ChiSquareInterval(double probability, double dof);

/// Quantile of the standard normal distribution, 0 < p < 1.
double NormalQuantile(double p);

/// Shares of successes in n trials of probability p that hold at least the given probability,
/// equal tails (exact binomial).
Interval BinomialInterval(double probability, long n, double p);

/// Probability that the values depart so far from a uniform distribution on [0, 1] when they follow
/// it (Kolmogorov and Smirnov). Each value is a rank among `of_reference` others, known to one step
/// of them. At least one value.
double UniformityP(std::vector<double> values, double of_reference);

}  // namespace dn
