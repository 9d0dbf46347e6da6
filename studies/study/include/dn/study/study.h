#pragma once

#include <dn/adjustment/beams.h>
#include <dn/adjustment/bias_correlation.h>
#include <dn/adjustment/result.h>
#include <dn/diagnosis/solution.h>
#include <dn/study/design.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dn {

/// Properties of a strip that matter for what it determines.
struct StripGeometry {
  std::string name;
  double course_rad = 0.0;
  double speed_mps = 0.0;
  double height_m = 0.0;  ///< mean height above the ground that its pairs lie on
};

/// Properties that the strips of a design have in common.
struct FlightGeometry {
  std::vector<StripGeometry> strips;
  bool parallel = false;       ///< all courses within 15 deg of one line
  bool one_direction = false;  ///< no two strips have opposite courses
  bool one_height = false;     ///< heights above ground within 15 % of their mean
  bool one_speed = false;      ///< speeds within 10 % of their mean
};

/// A change of a scenario that may help an unknown. The first four add a strip and keep the number
/// of pairs.
enum class RemedyKind { kCrossStrip, kOppositeStrip, kOtherHeight, kOtherSpeed, kMorePairs };

/// The sigma of a direction with a remedy.
struct TriedRemedy {
  RemedyKind kind = RemedyKind::kCrossStrip;
  double sigma = 0.0;
};

/// Calibration unknowns and time-correlated errors that the design determines weakly or only
/// jointly.
struct StudyDirection {
  /// Name ("boresight_pitch", "accel_bias_y") and weight, largest first. The squares of all weights
  /// sum to 1; weights below 0.2 are left out.
  std::vector<std::pair<std::string, double>> unknowns;
  std::string leading;  ///< the calibration unknown with the largest weight
  std::string unit;     ///< unit of the sigmas
  double sigma = 0.0;   ///< sigma of the leading unknown
  /// Multiple correlation of the leading unknown with all others, 0 to 1.
  double correlation = 0.0;
  std::vector<TriedRemedy> tried;  ///< best first; empty for a design without a scenario
  /// Returns the first of `tried` if it reduces the sigma by at least 5 %.
  std::optional<TriedRemedy> remedy() const;
};

/// A free unknown other than the boresight.
struct StudyUnknown {
  std::string name;  ///< name in `estimate`
  std::string unit;
  std::vector<std::string> components;
  std::vector<double> sigma;
};

/// Reason why a design that is formally regular does not determine an unknown.
struct Unobservable {
  std::string unknown;
  std::string partner;  ///< unknown that it cannot be separated from; empty: sigma too large
  double value = 0.0;   ///< correlation with the partner, or the sigma
  std::string unit;     ///< unit of the sigma
};

/// Root mean square sigmas per axis over the nodes within the strips.
struct StripSigmas {
  double roll_pitch_rad = 0.0;
  double yaw_rad = 0.0;
  double position_m = 0.0;
};

/// Accuracies of a design. No measured values are used.
struct StudyResult {
  std::string name;
  DesignSource source = DesignSource::kScenario;
  FlightGeometry geometry;
  BoresightResult boresight;  ///< its angles are those of the design; no finding contradicts
  std::vector<StudyUnknown> unknowns;
  ScannerMountings mountings;              ///< of several scanners
  std::vector<BeamCorrections> beams;      ///< of scanners with several beams; the values are zero
  std::vector<Unobservable> unobservable;  ///< unknowns other than the boresight
  StripSigmas strips;
  std::vector<TrajectorySigma> trajectory;      ///< at the nodes
  std::vector<BiasCorrelationAt> correlations;  ///< at the nodes
  std::vector<StudyDirection> weak;
  long nodes = 0;
  long parameters = 0;
  long imu_epochs = 0;
  long gnss_epochs = 0;
  long pairs = 0;

  bool observable() const;
};

/// Options of a study.
struct StudyOptions {
  DesignOptions design;
  bool remedies = true;  ///< tries remedies for weak directions of a scenario
};

/// Returns the covariances of a scenario before it is flown. Throws RankDeficient, with the name of
/// the unknown, if the design leaves an unknown free; also throws as MakeDesign.
/// StudyResult::observable() is false for a design that is formally regular but does not determine
/// an unknown.
StudyResult Study(const Scenario& scenario, const StudyOptions& options = {});

/// Returns the covariances of a flight; no remedies are tried.
StudyResult Study(Flight flight, const StudyOptions& options = {});

/// Returns the network of a design, linearised at its states, with its covariances. The design must
/// outlive it. Throws RankDeficient if an unknown is free.
Solution SolveAtStates(const StudyDesign& design, int threads = 1);

/// Returns the study of a design at its states, without remedies.
StudyResult Study(const StudyDesign& design, const Solution& at_states);

}  // namespace dn
