#include <dn/montecarlo/flight_record.h>

#include <Eigen/Cholesky>

namespace dn {
namespace {

// Limits far above the numbers of any flight.
constexpr std::int64_t kMostCount = 1'000'000'000'000;
constexpr std::int64_t kMostRedundancy = 1'000'000'000;
constexpr double kMostFigure = 1e18;
constexpr std::size_t kMaxCovarianceEpochs = 1'000'000;
constexpr std::size_t kMostSeries = 1000;

// A row contains t, then for each quantity its NEES and three components.
Json EpochToJson(const EpochErrors& epoch) {
  Json row = Json::array({epoch.t_s});
  for (std::size_t q = 0; q < kQuantities.size(); ++q) {
    row.push_back(epoch.nees[q]);
    for (int i = 0; i < 3; ++i) row.push_back(epoch.sigmas[q][i]);
  }
  return row;
}

EpochErrors EpochFromJson(const JsonPlace& row) {
  EpochErrors epoch;
  std::size_t k = 0;
  epoch.t_s = row.At(k++).Number();
  for (std::size_t q = 0; q < kQuantities.size(); ++q) {
    epoch.nees[q] = ReadNumberOrNaN(row.At(k++));
    for (int i = 0; i < 3; ++i) epoch.sigmas[q][i] = ReadNumberOrNaN(row.At(k++));
  }
  return epoch;
}

// Writes only the statistics that a summary over many flights needs.
Json SeriesToJson(const std::vector<SeriesStatistics>& series) {
  Json rows = Json::array();
  for (const SeriesStatistics& s : series) {
    rows.push_back({{"sensor", s.sensor},
                    {"axis", s.axis},
                    {"count", s.count},
                    {"mean", s.mean},
                    {"variance", s.variance},
                    {"expected_variance", s.expected_variance},
                    {"lag1_correlation", s.lag1_correlation},
                    {"mean_square", s.mean_square},
                    {"worst", s.worst},
                    {"worst_t_s", s.worst_t_s}});
  }
  return rows;
}

double Figure(const JsonPlace& place) { return place.Number(-kMostFigure, kMostFigure); }

std::vector<SeriesStatistics> SeriesFromJson(const JsonPlace& rows) {
  std::vector<SeriesStatistics> series;
  for (const JsonPlace& row : rows.Elements(kMostSeries)) {
    SeriesStatistics s;
    s.sensor = row.At("sensor").Text();
    s.axis = row.At("axis").Text();
    s.count = row.At("count").Integer(0, kMostCount);
    s.mean = Figure(row.At("mean"));
    s.variance = Figure(row.At("variance"));
    s.expected_variance = row.At("expected_variance").Number(0.0, kMostFigure);
    s.lag1_correlation = Figure(row.At("lag1_correlation"));
    s.mean_square = row.At("mean_square").Number(0.0, kMostFigure);
    s.worst = Figure(row.At("worst"));
    s.worst_t_s = Figure(row.At("worst_t_s"));
    series.push_back(s);
  }
  return series;
}

// A summary divides by the redundancy and solves with the covariance of every adjusted flight.
void ExpectAdjusted(const FlightRecord& record, const JsonPlace& json) {
  if (!record.failure.empty()) return;
  if (record.redundancy < 1) json.At("redundancy").Fail("is 0 in a flight that was adjusted");
  if (!record.with_pairs) return;
  const Eigen::Matrix3d& covariance = record.boresight_covariance_rad2;
  if (covariance.allFinite() && covariance.llt().info() == Eigen::Success) return;
  json.At("boresight_covariance_rad2").Fail("is not positive definite");
}

}  // namespace

Json ToJson(const FlightRecord& record) {
  Json epochs = Json::array();
  for (const EpochErrors& epoch : record.epochs) epochs.push_back(EpochToJson(epoch));
  return {{"seed", record.seed},
          {"with_pairs", record.with_pairs},
          {"failure", record.failure},
          {"boresight_error_rad", dn::ToJson(record.boresight_error_rad)},
          {"boresight_covariance_rad2", ToJsonMatrix(record.boresight_covariance_rad2)},
          {"chi2", record.chi2},
          {"redundancy", record.redundancy},
          {"outliers", record.outliers},
          {"contradiction", record.contradiction},
          {"check_p_value", record.check_p_value},
          {"position_rms_m", dn::ToJson(record.position_rms_m)},
          {"velocity_rms_mps", dn::ToJson(record.velocity_rms_mps)},
          {"attitude_rms_rad", dn::ToJson(record.attitude_rms_rad)},
          {"residuals", SeriesToJson(record.residuals)},
          {"innovations", SeriesToJson(record.innovations)},
          {"time_s", record.time_s},
          {"epochs", epochs}};
}

FlightRecord FlightRecordFromJson(const JsonPlace& json) {
  FlightRecord record;
  record.seed = json.At("seed").Unsigned();
  record.with_pairs = json.At("with_pairs").Flag();
  record.failure = json.At("failure").Text();
  record.boresight_error_rad = ReadFiniteVector3(json.At("boresight_error_rad"));
  record.boresight_covariance_rad2 = ReadMatrix3(json.At("boresight_covariance_rad2"));
  record.chi2 = json.At("chi2").Number(0.0, kMostFigure);
  record.redundancy = json.At("redundancy").Integer(0, kMostRedundancy);
  record.outliers = json.At("outliers").Integer(0, kMostRedundancy);
  record.contradiction = json.At("contradiction").Text();
  record.check_p_value = json.At("check_p_value").Number(0.0, 1.0);
  record.position_rms_m = ReadFiniteVector3(json.At("position_rms_m"));
  record.velocity_rms_mps = ReadFiniteVector3(json.At("velocity_rms_mps"));
  record.attitude_rms_rad = ReadFiniteVector3(json.At("attitude_rms_rad"));
  record.residuals = SeriesFromJson(json.At("residuals"));
  record.innovations = SeriesFromJson(json.At("innovations"));
  record.time_s = json.At("time_s").Number(0.0, kMostFigure);
  for (const JsonPlace& row : json.At("epochs").Elements(kMaxCovarianceEpochs)) {
    record.epochs.push_back(EpochFromJson(row));
  }
  ExpectAdjusted(record, json);
  return record;
}

}  // namespace dn
