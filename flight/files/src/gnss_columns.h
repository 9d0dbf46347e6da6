#pragma once

#include <dn/geo/text_table.h>

#include <string>
#include <vector>

#include "picked_columns.h"
#include "text_sample.h"

namespace dn::files_internal {

/// Columns of a file of GNSS positions: the position, perhaps sigmas and velocities, and columns
/// that are added to others.
struct GnssChoice {
  std::vector<NamedColumn> position, sigma = {}, velocity = {}, added = {};
  std::string crs = {};       ///< "ecef", "utm:" or empty for geographic coordinates
  std::string note = {};      ///< what is uncertain about the columns
  std::string accuracy = {};  ///< names of columns with an accuracy that `columns` cannot express
  bool by_name = false;       ///< not by the values

  /// Returns position, sigmas and velocities.
  std::vector<NamedColumn> Quantities() const;
};

/// A choice, or why there is none.
struct FoundGnss {
  GnssChoice choice;
  std::string failed;
};

/// Finds the columns by the names of the header, else by their values. `spelled` has spelled names,
/// `sample` those of the file.
FoundGnss FindGnssColumns(const TextSample& sample, const TextSample& spelled,
                          const TimeColumn& time);

/// Returns the rows with time and the columns, in deg, m and m/s; variances as sigmas.
TextTable GnssRows(const TextSample& sample, const TimeColumn& time,
                   const std::vector<NamedColumn>& columns);

}  // namespace dn::files_internal
