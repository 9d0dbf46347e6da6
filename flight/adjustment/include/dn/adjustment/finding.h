#pragma once

#include <dn/calibration/checks.h>
#include <dn/calibration/clocks.h>
#include <dn/navigation/gnss_correlation.h>

#include <Eigen/Core>
#include <string>
#include <variant>

namespace dn {

/// The trust a boresight deserves. gauss_helmert_flight.h and docs/method/model-check.md define
/// each verdict.
enum class Verdict {
  kCalibrated,     ///< the angles are the mounting's, within their covariance
  kAbsorbed,       ///< they hold an error of the trajectory: consistent, but not the mounting's
  kNotObservable,  ///< the data do not determine them
  kContradicted,   ///< the data contradict the assumed model; wins over the others
};

/// What may be found, one type each with the numbers that tell it. dn/calibration/words.h says them.
namespace facts {

/// An unmodelled effect is significant.
struct EffectPresent {
  EffectCheck effect;
  bool moves_boresight = false;  ///< else the trajectory
};

/// The data depart from the model in a way that no effect explains.
struct DepartureUnnamed {
  DepartureCheck departure;
};

/// What an unknown is estimated for has another cause as likely.
struct UnknownAmbiguous {
  RivalCheck check;
  bool moves_boresight = false;  ///< else the trajectory
};

/// Residuals of a group are larger than their stated noise.
struct VarianceTooLarge {
  GroupCheck group;
};

/// Residuals share errors that are taken as independent.
struct ErrorsShared {
  CommonErrorCheck common;
};

/// A stated prior contradicts all other data.
struct PriorContradicted {
  PriorCheck prior;
};

/// The flight states that a diagnosis found what its configuration does not model.
struct GapUnexplained {
  std::string what;
};

/// Boresight angles that no mounting has.
struct MountingImpossible {
  Eigen::Vector3d angles_rad;
};

/// The body flies on its back.
struct UpsideDown {};

struct Sigma0TooLarge {
  double sigma0 = 0.0;
};

struct PairsLeftOut {
  double share = 0.0;  ///< of all pairs
};

struct GnssLeftOut {
  double share = 0.0;  ///< of all epochs
};

/// The innovations of the GNSS positions ask for another lever arm of the antenna.
struct GnssLeverArmOff {
  Eigen::Vector3d correction_b_m;
};

/// The time tags of GNSS are off against those of the inertial data.
struct GnssTimeOff {
  ClockEstimate clock;
  double damage = 0.0;           ///< largest move of a watched unknown by it, in its sigmas
  bool moves_boresight = false;  ///< else the trajectory
};

/// Innovations of a sensor are larger or smaller than the model expects.
struct InnovationSize {
  std::string sensor;  ///< "GNSS positions", "GNSS velocities"
  double ratio = 1.0;  ///< their root mean square over the expected one
};

/// The GNSS positions have errors that last, and the network lacks them.
struct GnssErrorsLast {
  GnssCorrelation test;
};

/// The standard deviation of an angle exceeds 0.5 deg.
struct SigmaTooLarge {
  int angle = 0;  ///< 0 roll, 1 pitch, 2 yaw; so below
};

/// The standard deviation of an angle is far above what a single pair resolves.
struct SigmaAbovePairs {
  int angle = 0;
};

struct AnglesInseparable {
  int first = 0;
  int second = 0;
};

/// Nothing speaks against a network that has the trajectory's errors among its unknowns.
struct TrajectoryEstimated {};

/// What the attitude error of a trajectory makes of the difference of a pair, or of the distance of
/// a point from its plane.
struct AttitudeInPairs {
  enum class Size {
    kNoise,     ///< at the noise level of the pairs
    kHeld,      ///< above it, of tactical grade or better
    kAbsorbed,  ///< the angles hold it
  };
  Size size = Size::kNoise;
  bool of_planes = false;         ///< points on planes take the place of pairs below
  Eigen::Vector3d sigma_rph_rad;  ///< of roll, pitch and heading
  double change_m = 0.0;          ///< of the difference of a pair
  double range_m = 0.0;           ///< mean
  double pair_sigma_m = 0.0;      ///< of the pairs' own noise
};

/// Too few strips, or too much alike, for a reliable yaw.
struct StripsAlike {
  int strips = 0;
};

struct FewPairs {
  long pairs = 0;
};

/// Reliable sigmas that are much larger than those of the normal matrix.
struct SigmasWidened {
  Eigen::Vector3d ratio;
  Eigen::Vector3d scaled_rad;     ///< sigmas of the normal matrix, times sigma0
  Eigen::Vector3d scattered_rad;  ///< by errors of the trajectory that last for a while
  Eigen::Vector3d constant_rad;   ///< by those that last for the whole flight
  std::string source;             ///< what states the accuracy of the trajectory
  bool times_stated = false;      ///< it states how long the errors last, too
  bool times_shown = false;       ///< the pairs show it
  double tau_s = 0.0;             ///< for how long, by the pairs
};

/// An unknown under `estimate` that a method on a fixed trajectory does not have.
struct NotEstimated {
  std::string unknown;
  std::string because;  ///< what the method knows
};

/// The boresight of another method beside that of the dynamic network.
struct NetworkDiffers {
  Eigen::Vector3d difference_rad;
  double p_value = 1.0;
  bool contradicts = false;  ///< by more than their covariances explain
};

}  // namespace facts

using Fact = std::variant<
    facts::EffectPresent, facts::DepartureUnnamed, facts::UnknownAmbiguous, facts::VarianceTooLarge,
    facts::ErrorsShared, facts::PriorContradicted, facts::GapUnexplained, facts::MountingImpossible,
    facts::UpsideDown, facts::Sigma0TooLarge, facts::PairsLeftOut, facts::GnssLeftOut,
    facts::GnssLeverArmOff, facts::GnssTimeOff, facts::InnovationSize, facts::GnssErrorsLast,
    facts::SigmaTooLarge, facts::SigmaAbovePairs, facts::AnglesInseparable,
    facts::TrajectoryEstimated, facts::AttitudeInPairs, facts::StripsAlike, facts::FewPairs,
    facts::SigmasWidened, facts::NotEstimated, facts::NetworkDiffers>;

/// What speaks for or against the assumed model, or for the verdict.
struct Finding {
  Fact fact;
  bool contradicts = false;  ///< the results must not be relied on
  double evidence = 0.0;     ///< nats for it as the cause; infinite where there is no other

  /// The fact, where it is of this type; null elsewhere.
  template <class T>
  const T* As() const {
    return std::get_if<T>(&fact);
  }
};

}  // namespace dn
