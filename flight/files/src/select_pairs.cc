#include <dn/error.h>
#include <dn/files/flight.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

namespace dn {
namespace {

using Indices = std::vector<std::size_t>;
using Random = std::mt19937_64;

/// Returns the indices of the pairs of each file, in order of t_i.
std::vector<Indices> ByFile(const std::vector<LidarPair>& pairs) {
  std::map<int, Indices> groups;
  for (std::size_t i = 0; i < pairs.size(); ++i) groups[pairs[i].file].push_back(i);
  std::vector<Indices> files;
  for (auto& [file, indices] : groups) {
    std::stable_sort(indices.begin(), indices.end(),
                     [&](std::size_t a, std::size_t b) { return pairs[a].t_i_s < pairs[b].t_i_s; });
    files.push_back(std::move(indices));
  }
  return files;
}

/// Draws uniformly from [first, last), with the same result on every platform.
std::size_t Draw(std::size_t first, std::size_t last, Random& random) {
  const double unit = static_cast<double>(random() >> 11) * 0x1.0p-53;
  return first + static_cast<std::size_t>(unit * static_cast<double>(last - first));
}

/// Returns equal shares of `count` for the files; pairs that a small file lacks are taken from the
/// others.
std::vector<std::size_t> Shares(const std::vector<Indices>& files, std::size_t count) {
  std::vector<std::size_t> order(files.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return files[a].size() < files[b].size(); });
  std::vector<std::size_t> shares(files.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::size_t left = order.size() - i;
    shares[order[i]] = std::min(files[order[i]].size(), count / left);
    count -= shares[order[i]];
  }
  return shares;
}

/// Keeps one random pair of each of `share` equal parts of the file's pairs in time order.
void KeepSpread(const Indices& indices, std::size_t share, Random& random, Indices& kept) {
  for (std::size_t k = 0; k < share; ++k) {
    const std::size_t first = k * indices.size() / share;
    const std::size_t last = (k + 1) * indices.size() / share;
    kept.push_back(indices[Draw(first, last, random)]);
  }
}

/// Keeps the pair nearest to each tick of the raster that starts at the first pair of the file.
void KeepRaster(const std::vector<LidarPair>& pairs, const Indices& indices, double freq_hz,
                Indices& kept) {
  const double t0_s = pairs[indices.front()].t_i_s;
  double best_tick = -1.0;
  double best_distance = 0.0;
  for (const std::size_t i : indices) {
    const double phase = (pairs[i].t_i_s - t0_s) * freq_hz;
    const double tick = std::round(phase);
    const double distance = std::abs(phase - tick);
    if (tick != best_tick) {
      kept.push_back(i);
    } else if (distance < best_distance) {
      kept.back() = i;
    } else {
      continue;
    }
    best_tick = tick;
    best_distance = distance;
  }
}

/// Keeps one random pair of each window that contains pairs.
void KeepOnePerWindow(const std::vector<LidarPair>& pairs, const Indices& indices, double window_s,
                      Random& random, Indices& kept) {
  const double t0_s = pairs[indices.front()].t_i_s;
  const auto window = [&](std::size_t k) {
    return std::floor((pairs[indices[k]].t_i_s - t0_s) / window_s);
  };
  std::size_t first = 0;
  while (first < indices.size()) {
    std::size_t last = first + 1;
    while (last < indices.size() && window(last) == window(first)) ++last;
    kept.push_back(indices[Draw(first, last, random)]);
    first = last;
  }
}

void CheckSelection(const PairSelection& selection) {
  using Strategy = PairSelection::Strategy;
  const auto require = [](bool ok, const char* what) {
    if (!ok) throw InvalidConfig(std::string("selection of pairs: ") + what);
  };
  if (selection.strategy == Strategy::kMax) {
    require(selection.count && *selection.count > 0, "strategy max needs a count above 0");
  } else if (selection.strategy == Strategy::kFreq) {
    require(selection.freq_hz && *selection.freq_hz > 0.0, "strategy freq needs freq_hz above 0");
  } else if (selection.strategy == Strategy::kTimeWindow) {
    require(selection.window_s && *selection.window_s > 0.0,
            "strategy time_window needs window_s above 0");
  }
}

Indices Select(const std::vector<LidarPair>& pairs, const PairSelection& selection) {
  using Strategy = PairSelection::Strategy;
  const std::vector<Indices> files = ByFile(pairs);
  Random random(selection.seed);
  Indices kept;
  if (selection.strategy == Strategy::kMax) {
    const std::vector<std::size_t> shares =
        Shares(files, static_cast<std::size_t>(*selection.count));
    for (std::size_t f = 0; f < files.size(); ++f) KeepSpread(files[f], shares[f], random, kept);
  }
  for (const Indices& indices : files) {
    if (selection.strategy == Strategy::kFreq) {
      KeepRaster(pairs, indices, *selection.freq_hz, kept);
    } else if (selection.strategy == Strategy::kTimeWindow) {
      KeepOnePerWindow(pairs, indices, *selection.window_s, random, kept);
    }
  }
  std::sort(kept.begin(), kept.end());
  return kept;
}

}  // namespace

std::vector<LidarPair> SelectPairs(const std::vector<LidarPair>& pairs,
                                   const PairSelection& selection) {
  CheckSelection(selection);
  if (selection.strategy == PairSelection::Strategy::kAll) return pairs;
  std::vector<LidarPair> selected;
  for (const std::size_t i : Select(pairs, selection)) selected.push_back(pairs[i]);
  return selected;
}

}  // namespace dn
