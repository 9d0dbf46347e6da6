#include "residual_statistics.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

namespace dn {
namespace {

using FactorRows = LinearizedNetwork::FactorRows;

/// The factors with one name and the same axes.
struct Series {
  const FactorGroup* group;
  std::vector<FactorRows> factors;
};

/// Returns the series of a kind in the order of their first factors.
std::vector<Series> GroupSeries(const LinearizedNetwork& linearized, FactorGroup::Kind kind) {
  std::vector<Series> all;
  for (const FactorRows& rows : linearized.factors()) {
    const FactorGroup& group = linearized.group(rows.factor);
    if (group.name.empty() || group.kind != kind) continue;
    const auto same = std::find_if(all.begin(), all.end(), [&](const Series& series) {
      return series.group->name == group.name && series.factors.front().count == rows.count;
    });
    if (same == all.end()) {
      all.push_back({&group, {rows}});
    } else {
      same->factors.push_back(rows);
    }
  }
  return all;
}

void Describe(const LinearizedNetwork& linearized, const Eigen::VectorXd& redundancy, Series series,
              std::vector<SeriesStatistics>* statistics) {
  std::stable_sort(series.factors.begin(), series.factors.end(),
                   [&](const FactorRows& a, const FactorRows& b) {
                     return linearized.t_s(a.factor) < linearized.t_s(b.factor);
                   });
  std::vector<double> t_s;
  for (const FactorRows& rows : series.factors) t_s.push_back(linearized.t_s(rows.factor));
  for (int axis = 0; axis < series.factors.front().count; ++axis) {
    std::vector<double> values, variances;
    for (const FactorRows& rows : series.factors) {
      values.push_back(linearized.residual()[rows.first + axis]);
      variances.push_back(redundancy[rows.first + axis]);
    }
    statistics->push_back(DescribeSeries(series.group->name, series.group->QuantityAndAxis(axis),
                                         t_s, values, variances));
  }
}

}  // namespace

std::vector<SeriesStatistics> ResidualStatistics(const LinearizedNetwork& linearized,
                                                 const Eigen::VectorXd& redundancy) {
  std::vector<SeriesStatistics> statistics;
  for (const auto kind : {FactorGroup::Kind::kMeasurement, FactorGroup::Kind::kProcess}) {
    for (Series& series : GroupSeries(linearized, kind)) {
      Describe(linearized, redundancy, std::move(series), &statistics);
    }
  }
  return statistics;
}

}  // namespace dn
