#pragma once

#include <dn/effects/effect_table.h>
#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <map>

namespace dn {

/// Class of an inertial navigation system.
enum class SensorClass {
  kNavigation,  ///< ring laser and fibre-optic gyros of survey aircraft
  kTactical,
  kMems,
};

/// Returns the class by the white noise of the gyros at rest, as a data sheet states it. Navigation
/// grade has up to 0.006 deg/sqrt(h), tactical grade up to 0.1.
SensorClass ClassByDataSheet(double white_rad_per_sqrt_s);
/// Returns the class by the white noise in flight, which platforms increase: navigation up to
/// 0.02 deg/sqrt(h), tactical up to 0.15.
SensorClass ClassInFlight(double white_rad_per_sqrt_s);

/// Prior of the fixed effects that a model leaves out: independent Gaussians of mean zero. An
/// adjustment has them as unknowns. They are estimated as far as the data show them, and stay in
/// the covariance as far as the data do not.
class UnmodelledPrior {
 public:
  /// Makes the prior of the pure model: no effect is left out.
  UnmodelledPrior() = default;
  /// Makes the prior of a class, with the sizes that docs/reference/effects.md lists.
  explicit UnmodelledPrior(SensorClass of);

  /// Sets the standard deviations of the components of an effect, SI; 0 rules a component out.
  /// Throws InvalidInput unless the effect is fixed, and has that many components, each with a
  /// sigma that is finite and not negative.
  void Set(EffectId effect, const Eigen::VectorXd& sigma_si);

  /// Returns the standard deviations of the components, SI; zeros without a prior.
  Eigen::VectorXd Sigma(EffectId effect) const;

  /// Returns true if every effect is ruled out.
  bool pure() const;

 private:
  std::map<EffectId, Eigen::VectorXd> sigma_si_;
};

}  // namespace dn
