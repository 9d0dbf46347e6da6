#include <dn/error.h>
#include <dn/report/json.h>
#include <dn/report/statistics.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace dn {
namespace {

constexpr int kLags[] = {1, 2, 5, 10, 20, 50};
constexpr std::size_t kWorstEpochs = 5;
// The fit absorbs a residual whose redundancy is below this; its standardised value is meaningless.
constexpr double kSmallestVariance = 1e-6;

double Autocovariance(const std::vector<double>& values, double mean, std::size_t lag) {
  double sum = 0.0;
  for (std::size_t i = lag; i < values.size(); ++i) {
    sum += (values[i] - mean) * (values[i - lag] - mean);
  }
  return sum / static_cast<double>(values.size());
}

void AddAutocorrelation(const std::vector<double>& values, SeriesStatistics* s) {
  s->variance = Autocovariance(values, s->mean, 0);
  if (!(s->variance > 0.0)) return;
  s->lag1_correlation = Autocovariance(values, s->mean, 1) / s->variance;
  for (const int lag : kLags) {
    if (4 * static_cast<std::size_t>(lag) > values.size()) break;
    s->autocorrelation.emplace_back(
        lag, Autocovariance(values, s->mean, static_cast<std::size_t>(lag)) / s->variance);
  }
}

std::vector<SeriesEpoch> WorstEpochs(std::vector<SeriesEpoch> epochs) {
  const std::size_t n = std::min(kWorstEpochs, epochs.size());
  const auto worse = [](const SeriesEpoch& a, const SeriesEpoch& b) {
    const double size_a = std::abs(a.standardised), size_b = std::abs(b.standardised);
    return size_a != size_b ? size_a > size_b : a.t_s < b.t_s;
  };
  std::partial_sort(epochs.begin(), epochs.begin() + static_cast<std::ptrdiff_t>(n), epochs.end(),
                    worse);
  epochs.resize(n);
  return epochs;
}

Json ToJson(const SeriesStatistics& s) {
  Json json = {{"count", s.count},
               {"mean", s.mean},
               {"variance", s.variance},
               {"expected_variance", s.expected_variance},
               {"lag1_correlation", s.lag1_correlation},
               {"autocorrelation", Json::object()},
               {"nis", s.mean_square},
               {"worst", s.worst},
               {"worst_t_s", s.worst_t_s},
               {"worst_epochs", Json::array()}};
  for (const auto& [lag, correlation] : s.autocorrelation) {
    json["autocorrelation"][std::to_string(lag)] = correlation;
  }
  for (const SeriesEpoch& epoch : s.worst_epochs) {
    json["worst_epochs"].push_back(
        {{"t_s", epoch.t_s}, {"value", epoch.value}, {"standardised", epoch.standardised}});
  }
  return json;
}

}  // namespace

SeriesStatistics DescribeSeries(const std::string& sensor, const std::string& axis,
                                const std::vector<double>& t_s, const std::vector<double>& values,
                                const std::vector<double>& expected_variances) {
  if (t_s.size() != values.size() ||
      (!expected_variances.empty() && expected_variances.size() != values.size())) {
    throw InvalidInput("statistics of " + sensor + " " + axis + ": " +
                       std::to_string(values.size()) + " values, " + std::to_string(t_s.size()) +
                       " times, " + std::to_string(expected_variances.size()) + " variances");
  }
  SeriesStatistics s;
  s.sensor = sensor;
  s.axis = axis;
  s.count = static_cast<long>(values.size());
  if (values.empty()) return s;
  const auto n = static_cast<double>(values.size());
  std::vector<SeriesEpoch> epochs;
  s.expected_variance = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double variance = expected_variances.empty() ? 1.0 : expected_variances[i];
    s.mean += values[i] / n;
    s.mean_square += values[i] * values[i] / n;
    s.expected_variance += variance / n;
    if (variance > kSmallestVariance) {
      epochs.push_back({t_s[i], values[i], values[i] / std::sqrt(variance)});
    }
  }
  AddAutocorrelation(values, &s);
  s.worst_epochs = WorstEpochs(std::move(epochs));
  if (s.worst_epochs.empty()) return s;
  s.worst = s.worst_epochs.front().standardised;
  s.worst_t_s = s.worst_epochs.front().t_s;
  return s;
}

Json StatisticsToJson(const std::vector<SeriesStatistics>& statistics) {
  Json json = Json::object();
  for (const SeriesStatistics& s : statistics) json[s.sensor][s.axis] = ToJson(s);
  return json;
}

}  // namespace dn
