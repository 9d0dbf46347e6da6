#pragma once

#include <dn/calibration/gauss_helmert_flight.h>
#include <dn/calibration/model_check.h>
#include <dn/calibration/pair_residuals.h>
#include <dn/calibration/plane_flight.h>
#include <dn/calibration/result.h>
#include <dn/report/json.h>

#include <string>
#include <utility>
#include <vector>

namespace dn {

/// Seconds of the parts of a run, as result.json reports them.
struct RunTimings {
  double read_s = 0.0;
  double solve_s = 0.0;
  double covariance_s = 0.0;
  double total_s = 0.0;
};

/// result.json of `dn calibrate --method dn` (schema dn.result/1).
Json CalibrationJson(const std::string& flight, const Adjustment& adjustment,
                     const TrajectoryResult& trajectory, const ModelCheck& check,
                     const BoresightResult& boresight, const std::vector<UnknownEstimate>& unknowns,
                     const std::vector<PairResidual>& pairs, const RunTimings& timings);

/// result.json of `dn calibrate --method gh`.
Json CalibrationJson(const std::string& flight, const GaussHelmertCalibration& calibration,
                     const std::vector<PairResidual>& pairs, const RunTimings& timings);

/// result.json of `dn calibrate --method planes`, with a section `planes`: how many there are, how
/// their normals spread, and how many each two strips share. strips: their names.
Json CalibrationJson(const std::string& flight, const PlaneCalibration& calibration,
                     const std::vector<std::string>& strips, const RunTimings& timings);

/// What report.json holds of a Gauss-Helmert adjustment beyond result.json.
Json GaussHelmertReportJson(const GaussHelmertCalibration& calibration);

/// comparison.json of `dn calibrate --method all`: angles and sigmas per method, and for each two
/// of them (a, b) the difference a - b, its sigma and significance (in sigmas); of planes it is taken as
/// independent of the others (CompareIndependent). absent: methods without a result, and why; null,
/// with a note that says so.
Json ComparisonJson(const std::string& flight,
                    const std::vector<std::pair<std::string, const BoresightResult*>>& methods,
                    const std::vector<std::pair<std::string, std::string>>& absent);

/// smooth.json of `dn smooth`, with the verdict `consistent` or `contradicted`.
Json SmoothJson(const std::string& flight, const TrajectoryResult& trajectory,
                const ModelCheck& check, const std::vector<UnknownEstimate>& unknowns,
                const RunTimings& timings);

/// Of the boresight with a bias, as all result files hold it.
Json CorrelationJson(const BiasCorrelation& correlation);

/// The adjustment's figures as result.json and smooth.json hold them.
Json AdjustmentJson(const AdjustmentFigures& figures);

/// trajectory_sigma.txt: t, sigma E, N, U [m], v E, N, U [m/s], roll, pitch, heading [deg].
std::string FormatTrajectorySigma(const std::vector<TrajectorySigma>& sigma);

/// biases.txt: t, gyro x y z [deg/h], accel x y z [mg], then their sigmas.
std::string FormatBiases(const std::vector<BiasEstimate>& biases);

/// Differences from the reference trajectory at the nodes, root mean squares: position E, N, U in
/// m, velocity in m/s (null where the reference has none of its own), roll, pitch, heading in deg.
/// Null altogether where there is no reference, or it covers no
/// node.
Json ReferenceErrorsJson(const FlightNetwork& network);

}  // namespace dn
