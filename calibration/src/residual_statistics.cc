#include "residual_statistics.h"

#include <dn/solvers/prediction.h>

#include <algorithm>
#include <map>
#include <string>

namespace dn {
namespace {

struct AxisNames {
  const char* group;
  std::vector<std::string> axes;
};

const std::vector<AxisNames>& SensorAxes() {
  static const std::vector<AxisNames> axes{
      {"inertial",
       {"gyro_x", "gyro_y", "gyro_z", "velocity_x", "velocity_y", "velocity_z", "position_x",
        "position_y", "position_z"}},
      {"gnss position", {"east", "north", "up"}},
      {"gnss velocity", {"east", "north", "up"}},
      {"lidar p2p", {"east", "north", "up"}},
      {"bias process", {"x", "y", "z"}}};
  return axes;
}

using Fits = std::vector<const FactorFit*>;

// Factors of each group, by time.
std::map<std::string, Fits> FitsByGroup(const Network& net, const std::vector<FactorFit>& fits) {
  std::map<std::string, Fits> by_group;
  for (const FactorFit& fit : fits) {
    const FactorRecord& record = net.factor(fit.factor);
    by_group[net.groups()[static_cast<std::size_t>(record.group)]].push_back(&fit);
  }
  for (auto& [name, group] : by_group) {
    std::stable_sort(group.begin(), group.end(), [&](const FactorFit* a, const FactorFit* b) {
      return net.factor(a->factor).t_s < net.factor(b->factor).t_s;
    });
  }
  return by_group;
}

void DescribeSensor(const Network& net, const AxisNames& sensor, const Fits& fits,
                    std::vector<SeriesStatistics>* statistics) {
  std::vector<double> t_s;
  for (const FactorFit* fit : fits) t_s.push_back(net.factor(fit->factor).t_s);
  for (std::size_t a = 0; a < sensor.axes.size(); ++a) {
    std::vector<double> values, variances;
    for (const FactorFit* fit : fits) {
      values.push_back(fit->residual[static_cast<Eigen::Index>(a)]);
      variances.push_back(fit->redundancy[static_cast<Eigen::Index>(a)]);
    }
    statistics->push_back(DescribeSeries(sensor.group, sensor.axes[a], t_s, values, variances));
  }
}

}  // namespace

std::vector<FactorFit> FitOfFactors(const Network& net, const Marginals& marginals) {
  std::vector<FactorFit> fits;
  for (FactorId id = 0; id < net.num_factors(); ++id) {
    Eigen::VectorXd r;
    if (!net.factor(id).active || !net.EvaluateFactor(id, &r)) continue;
    fits.push_back({id, r, RedundancyNumbers(net, id, marginals)});
  }
  return fits;
}

std::vector<SeriesStatistics> ResidualStatistics(const Network& net,
                                                 const std::vector<FactorFit>& fits) {
  const auto by_group = FitsByGroup(net, fits);
  std::vector<SeriesStatistics> statistics;
  for (const AxisNames& sensor : SensorAxes()) {
    const auto group = by_group.find(sensor.group);
    if (group != by_group.end()) DescribeSensor(net, sensor, group->second, &statistics);
  }
  return statistics;
}

}  // namespace dn
