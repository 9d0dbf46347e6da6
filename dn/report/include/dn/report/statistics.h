#pragma once

#include <dn/report/json_fwd.h>

#include <string>
#include <utility>
#include <vector>

namespace dn {

/// An epoch of a series with an unusually large value.
struct SeriesEpoch {
  double t_s = 0.0;
  double value = 0.0;
  double standardised = 0.0;  ///< value / its expected standard deviation
};

/// Statistics of a normalised series (expected mean 0, white).
struct SeriesStatistics {
  std::string sensor;
  std::string axis;
  long count = 0;
  double mean = 0.0;
  double variance = 0.0;
  double expected_variance = 1.0;  ///< mean over the series
  double lag1_correlation = 0.0;
  double mean_square = 0.0;  ///< NIS per axis: equals the expected variance if the model fits
  /// Correlation about the mean at lags of 1, 2, 5, 10, 20 and 50 values, up to a quarter of the
  /// length of the series. For a white series, each has a standard deviation of 1/sqrt(count).
  std::vector<std::pair<int, double>> autocorrelation;
  /// Standardised value of the first of worst_epochs, as in the model check.
  double worst = 0.0;
  double worst_t_s = 0.0;
  std::vector<SeriesEpoch> worst_epochs;  ///< at most five, the largest standardised value first
};

/// Returns the statistics of values in time order. `expected_variances` has one variance per value
/// (the redundancy numbers of whitened residuals); if empty, all are 1 (innovations). An empty
/// series gives zeros. Throws InvalidInput if the lengths differ.
SeriesStatistics DescribeSeries(const std::string& sensor, const std::string& axis,
                                const std::vector<double>& t_s, const std::vector<double>& values,
                                const std::vector<double>& expected_variances = {});

/// Returns {"sensor": {"axis": {"count", "mean", "variance", "expected_variance",
/// "lag1_correlation", "autocorrelation": {"<lag>": value}, "nis", "worst", "worst_t_s",
/// "worst_epochs": [{"t_s", "value", "standardised"}]}}}.
Json StatisticsToJson(const std::vector<SeriesStatistics>& statistics);

}  // namespace dn
