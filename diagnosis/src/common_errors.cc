#include "common_errors.h"

#include <dn/files/strip_at.h>

#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

namespace dn::diagnosis_internal {
namespace {

/// Assigns numbers to names, in the order of their first use.
class Names {
 public:
  int Number(const std::string& name) {
    const auto [at, is_new] = number_.try_emplace(name, static_cast<int>(names_.size()));
    if (is_new) names_.push_back(name);
    return at->second;
  }
  const std::string& operator[](int number) const {
    return names_[static_cast<std::size_t>(number)];
  }

 private:
  std::map<std::string, int> number_;
  std::vector<std::string> names_;
};

/// Builds quadratic forms whose rows are labelled by a name and a time window.
class LabelledForms {
 public:
  explicit LabelledForms(Eigen::Index rows) : rows_(rows) {}

  struct Key {
    int name = 0;
    long window = 0;

    friend bool operator==(const Key&, const Key&) = default;
  };

  int Form(const std::string& name, const std::string& channel) {
    const int form = form_names_.Number(name);
    if (static_cast<std::size_t>(form) == entries_.size()) {
      entries_.push_back({{name, channel, {}, 0, {}}, {}});
      entries_.back().form.label.assign(static_cast<std::size_t>(rows_), -1);
    }
    return form;
  }

  int Name(const std::string& name) { return names_.Number(name); }

  void Add(int form, int row, const Key& key) {
    Entry& entry = entries_[static_cast<std::size_t>(form)];
    const auto [at, is_new] = entry.labels.try_emplace(key, entry.form.labels);
    if (is_new) {
      ++entry.form.labels;
      entry.form.label_name.push_back(names_[key.name]);
    }
    entry.form.label[static_cast<std::size_t>(row)] = at->second;
  }

  std::vector<ResidualForm> Take() {
    std::vector<ResidualForm> forms;
    for (Entry& entry : entries_) forms.push_back(std::move(entry.form));
    return forms;
  }

 private:
  struct KeyHash {
    std::size_t operator()(const Key& key) const {
      return std::hash<long>()(key.window * 4099 + key.name);
    }
  };
  struct Entry {
    ResidualForm form;
    std::unordered_map<Key, int, KeyHash> labels;
  };

  Eigen::Index rows_;
  Names form_names_, names_;
  std::vector<Entry> entries_;
};

LabelledForms::Key Window(int name, double t_s, double length_s) {
  return {name, std::lround(std::floor(t_s / length_s))};
}

/// Assigns rows to the forms of their channel: rows of pairs by strip pair and time window, all
/// others by time window.
class CommonErrors {
 public:
  CommonErrors(const FlightNetwork& network, const LinearizedNetwork& linearized)
      : linearized_(linearized), strips_(FindStrips(network.flight())), forms_(linearized.rows()) {
    for (const PairEdge& edge : network.pairs().edges()) {
      strips_of_[edge.id] = {StripAt(strips_, edge.pair.t_i_s), StripAt(strips_, edge.pair.t_j_s)};
    }
  }

  std::vector<ResidualForm> Run() {
    for (const LinearizedNetwork::FactorRows& rows : linearized_.factors()) {
      const FactorGroup& group = linearized_.group(rows.factor);
      if (!group.measured()) continue;
      const auto pair = strips_of_.find(rows.factor);
      const double t_s = linearized_.t_s(rows.factor);
      const bool is_pair = pair != strips_of_.end();
      if (!is_pair && !std::isfinite(t_s)) continue;
      for (int k = 0; k < rows.count; ++k) {
        Add(rows.first + k, is_pair ? PairPlace(group, k, pair->second) : OtherPlace(group, k),
            t_s);
      }
    }
    return forms_.Take();
  }

 private:
  static constexpr double kShort_s = 10.0, kLong_s = 60.0, kPairs_s = 2.0;
  static constexpr double kAll_s = std::numeric_limits<double>::infinity();

  using Strips = std::pair<const StripInterval*, const StripInterval*>;
  /// Residuals of one channel and axis, and of one strip pair.
  using Kind = std::tuple<const FactorGroup*, int, Strips>;
  struct Place {
    std::vector<std::pair<int, double>> forms;  ///< forms with the length of their windows, s
    int name = 0;
  };

  const Place& PairPlace(const FactorGroup& group, int k, const Strips& strips) {
    const auto [at, is_new] = places_.try_emplace(Kind{&group, k, strips});
    if (is_new) {
      const std::string channel = group.Channel(k);
      at->second = {
          {{forms_.Form(channel + ", over 2 s", channel), kPairs_s},
           {forms_.Form(channel + ", over 10 s", channel), kShort_s},
           {forms_.Form(channel + ", over pairs of strips", channel), kAll_s}},
          forms_.Name(StripPairName(strips.first, strips.second) + " (" + group.Axis(k) + ")")};
    }
    return at->second;
  }

  const Place& OtherPlace(const FactorGroup& group, int k) {
    const auto [at, is_new] = places_.try_emplace(Kind{&group, k, Strips{}});
    if (is_new) {
      const std::string channel = group.Channel(k);
      at->second = {{{forms_.Form(channel + ", over 10 s", channel), kShort_s},
                     {forms_.Form(channel + ", over 60 s", channel), kLong_s}},
                    forms_.Name(group.Axis(k))};
    }
    return at->second;
  }

  void Add(int row, const Place& place, double t_s) {
    for (const auto& [form, length_s] : place.forms) {
      forms_.Add(form, row, Window(place.name, t_s, length_s));
    }
  }

  const LinearizedNetwork& linearized_;
  std::vector<StripInterval> strips_;
  LabelledForms forms_;
  std::unordered_map<FactorId, Strips> strips_of_;
  std::map<Kind, Place> places_;
};

}  // namespace

std::vector<ResidualForm> CommonErrorForms(const FlightNetwork& network,
                                           const LinearizedNetwork& linearized) {
  return CommonErrors(network, linearized).Run();
}

}  // namespace dn::diagnosis_internal
