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

// Active factors of each group, by time.
std::map<std::string, std::vector<FactorId>> FactorsByGroup(const Network& net) {
  std::map<std::string, std::vector<FactorId>> by_group;
  for (FactorId id = 0; id < net.num_factors(); ++id) {
    const FactorRecord& record = net.factor(id);
    if (record.active) by_group[net.groups()[static_cast<std::size_t>(record.group)]].push_back(id);
  }
  for (auto& [name, ids] : by_group) {
    std::stable_sort(ids.begin(), ids.end(),
                     [&](FactorId a, FactorId b) { return net.factor(a).t_s < net.factor(b).t_s; });
  }
  return by_group;
}

void DescribeSensor(const Network& net, const Marginals& marginals, const AxisNames& sensor,
                    const std::vector<FactorId>& ids, std::vector<SeriesStatistics>* statistics) {
  std::vector<double> t_s;
  std::vector<std::vector<double>> values(sensor.axes.size()), variances(sensor.axes.size());
  for (const FactorId id : ids) {
    Eigen::VectorXd r;
    if (!net.EvaluateFactor(id, &r)) continue;
    const Eigen::VectorXd redundancy = RedundancyNumbers(net, id, marginals);
    t_s.push_back(net.factor(id).t_s);
    for (std::size_t a = 0; a < values.size(); ++a) {
      values[a].push_back(r[static_cast<Eigen::Index>(a)]);
      variances[a].push_back(redundancy[static_cast<Eigen::Index>(a)]);
    }
  }
  for (std::size_t a = 0; a < values.size(); ++a) {
    statistics->push_back(
        DescribeSeries(sensor.group, sensor.axes[a], t_s, values[a], variances[a]));
  }
}

}  // namespace

std::vector<SeriesStatistics> ResidualStatistics(const Network& net, const Marginals& marginals) {
  const auto by_group = FactorsByGroup(net);
  std::vector<SeriesStatistics> statistics;
  for (const AxisNames& sensor : SensorAxes()) {
    const auto ids = by_group.find(sensor.group);
    if (ids != by_group.end()) DescribeSensor(net, marginals, sensor, ids->second, &statistics);
  }
  return statistics;
}

}  // namespace dn
