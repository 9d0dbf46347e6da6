#pragma once

#include <cstddef>
#include <vector>

#include "picked_columns.h"
#include "text_sample.h"

namespace dn::files_internal {

/// Columns of a text without names that may be parts of vectors.
class VectorColumns {
 public:
  /// Takes the columns after `first` that have numbers, no known other meaning, and are not part
  /// of a unit quaternion.
  VectorColumns(const TextSample& sample, const TimeColumn& time, std::size_t first);

  /// Returns the first of each three adjacent columns. At most one of the three is constant, unless
  /// the file has nothing but constants.
  const std::vector<std::size_t>& triples() const { return triples_; }
  /// Returns the first column that may be part of a vector.
  std::size_t begin() const { return begin_; }
  /// Returns whether at least two of three columns are integrals of other columns, as angles are
  /// of rates.
  bool IsIntegral(std::size_t triple) const;
  /// Returns log10 of the ratio of the largest to the least noise of three columns. The axes of
  /// one sensor have similar noise.
  double Unlikeness(std::size_t triple) const;

 private:
  struct Column {
    bool usable = false, constant = false;
    double noise = 0.0;                     ///< standard deviation of the steps from row to row
    std::vector<double> means, increments;  ///< of blocks of a second
  };
  void Measure(const TextTable& table, double step_s, std::size_t at);
  void LeaveOutQuaternions(const TextTable& table);
  void FindTriples();

  std::vector<Column> columns_;
  std::vector<std::size_t> triples_;
  std::size_t begin_ = 0;
};

}  // namespace dn::files_internal
