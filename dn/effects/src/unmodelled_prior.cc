#include <dn/effects/unmodelled_prior.h>
#include <dn/error.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <string>

namespace dn {
namespace {

/// Returns the class for the largest white noise of two classes, deg/sqrt(h).
SensorClass ClassUpTo(double navigation, double tactical, double white_rad_per_sqrt_s) {
  constexpr double kDegPerSqrtHour = 60.0 * 180.0 / std::numbers::pi;
  const double white = white_rad_per_sqrt_s * kDegPerSqrtHour;
  if (white <= navigation) return SensorClass::kNavigation;
  return white <= tactical ? SensorClass::kTactical : SensorClass::kMems;
}

/// One sigma of each component, in the unit of the table, for the classes in their order.
struct ClassSizes {
  EffectId effect;
  std::array<double, 3> sigma;
};

// Inertial sizes are what data sheets of the class state after calibration: scale factor, axis
// misalignment and g-sensitivity. Lever arms are a survey with a total station; clocks are those of
// PPS-triggered receivers with an unknown delay in the cable and firmware. Gravity is the rms of
// the deflection of the vertical and of the anomaly that no model is applied for. The lidar's sizes
// are the accuracy of ranges and angles that scanner makers state.
constexpr std::array kSizes{
    ClassSizes{EffectId::kGnssLeverArm, {0.01, 0.01, 0.01}},
    ClassSizes{EffectId::kGnssTimeOffset, {1e-4, 1e-4, 1e-4}},
    ClassSizes{EffectId::kGnssTimeDrift, {0.05, 0.05, 0.1}},
    ClassSizes{EffectId::kGyroScaleFactor, {10.0, 100.0, 200.0}},
    ClassSizes{EffectId::kAccelScaleFactor, {30.0, 100.0, 200.0}},
    ClassSizes{EffectId::kGyroMisalignment, {0.03, 0.1, 0.2}},
    ClassSizes{EffectId::kAccelMisalignment, {0.03, 0.1, 0.2}},
    ClassSizes{EffectId::kGyroGSensitivity, {0.002, 0.05, 1.5}},
    ClassSizes{EffectId::kGravityTilt, {6.0, 6.0, 6.0}},
    ClassSizes{EffectId::kGravityDisturbance, {20.0, 20.0, 20.0}},
    ClassSizes{EffectId::kLidarLeverArm, {0.01, 0.01, 0.01}},
    ClassSizes{EffectId::kLidarTimeOffset, {2e-4, 2e-4, 2e-4}},
    ClassSizes{EffectId::kLidarTimeDrift, {0.05, 0.05, 0.1}},
    ClassSizes{EffectId::kLidarRangeOffset, {0.01, 0.01, 0.02}},
    ClassSizes{EffectId::kLidarRangeScale, {30.0, 30.0, 50.0}},
    ClassSizes{EffectId::kLidarAngleScale, {100.0, 100.0, 200.0}},
    ClassSizes{EffectId::kLidarScanCone, {0.01, 0.01, 0.02}},
    ClassSizes{EffectId::kLidarScanTorsion, {0.002, 0.002, 0.005}},
    ClassSizes{EffectId::kBoresightDrift, {0.002, 0.002, 0.005}},
};

}  // namespace

SensorClass ClassByDataSheet(double white_rad_per_sqrt_s) {
  return ClassUpTo(0.006, 0.1, white_rad_per_sqrt_s);
}

SensorClass ClassInFlight(double white_rad_per_sqrt_s) {
  return ClassUpTo(0.02, 0.15, white_rad_per_sqrt_s);
}

UnmodelledPrior::UnmodelledPrior(SensorClass of) {
  for (const ClassSizes& sizes : kSizes) {
    const std::vector<EffectComponent>& components = EffectRow(sizes.effect).components;
    const double sigma = sizes.sigma[static_cast<std::size_t>(of)] * components.front().to_si;
    Set(sizes.effect,
        Eigen::VectorXd::Constant(static_cast<Eigen::Index>(components.size()), sigma));
  }
}

void UnmodelledPrior::Set(EffectId effect, const Eigen::VectorXd& sigma_si) {
  const EffectSpec& spec = EffectRow(effect);
  const auto fail = [&](const std::string& why) {
    throw InvalidInput("unmodelled: '" + spec.name + "' " + why);
  };
  if (!spec.fixed()) fail("is not a fixed effect");
  if (sigma_si.size() != static_cast<Eigen::Index>(spec.components.size())) {
    fail("has " + std::to_string(spec.components.size()) + " components, but " +
         std::to_string(sigma_si.size()) + " sigmas are given");
  }
  if (!sigma_si.allFinite() || (sigma_si.array() < 0.0).any()) {
    fail("has a sigma that is negative or not finite");
  }
  sigma_si_[effect] = sigma_si;
}

Eigen::VectorXd UnmodelledPrior::Sigma(EffectId effect) const {
  const auto at = sigma_si_.find(effect);
  if (at != sigma_si_.end()) return at->second;
  return Eigen::VectorXd::Zero(static_cast<Eigen::Index>(EffectRow(effect).components.size()));
}

bool UnmodelledPrior::pure() const {
  return std::all_of(sigma_si_.begin(), sigma_si_.end(),
                     [](const auto& effect) { return effect.second.isZero(0.0); });
}

}  // namespace dn
