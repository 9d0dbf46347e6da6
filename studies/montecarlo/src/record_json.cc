#include <dn/montecarlo/flight_record.h>
#include <dn/report/json_numbers.h>

namespace dn {
namespace {

Eigen::Matrix3d Matrix3FromJson(const Json& json) {
  Eigen::Matrix3d matrix;
  for (int i = 0; i < 3; ++i) matrix.row(i) = Vector3FromJson(json.at(static_cast<std::size_t>(i)));
  return matrix;
}

// A row contains t, then for each quantity its NEES and three components.
Json EpochToJson(const EpochErrors& epoch) {
  Json row = Json::array({epoch.t_s});
  for (std::size_t q = 0; q < kQuantities.size(); ++q) {
    row.push_back(epoch.nees[q]);
    for (int i = 0; i < 3; ++i) row.push_back(epoch.sigmas[q][i]);
  }
  return row;
}

EpochErrors EpochFromJson(const Json& row) {
  EpochErrors epoch;
  std::size_t k = 0;
  epoch.t_s = row.at(k++).get<double>();
  for (std::size_t q = 0; q < kQuantities.size(); ++q) {
    epoch.nees[q] = NumberFromJson(row.at(k++));
    for (int i = 0; i < 3; ++i) epoch.sigmas[q][i] = NumberFromJson(row.at(k++));
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

std::vector<SeriesStatistics> SeriesFromJson(const Json& rows) {
  std::vector<SeriesStatistics> series;
  for (const Json& row : rows) {
    SeriesStatistics s;
    s.sensor = row.at("sensor").get<std::string>();
    s.axis = row.at("axis").get<std::string>();
    s.count = row.at("count").get<long>();
    s.mean = row.at("mean").get<double>();
    s.variance = row.at("variance").get<double>();
    s.expected_variance = row.at("expected_variance").get<double>();
    s.lag1_correlation = row.at("lag1_correlation").get<double>();
    s.mean_square = row.at("mean_square").get<double>();
    s.worst = row.at("worst").get<double>();
    s.worst_t_s = row.at("worst_t_s").get<double>();
    series.push_back(s);
  }
  return series;
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
          {"contradicted", record.contradicted},
          {"check_p_value", record.check_p_value},
          {"position_rms_m", dn::ToJson(record.position_rms_m)},
          {"velocity_rms_mps", dn::ToJson(record.velocity_rms_mps)},
          {"attitude_rms_rad", dn::ToJson(record.attitude_rms_rad)},
          {"residuals", SeriesToJson(record.residuals)},
          {"innovations", SeriesToJson(record.innovations)},
          {"time_s", record.time_s},
          {"epochs", epochs}};
}

FlightRecord FlightRecordFromJson(const Json& json) {
  FlightRecord record;
  record.seed = json.at("seed").get<std::uint64_t>();
  record.with_pairs = json.at("with_pairs").get<bool>();
  record.failure = json.at("failure").get<std::string>();
  record.boresight_error_rad = Vector3FromJson(json.at("boresight_error_rad"));
  record.boresight_covariance_rad2 = Matrix3FromJson(json.at("boresight_covariance_rad2"));
  record.chi2 = json.at("chi2").get<double>();
  record.redundancy = json.at("redundancy").get<long>();
  record.outliers = json.at("outliers").get<long>();
  record.contradicted = json.at("contradicted").get<bool>();
  record.check_p_value = json.at("check_p_value").get<double>();
  record.position_rms_m = Vector3FromJson(json.at("position_rms_m"));
  record.velocity_rms_mps = Vector3FromJson(json.at("velocity_rms_mps"));
  record.attitude_rms_rad = Vector3FromJson(json.at("attitude_rms_rad"));
  record.residuals = SeriesFromJson(json.at("residuals"));
  record.innovations = SeriesFromJson(json.at("innovations"));
  record.time_s = json.at("time_s").get<double>();
  for (const Json& row : json.at("epochs")) record.epochs.push_back(EpochFromJson(row));
  return record;
}

}  // namespace dn
