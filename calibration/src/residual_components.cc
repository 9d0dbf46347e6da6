#include "residual_components.h"

#include <cmath>
#include <map>
#include <optional>
#include <utility>

namespace dn::internal {
namespace {

/// What one row of the linearised network is.
struct RowName {
  std::string sensor;  ///< "inertial gyro"; empty: none of a sensor's
  std::string axis;
};

RowName NameOf(const Network& net, FactorId id, int row) {
  static const char* const kXyz[] = {"x", "y", "z"};
  static const char* const kEnu[] = {"east", "north", "up"};
  static const char* const kInertial[] = {"inertial gyro", "inertial velocity",
                                          "inertial position"};
  const FactorRecord& record = net.factor(id);
  const std::string& group = net.groups()[static_cast<std::size_t>(record.group)];
  const int size = record.factor->residual_size();
  if (group == "inertial" && size == 9) return {kInertial[row / 3], kXyz[row % 3]};
  if (group == "bias process" && size == 3) {
    const bool gyro = net.block(record.blocks.front()).name.rfind("gyro", 0) == 0;
    return {gyro ? "gyro bias process" : "accel bias process", kXyz[row]};
  }
  if (group.empty() || group == "prior") return {};
  if (size == 3) return {group, kEnu[row]};
  return {group, std::to_string(row)};
}

/// Calls visit(row, factor, name) for the rows that belong to a sensor.
template <class Visit>
void ForEachRow(const Network& net, const LinearizedNetwork& linearized, const Visit& visit) {
  for (const LinearizedNetwork::FactorRows& rows : linearized.factors()) {
    for (int k = 0; k < rows.count; ++k) {
      const RowName name = NameOf(net, rows.factor, k);
      if (!name.sensor.empty()) visit(rows.first + k, rows.factor, name);
    }
  }
}

/// Builds components whose rows are labelled by keys.
class Components {
 public:
  explicit Components(Eigen::Index rows) : rows_(rows) {}

  using Key = std::pair<std::string, long>;

  void Add(const std::string& name, const std::string& group, int row, const Key& key) {
    Entry& entry = EntryOf(name, group);
    const auto [at, is_new] = entry.keys.try_emplace(key, entry.component.labels);
    if (is_new) {
      ++entry.component.labels;
      entry.component.label_name.push_back(key.first);
    }
    entry.component.label[static_cast<std::size_t>(row)] = at->second;
  }

  std::vector<ResidualComponent> Take() {
    std::vector<ResidualComponent> components;
    for (Entry& entry : entries_) components.push_back(std::move(entry.component));
    return components;
  }

 private:
  struct Entry {
    ResidualComponent component;
    std::map<Key, int> keys;
  };

  Entry& EntryOf(const std::string& name, const std::string& group) {
    const auto [at, is_new] = index_.try_emplace(name, entries_.size());
    if (is_new) {
      ResidualComponent component{name, group, {}, 0, {}};
      component.label.assign(static_cast<std::size_t>(rows_), -1);
      entries_.push_back({std::move(component), {}});
    }
    return entries_[at->second];
  }

  Eigen::Index rows_;
  std::vector<Entry> entries_;
  std::map<std::string, std::size_t> index_;
};

/// Names the pair of strips of every pair edge, by its factor.
std::map<FactorId, std::string> StripPairs(const FlightNetwork& network) {
  const std::vector<StripInterval> strips = FindStrips(network.flight());
  const auto strip_at = [&](double t_s) {
    for (std::size_t k = 0; k < strips.size(); ++k) {
      if (t_s >= strips[k].t0_s && t_s <= strips[k].t1_s) return strips[k].name;
    }
    return std::string("?");
  };
  std::map<FactorId, std::string> names;
  for (const FlightNetwork::PairEdge& edge : network.pair_edges) {
    names[edge.id] = strip_at(edge.pair.t_i_s) + "-" + strip_at(edge.pair.t_j_s);
  }
  return names;
}

Components::Key Window(const std::string& key, double t_s, double length_s) {
  return {key, std::lround(std::floor(t_s / length_s))};
}

}  // namespace

double ResidualComponent::Energy(const Eigen::Ref<const Eigen::VectorXd>& residual) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(labels);
  for (std::size_t row = 0; row < label.size(); ++row) {
    if (label[row] >= 0) sum[label[row]] += residual[static_cast<Eigen::Index>(row)];
  }
  return sum.squaredNorm();
}

Eigen::MatrixXd ResidualComponent::SumByLabel(const Eigen::MatrixXd& X) const {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(labels, X.cols());
  for (std::size_t row = 0; row < label.size(); ++row) {
    if (label[row] >= 0) sum.row(label[row]) += X.row(static_cast<Eigen::Index>(row));
  }
  return sum;
}

std::vector<ResidualComponent> GroupComponents(const FlightNetwork& network,
                                               const LinearizedNetwork& linearized) {
  Components components(linearized.rows());
  ForEachRow(network.net, linearized, [&](int row, FactorId, const RowName& name) {
    const Components::Key key{"", row};
    components.Add(name.sensor, name.sensor, row, key);
    components.Add(name.sensor + " " + name.axis, name.sensor, row, key);
  });
  return components.Take();
}

std::vector<ResidualComponent> CommonErrorComponents(const FlightNetwork& network,
                                                     const LinearizedNetwork& linearized) {
  constexpr double kShortS = 10.0, kLongS = 60.0, kPairsS = 2.0;
  Components components(linearized.rows());
  const std::map<FactorId, std::string> strips = StripPairs(network);
  ForEachRow(network.net, linearized, [&](int row, FactorId id, const RowName& name) {
    const double t_s = network.net.factor(id).t_s;
    const auto pair = strips.find(id);
    if (pair != strips.end()) {
      const std::string key = pair->second + " (" + name.axis + ")";
      components.Add(name.sensor + ", over 2 s", name.sensor, row, Window(key, t_s, kPairsS));
      components.Add(name.sensor + ", over 10 s", name.sensor, row, Window(key, t_s, kShortS));
      components.Add(name.sensor + ", over pairs of strips", name.sensor, row, {key, 0});
    } else if (std::isfinite(t_s)) {
      components.Add(name.sensor + ", over 10 s", name.sensor, row,
                     Window(name.axis, t_s, kShortS));
      components.Add(name.sensor + ", over 60 s", name.sensor, row, Window(name.axis, t_s, kLongS));
    }
  });
  return components.Take();
}

}  // namespace dn::internal
