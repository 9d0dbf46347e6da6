#include <dn/report/statistics.h>

#include <cmath>

namespace dn {

SeriesStatistics DescribeSeries(const std::string& sensor, const std::string& axis,
                                const std::vector<double>& t_s, const std::vector<double>& values) {
  SeriesStatistics s;
  s.sensor = sensor;
  s.axis = axis;
  s.count = static_cast<long>(values.size());
  if (values.empty()) return s;
  const auto n = static_cast<double>(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    s.mean += values[i] / n;
    s.mean_square += values[i] * values[i] / n;
    if (std::abs(values[i]) > std::abs(s.worst)) {
      s.worst = values[i];
      s.worst_t_s = t_s[i];
    }
  }
  double lagged = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    s.variance += (values[i] - s.mean) * (values[i] - s.mean) / n;
    if (i > 0) lagged += (values[i] - s.mean) * (values[i - 1] - s.mean) / n;
  }
  if (s.variance > 0.0) s.lag1_correlation = lagged / s.variance;
  return s;
}

Json StatisticsToJson(const std::vector<SeriesStatistics>& statistics) {
  Json json = Json::object();
  for (const SeriesStatistics& s : statistics) {
    json[s.sensor][s.axis] = {{"count", s.count},        {"mean", s.mean},
                              {"variance", s.variance},  {"lag1_correlation", s.lag1_correlation},
                              {"nis", s.mean_square},    {"worst", s.worst},
                              {"worst_t_s", s.worst_t_s}};
  }
  return json;
}

}  // namespace dn
