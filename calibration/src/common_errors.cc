#include "common_errors.h"

#include <dn/flight/strip_at.h>

#include <cmath>
#include <map>
#include <string>
#include <utility>

namespace dn::internal {
namespace {

/// Builds forms whose rows are labelled by keys.
class LabelledForms {
 public:
  explicit LabelledForms(Eigen::Index rows) : rows_(rows) {}

  using Key = std::pair<std::string, long>;

  void Add(const std::string& name, const std::string& channel, int row, const Key& key) {
    Entry& entry = EntryOf(name, channel);
    const auto [at, is_new] = entry.keys.try_emplace(key, entry.form.labels);
    if (is_new) {
      ++entry.form.labels;
      entry.form.label_name.push_back(key.first);
    }
    entry.form.label[static_cast<std::size_t>(row)] = at->second;
  }

  std::vector<ResidualForm> Take() {
    std::vector<ResidualForm> forms;
    for (Entry& entry : entries_) forms.push_back(std::move(entry.form));
    return forms;
  }

 private:
  struct Entry {
    ResidualForm form;
    std::map<Key, int> keys;
  };

  Entry& EntryOf(const std::string& name, const std::string& channel) {
    const auto [at, is_new] = index_.try_emplace(name, entries_.size());
    if (is_new) {
      ResidualForm form{name, channel, {}, 0, {}};
      form.label.assign(static_cast<std::size_t>(rows_), -1);
      entries_.push_back({std::move(form), {}});
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
  std::map<FactorId, std::string> names;
  for (const FlightNetwork::PairEdge& edge : network.pair_edges) {
    names[edge.id] = StripPairName(strips, edge.pair.t_i_s, edge.pair.t_j_s);
  }
  return names;
}

LabelledForms::Key Window(const std::string& key, double t_s, double length_s) {
  return {key, std::lround(std::floor(t_s / length_s))};
}

}  // namespace

std::vector<ResidualForm> CommonErrorForms(const FlightNetwork& network,
                                           const LinearizedNetwork& linearized) {
  constexpr double kShortS = 10.0, kLongS = 60.0, kPairsS = 2.0;
  LabelledForms forms(linearized.rows());
  const std::map<FactorId, std::string> strips = StripPairs(network);
  const auto add = [&](int row, FactorId id, const std::string& channel, const std::string& axis) {
    const double t_s = linearized.t_s(id);
    const auto pair = strips.find(id);
    if (pair != strips.end()) {
      const std::string key = pair->second + " (" + axis + ")";
      forms.Add(channel + ", over 2 s", channel, row, Window(key, t_s, kPairsS));
      forms.Add(channel + ", over 10 s", channel, row, Window(key, t_s, kShortS));
      forms.Add(channel + ", over pairs of strips", channel, row, {key, 0});
    } else if (std::isfinite(t_s)) {
      forms.Add(channel + ", over 10 s", channel, row, Window(axis, t_s, kShortS));
      forms.Add(channel + ", over 60 s", channel, row, Window(axis, t_s, kLongS));
    }
  };
  for (const LinearizedNetwork::FactorRows& rows : linearized.factors()) {
    const FactorGroup& group = linearized.group(rows.factor);
    if (!group.measured()) continue;
    for (int k = 0; k < rows.count; ++k) {
      add(rows.first + k, rows.factor, group.Channel(k), group.Axis(k));
    }
  }
  return forms.Take();
}

}  // namespace dn::internal
