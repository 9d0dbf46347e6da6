#include "noise_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace dn::diagnosis_internal {
namespace {

using Eigen::Vector3d;
using Residuals = std::vector<Vector3d>;

constexpr int kIterations = 60;
constexpr double kDofs[] = {2.2, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 8.0, 10.0, 14.0, 20.0, 30.0};

/// Normal noise of the size `scale`, with a fraction of outliers.
struct Contaminated {
  double share = 0.02, scale = 1.0, longest = 1.0;

  double LogNormal(const Vector3d& r) const {
    return -0.5 * r.squaredNorm() / (scale * scale) -
           3.0 * std::log(scale * std::sqrt(2.0 * std::numbers::pi));
  }
  /// Lengths below the noise are as good as those of the noise.
  double LogOutlier(const Vector3d& r) const {
    const double squared = std::max(r.squaredNorm(), scale * scale);
    return -std::log(4.0 * std::numbers::pi * longest * squared);
  }
};

/// Returns the log likelihood with the likeliest share and scale.
double FitContaminated(const Residuals& residuals) {
  Contaminated model;
  for (const Vector3d& r : residuals) model.longest = std::max(model.longest, r.norm());
  double log_likelihood = 0.0;
  for (int k = 0; k < kIterations; ++k) {
    double outliers = 0.0, squares = 0.0;
    log_likelihood = 0.0;
    for (const Vector3d& r : residuals) {
      const double normal = (1.0 - model.share) * std::exp(model.LogNormal(r));
      const double outlier = model.share * std::exp(model.LogOutlier(r));
      const double is_outlier = outlier / (normal + outlier);
      outliers += is_outlier;
      squares += (1.0 - is_outlier) * r.squaredNorm();
      log_likelihood += std::log(normal + outlier);
    }
    const auto n = static_cast<double>(residuals.size());
    model.share = outliers / n;
    model.scale = std::sqrt(squares / (3.0 * std::max(n - outliers, 1.0)));
  }
  return log_likelihood;
}

/// Student's t of vectors with `dimension` components that have one common tail.
class Student {
 public:
  Student(double dof, double dimension) : dof_(dof), dimension_(dimension) {}

  /// Returns the log likelihood of vectors with these squared norms, at the likeliest scale.
  double Fit(const std::vector<double>& squared_norms, double* scale) const {
    const auto n = static_cast<double>(squared_norms.size());
    double variance = 1.0;
    for (int k = 0; k < kIterations; ++k) {
      double sum = 0.0;
      for (const double r2 : squared_norms) {
        sum += (dof_ + dimension_) / (dof_ + r2 / variance) * r2;
      }
      variance = std::max(sum / (n * dimension_), std::numeric_limits<double>::min());
    }
    *scale = std::sqrt(variance);
    double log_likelihood = 0.0;
    for (const double r2 : squared_norms) {
      log_likelihood -= 0.5 * (dof_ + dimension_) * std::log1p(r2 / (dof_ * variance));
    }
    return log_likelihood + n * (std::lgamma(0.5 * (dof_ + dimension_)) - std::lgamma(0.5 * dof_) -
                                 0.5 * dimension_ * std::log(dof_ * std::numbers::pi * variance));
  }

 private:
  double dof_, dimension_;
};

}  // namespace

NoiseShape CompareNoiseShapes(const Residuals& residuals) {
  std::vector<double> of_components, of_vectors;
  for (const Vector3d& r : residuals) {
    of_vectors.push_back(r.squaredNorm());
    for (const double component : r) of_components.push_back(component * component);
  }
  NoiseShape shape;
  double best = -std::numeric_limits<double>::infinity();
  for (const double dof : kDofs) {
    const auto keep_best = [&](double dimension, const std::vector<double>& squared_norms) {
      double scale = 1.0;
      const double log_likelihood = Student(dof, dimension).Fit(squared_norms, &scale);
      if (log_likelihood <= best) return;
      best = log_likelihood;
      shape.dof = dof;
      shape.scale = scale;
    };
    keep_best(1.0, of_components);
    keep_best(3.0, of_vectors);
  }
  // Share, scale and longest against scale and degrees of freedom.
  const double more_parameters = 0.5 * std::log(static_cast<double>(of_components.size()));
  shape.outlier_lead_nats = FitContaminated(residuals) - best - more_parameters;
  return shape;
}

}  // namespace dn::diagnosis_internal
