#pragma once

#include <dn/calibration/bias_correlation.h>
#include <dn/calibration/result.h>
#include <dn/calibration/solution.h>
#include <dn/study/design.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dn {

/// How a strip was flown, as far as it matters for what it determines.
struct StripGeometry {
  std::string name;
  double course_rad = 0.0;
  double speed_mps = 0.0;
  double height_m = 0.0;  ///< mean height above the ground that its pairs lie on
};

/// What the strips of a design have in common.
struct FlightGeometry {
  std::vector<StripGeometry> strips;
  bool parallel = false;       ///< all courses within 15 deg of one line
  bool one_direction = false;  ///< no strip is flown against another
  bool one_height = false;     ///< heights above ground within 15 % of their mean
  bool one_speed = false;      ///< speeds within 10 % of their mean
};

/// A change of a scenario that may help an unknown. The first four add one strip, the number of
/// pairs stays.
enum class RemedyKind { kCrossStrip, kOppositeStrip, kOtherHeight, kOtherSpeed, kMorePairs };

/// What a remedy leaves of the sigma of a direction.
struct TriedRemedy {
  RemedyKind kind = RemedyKind::kCrossStrip;
  double sigma = 0.0;
};

/// Calibration unknowns and lasting errors that the design determines weakly, or only together.
struct StudyDirection {
  /// Name ("boresight_pitch", "accel_bias_y") and weight, the largest first; the squares of all
  /// weights sum to 1, those below 0.2 are left out.
  std::vector<std::pair<std::string, double>> unknowns;
  std::string leading;             ///< the calibration unknown with the largest weight
  std::string unit;                ///< of the sigmas
  double sigma = 0.0;              ///< of the leading unknown
  double correlation = 0.0;        ///< multiple one of the leading unknown with all others, 0 to 1
  std::vector<TriedRemedy> tried;  ///< the best first; none where the design is no scenario
  /// The first of `tried` where it takes at least 5 % off the sigma.
  std::optional<TriedRemedy> remedy() const;
};

/// A free unknown besides the boresight.
struct StudyUnknown {
  std::string name;  ///< of `estimate`
  std::string unit;
  std::vector<std::string> components;
  std::vector<double> sigma;
};

/// Why a design, though formally regular, does not determine an unknown.
struct Unobservable {
  std::string unknown;
  std::string partner;  ///< the unknown it cannot be told from; empty: its sigma is too large
  double value = 0.0;   ///< correlation with the partner, else the sigma
  std::string unit;     ///< of the sigma
};

/// Root mean squares over the nodes within the strips, per axis.
struct StripSigmas {
  double roll_pitch_rad = 0.0;
  double yaw_rad = 0.0;
  double position_m = 0.0;
};

/// What a design would determine. No measured value enters.
struct StudyResult {
  std::string name;
  DesignSource source = DesignSource::kScenario;
  FlightGeometry geometry;
  BoresightResult boresight;  ///< its angles are those of the design; no finding is contradicted
  std::vector<StudyUnknown> unknowns;
  std::vector<Unobservable> unobservable;  ///< of the unknowns besides the boresight
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
  bool remedies = true;  ///< tries what would help a weak direction, of a scenario
};

/// Covariances of a scenario before it is flown. Throws RankDeficient where the design leaves an
/// unknown free (naming it), and as DesignOf; a design that is formally regular and yet determines
/// an unknown no better than the eye has StudyResult::observable() false.
StudyResult Study(const Scenario& scenario, const StudyOptions& options = {});

/// The same for a flight; no remedy is tried.
StudyResult Study(Flight flight, const StudyOptions& options = {});

/// The network of a design, linearised at its states, with its covariances. The design must outlive
/// it. Throws RankDeficient where an unknown is free.
Solution AtStates(const StudyDesign& design, int threads = 1);

/// Of a design at its states: everything but remedies.
StudyResult Study(const StudyDesign& design, const Solution& at_states);

}  // namespace dn
