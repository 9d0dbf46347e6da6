#pragma once

#include <dn/adjustment/gauss_helmert_flight.h>
#include <dn/adjustment/pair_residuals.h>
#include <dn/adjustment/plane_flight.h>
#include <dn/adjustment/result.h>
#include <dn/diagnosis/model_check.h>
#include <dn/report/json.h>

#include <string>
#include <utility>
#include <vector>

namespace dn {

/// Durations of the parts of a run in seconds, for result.json.
struct RunTimings {
  double read_s = 0.0;
  double solve_s = 0.0;
  double covariance_s = 0.0;
  double total_s = 0.0;
};

/// Returns result.json of `dn calibrate --method dn` (schema dn.result/1).
Json CalibrationJson(const std::string& flight, const Adjustment& adjustment,
                     const TrajectoryResult& trajectory, const ModelCheck& check,
                     const BoresightResult& boresight, const std::vector<UnknownEstimate>& unknowns,
                     const std::vector<PairResidual>& pairs, const RunTimings& timings);

/// Returns result.json of `dn calibrate --method gh`.
Json CalibrationJson(const std::string& flight, const GaussHelmertCalibration& calibration,
                     const ModelCheck& check, const std::vector<PairResidual>& pairs,
                     const RunTimings& timings);

/// Returns result.json of `dn calibrate --method planes`. Its section `planes` has the number of
/// planes, the spread of their normals, and the number that each pair of strips shares. `strips`
/// are the names of the strips.
Json CalibrationJson(const std::string& flight, const PlaneCalibration& calibration,
                     const ModelCheck& check, const std::vector<std::string>& strips,
                     const RunTimings& timings);

/// Returns the part of report.json that a Gauss-Helmert adjustment adds to result.json.
Json GaussHelmertReportJson(const GaussHelmertCalibration& calibration);

/// Returns comparison.json of `dn calibrate --method all`: angles and sigmas per method, and the
/// differences of the methods. For each two methods (a, b), it has the difference a - b, its sigma
/// and its significance in sigmas. The method planes is taken as independent of the others
/// (CompareIndependent). `absent` are the methods without a result and the reasons; they are null,
/// with a note.
Json ComparisonJson(const std::string& flight,
                    const std::vector<std::pair<std::string, const BoresightResult*>>& methods,
                    const std::vector<std::pair<std::string, std::string>>& absent);

/// Returns `estimates` of result.json: value, sigma and unit of each unknown by its name.
Json UnknownsJson(const std::vector<UnknownEstimate>& unknowns);

/// Returns the boresight of a design, without angles. It has sigmas, covariance and correlation,
/// the same of the pure model, and the contributions of the effects that this model leaves out.
Json PredictedBoresightJson(const BoresightResult& boresight);

/// Returns lines with the sigmas of the pure model, and with the effects outside of it. The effects
/// are those with the largest parts in the reported sigmas. Empty without such effects.
std::string ContributionsSummary(const BoresightResult& boresight);

/// Returns smooth.json of `dn smooth`, with the verdict `consistent` or `contradicted`.
Json SmoothJson(const std::string& flight, const TrajectoryResult& trajectory,
                const std::vector<TrajectorySigma>& sigma, const ModelCheck& check,
                const std::vector<UnknownEstimate>& unknowns, const RunTimings& timings);

/// Returns the correlation of the boresight with a bias as all result files contain it.
Json CorrelationJson(const BiasCorrelation& correlation);

/// Returns the figures of an adjustment as result.json and smooth.json contain them.
Json AdjustmentJson(const AdjustmentFigures& figures);

/// Returns the text of trajectory_sigma.txt: t, sigma E, N, U [m], v E, N, U [m/s], roll, pitch,
/// heading [deg].
std::string FormatTrajectorySigma(const std::vector<TrajectorySigma>& sigma);

/// Returns the text of biases.txt: t, gyro x y z [deg/h], accel x y z [mg], then their sigmas.
std::string FormatBiases(const std::vector<BiasEstimate>& biases);

/// Returns the root mean squares, over some poses, of the differences from the reference trajectory
/// of the flight. They are position E, N, U in m, velocity in m/s, and roll, pitch, heading in deg.
/// The velocity is null if the reference has no velocities of its own. Returns null if there is no
/// reference or if it covers none of the poses.
Json ReferenceErrorsJson(const Flight& flight, const std::vector<MapPose>& poses);

}  // namespace dn
