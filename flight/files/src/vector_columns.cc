#include "vector_columns.h"

#include <algorithm>
#include <cmath>

namespace dn::files_internal {
namespace {

constexpr std::size_t kMostColumns = 24;
constexpr double kLeastNumbers = 0.9;
constexpr double kQuaternionTolerance = 3e-4;
// The correlation of increments over a second with the mean of the derivative.
constexpr double kLeastCorrelation = 0.8;
constexpr std::size_t kLeastBlocks = 10;

/// Returns the correlation of two series of the same length; 0 if one of them is constant.
double Correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const double count = static_cast<double>(a.size());
  double sum_a = 0.0, sum_b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum_a += a[i] / count;
    sum_b += b[i] / count;
  }
  for (std::size_t i = 0; i < a.size(); ++i) {
    aa += (a[i] - sum_a) * (a[i] - sum_a);
    bb += (b[i] - sum_b) * (b[i] - sum_b);
    ab += (a[i] - sum_a) * (b[i] - sum_b);
  }
  return aa > 0.0 && bb > 0.0 ? ab / std::sqrt(aa * bb) : 0.0;
}

std::vector<double> Values(const TextTable& table, std::size_t at) {
  std::vector<double> values;
  for (std::size_t i = 0; i < table.rows(); ++i) values.push_back(table.row(i)[at]);
  return values;
}

double NoiseLevel(const std::vector<double>& values) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double step = values[i] - values[i - 1];
    if (!std::isfinite(step)) continue;
    sum += step * step;
    ++count;
  }
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

}  // namespace

VectorColumns::VectorColumns(const TextSample& sample, const TimeColumn& time, std::size_t first) {
  const TextTable& table = sample.table;
  columns_.resize(std::min(table.columns, first + kMostColumns));
  const double step_s = MedianTimeStep(PickRows(sample, time, {}));
  const std::vector<ColumnMeaning> meanings = FindMeanings(sample);
  for (std::size_t at = first; at < columns_.size(); ++at) {
    const bool inertial = at < meanings.size() && !meanings[at].sensor.empty();
    if (IsUnnamed(meanings, at) || inertial) Measure(table, step_s, at);
  }
  LeaveOutQuaternions(table);
  FindTriples();
}

void VectorColumns::Measure(const TextTable& table, double step_s, std::size_t at) {
  Column& column = columns_[at];
  const std::vector<double> values = Values(table, at);
  const auto numbers =
      std::count_if(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
  column.usable =
      static_cast<double>(numbers) >= kLeastNumbers * static_cast<double>(values.size());
  if (!column.usable || values.empty()) return;
  column.constant =
      std::all_of(values.begin(), values.end(), [&](double x) { return x == values.front(); });
  column.noise = NoiseLevel(values);
  const auto block =
      static_cast<std::size_t>(std::clamp(std::round(1.0 / std::max(step_s, 1e-9)), 1.0, 1e6));
  for (std::size_t i = 0; i + block < values.size(); i += block) {
    double mean = 0.0;
    for (std::size_t k = i; k < i + block; ++k) mean += values[k] / static_cast<double>(block);
    const double increment = values[i + block] - values[i];
    column.means.push_back(std::isfinite(mean) ? mean : 0.0);
    column.increments.push_back(std::isfinite(increment) ? increment : 0.0);
  }
}

void VectorColumns::LeaveOutQuaternions(const TextTable& table) {
  std::vector<std::size_t> found;
  for (std::size_t at = 0; at + 4 <= columns_.size(); ++at) {
    bool is_unit = true;
    for (std::size_t i = 0; is_unit && i < table.rows(); ++i) {
      const double* q = table.row(i) + at;
      const double norm = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
      is_unit = std::abs(norm - 1.0) < kQuaternionTolerance;
    }
    const auto constant = std::count_if(columns_.begin() + static_cast<std::ptrdiff_t>(at),
                                        columns_.begin() + static_cast<std::ptrdiff_t>(at + 4),
                                        [](const Column& each) { return each.constant; });
    if (is_unit && constant < 3) found.push_back(at);
  }
  for (const std::size_t at : found) {
    for (std::size_t k = at; k < at + 4; ++k) columns_[k].usable = false;
  }
}

void VectorColumns::FindTriples() {
  const auto usable = [](const Column& column) { return column.usable; };
  const auto begin = std::find_if(columns_.begin(), columns_.end(), usable);
  begin_ = static_cast<std::size_t>(begin - columns_.begin());
  const bool all_constant = std::all_of(begin, columns_.end(), [](const Column& column) {
    return column.constant || !column.usable;
  });
  for (std::size_t at = begin_; at + 3 <= columns_.size(); ++at) {
    const Column* three = &columns_[at];
    const auto constant =
        std::count_if(three, three + 3, [](const Column& column) { return column.constant; });
    if (std::all_of(three, three + 3, usable) && (constant < 2 || all_constant)) {
      triples_.push_back(at);
    }
  }
}

bool VectorColumns::IsIntegral(std::size_t triple) const {
  int integrals = 0;
  for (std::size_t a = triple; a < triple + 3; ++a) {
    const std::vector<double>& increments = columns_[a].increments;
    if (increments.size() < kLeastBlocks) return false;
    bool found = false;
    for (std::size_t b = 0; b < columns_.size(); ++b) {
      if (!columns_[b].usable || (b >= triple && b < triple + 3)) continue;
      found = found || std::abs(Correlation(increments, columns_[b].means)) > kLeastCorrelation;
    }
    if (found) ++integrals;
  }
  return integrals >= 2;
}

double VectorColumns::Unlikeness(std::size_t triple) const {
  double least = 1e300, most = 0.0;
  for (std::size_t at = triple; at < triple + 3; ++at) {
    least = std::min(least, columns_[at].noise);
    most = std::max(most, columns_[at].noise);
  }
  constexpr double kMostDecades = 3.0;
  if (most == 0.0) return 0.0;
  return least > 0.0 ? std::min(kMostDecades, std::log10(most / least)) : kMostDecades;
}

}  // namespace dn::files_internal
