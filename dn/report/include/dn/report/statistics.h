#pragma once

#include <dn/report/json.h>

#include <string>
#include <vector>

namespace dn {

/// What a normalised series (expected mean 0, variance 1, white) looks like.
struct SeriesStatistics {
  std::string sensor;
  std::string axis;
  long count = 0;
  double mean = 0.0;
  double variance = 0.0;
  double lag1_correlation = 0.0;
  double mean_square = 0.0;  ///< NIS per axis: 1 when the model fits
  double worst = 0.0;        ///< largest absolute value, and when
  double worst_t_s = 0.0;
};

/// Statistics of values in time order; lag-1 correlation is about the mean. Empty series give
/// zeros.
SeriesStatistics DescribeSeries(const std::string& sensor, const std::string& axis,
                                const std::vector<double>& t_s, const std::vector<double>& values);

/// {"sensor": {"axis": {"count", "mean", "variance", "lag1_correlation", "nis", "worst",
/// "worst_t_s"}}}
Json StatisticsToJson(const std::vector<SeriesStatistics>& statistics);

}  // namespace dn
