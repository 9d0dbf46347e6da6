#pragma once

#include <dn/adjustment/checks.h>
#include <dn/adjustment/clocks.h>
#include <dn/adjustment/control_checks.h>
#include <dn/navigation/gnss_correlation.h>

#include <Eigen/Core>
#include <string>
#include <variant>

namespace dn {

/// Verdict on a boresight. gauss_helmert_flight.h and docs/method/model-check.md define the
/// conditions of each value.
enum class Verdict {
  kCalibrated,  ///< the angles are those of the mounting, within their covariance
  /// The angles absorb an error of the trajectory or of the georeferencing of the strips. They make
  /// the strips consistent, but are not those of the mounting.
  kAbsorbed,
  kNotObservable,  ///< the data do not determine the angles
  kContradicted,   ///< the data contradict the assumed model; overrides the others
};

/// The kinds of findings, each a type with the numbers that describe it. dn/adjustment/words.h
/// formats them as sentences.
namespace facts {

/// An effect that is not modelled is significant.
struct EffectPresent {
  EffectCheck effect;
  bool moves_boresight = false;  ///< otherwise the trajectory
};

/// The data contain an unmodelled discrepancy, which no effect explains.
struct UnmodelledDiscrepancy {
  DiscrepancyCheck discrepancy;
};

/// Another effect explains the data as well as an estimated unknown.
struct UnknownAmbiguous {
  CompetingEffectCheck check;
  bool moves_boresight = false;  ///< otherwise the trajectory
};

/// The residuals of a group are larger than their stated noise.
struct VarianceTooLarge {
  GroupCheck group;
};

/// Residuals have common errors, but the model assumes that they are independent.
struct ErrorsShared {
  CommonErrorCheck common;
};

/// A stated prior contradicts all other data.
struct PriorContradicted {
  PriorCheck prior;
};

/// Laser vectors were computed with an assumed boresight: neither the strips nor flight.yaml state
/// the one with which the points were georeferenced.
struct VectorsAssumed {
  Eigen::Vector3d boresight_rad;
  std::string files;  ///< pair files with these vectors; empty for strips
};

/// flight.yaml states that a diagnosis found a discrepancy that its configuration does not model.
struct GapUnexplained {
  std::string what;
};

/// The boresight angles are too large for any mounting.
struct MountingImpossible {
  Eigen::Vector3d angles_rad;
};

/// The body is upside down.
struct UpsideDown {};

struct Sigma0TooLarge {
  double sigma0 = 0.0;
};

struct PairsLeftOut {
  double share = 0.0;  ///< share of all pairs
};

struct GnssLeftOut {
  double share = 0.0;  ///< share of all epochs
};

/// A run of GNSS positions was left out, but its shape is not that of an error of GNSS.
struct GnssRunDoubtful {
  GnssRunCheck run;
  bool moves_boresight = false;  ///< otherwise the trajectory
};

/// The innovations of the GNSS positions indicate another lever arm of the antenna.
struct GnssLeverArmOff {
  Eigen::Vector3d correction_b_m;
};

/// The GNSS time tags disagree with those of the inertial data.
struct GnssTimeOff {
  ClockEstimate clock;
  /// Largest shift of a watched unknown by the clock error, in its sigmas.
  double max_shift_sigmas = 0.0;
  bool moves_boresight = false;  ///< otherwise the trajectory
};

/// The innovations of a sensor are larger or smaller than the model predicts.
struct InnovationSize {
  std::string sensor;  ///< "GNSS positions", "GNSS velocities"
  double ratio = 1.0;  ///< root mean square over the expected one
};

/// The GNSS positions have time-correlated errors that the network does not model.
struct GnssErrorsCorrelated {
  GnssCorrelation test;
};

/// The standard deviation of an angle exceeds 0.5 deg.
struct SigmaTooLarge {
  int angle = 0;  ///< 0 roll, 1 pitch, 2 yaw, here and below
};

/// The standard deviation of an angle exceeds ten times the resolution of a single pair.
struct SigmaAbovePairs {
  int angle = 0;
};

struct AnglesInseparable {
  int first = 0;
  int second = 0;
};

/// No test speaks against a network that estimates the trajectory's errors.
struct TrajectoryEstimated {};

/// Change of a pair's difference, or of a point's distance from its plane, by the attitude error of
/// the trajectory.
struct AttitudeInPairs {
  enum class Size {
    kNoise,     ///< at the noise level of the pairs
    kCovered,   ///< above it; the trajectory is of tactical grade or better
    kAbsorbed,  ///< above it; the boresight angles absorb the error
  };
  Size size = Size::kNoise;
  bool of_planes = false;         ///< true: points on planes instead of pairs
  Eigen::Vector3d sigma_rph_rad;  ///< sigma of roll, pitch and heading
  double change_m = 0.0;          ///< sigma of that change
  double range_m = 0.0;           ///< mean range
  double pair_sigma_m = 0.0;      ///< sigma of the pairs' own noise
};

/// The strips are too few or too similar for a reliable yaw.
struct StripsAlike {
  int strips = 0;
};

struct FewPairs {
  long pairs = 0;
};

/// The reliable sigmas are much larger than those of the normal matrix.
struct SigmasWidened {
  Eigen::Vector3d ratio;
  Eigen::Vector3d scaled_rad;      ///< sigmas of the normal matrix, times sigma0
  Eigen::Vector3d correlated_rad;  ///< by time-correlated errors of the trajectory
  Eigen::Vector3d constant_rad;    ///< by errors that are constant over the flight
  std::string source;              ///< file or section that states the accuracy of the trajectory
  bool tau_stated = false;         ///< true: it also states the correlation time
  bool tau_shown = false;          ///< true: the pairs indicate the correlation time
  double tau_s = 0.0;              ///< correlation time that the pairs indicate
};

/// An unknown under `estimate` that a method on a fixed trajectory does not model.
struct NotEstimated {
  std::string unknown;
  std::string because;  ///< the unknowns that the method models
};

/// Comparison of the boresight with that of the dynamic network.
struct NetworkDiffers {
  Eigen::Vector3d difference_rad;
  double p_value = 1.0;
  bool contradicts = false;  ///< the difference is larger than the covariances explain
};

/// A control point contradicts all other data.
struct ControlPointWrong {
  ControlPointCheck point;
};

/// The control as a whole is shifted against the GNSS positions.
struct ControlShifted {
  ControlShift shift;
};

/// Many control points contradict the flight.
struct ControlLeftOut {
  long left_out = 0;
  long points = 0;  ///< observations, with those left out
};

}  // namespace facts

using Fact =
    std::variant<facts::EffectPresent, facts::UnmodelledDiscrepancy, facts::UnknownAmbiguous,
                 facts::VarianceTooLarge, facts::ErrorsShared, facts::PriorContradicted,
                 facts::VectorsAssumed, facts::GapUnexplained, facts::MountingImpossible,
                 facts::UpsideDown, facts::Sigma0TooLarge, facts::PairsLeftOut, facts::GnssLeftOut,
                 facts::GnssRunDoubtful, facts::GnssLeverArmOff, facts::GnssTimeOff,
                 facts::InnovationSize, facts::GnssErrorsCorrelated, facts::SigmaTooLarge,
                 facts::SigmaAbovePairs, facts::AnglesInseparable, facts::TrajectoryEstimated,
                 facts::AttitudeInPairs, facts::StripsAlike, facts::FewPairs, facts::SigmasWidened,
                 facts::NotEstimated, facts::NetworkDiffers, facts::ControlPointWrong,
                 facts::ControlShifted, facts::ControlLeftOut>;

/// A fact for or against the assumed model, or a reason of the verdict.
struct Finding {
  Fact fact;
  bool contradicts = false;  ///< true: do not rely on the results
  /// Nats, for this fact as the cause; infinite if there is no other cause.
  double evidence = 0.0;

  /// Returns the fact if it is of type T, otherwise null.
  template <class T>
  const T* As() const {
    return std::get_if<T>(&fact);
  }
};

}  // namespace dn
