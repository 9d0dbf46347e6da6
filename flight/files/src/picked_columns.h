#pragma once

#include <dn/geo/named_columns.h>
#include <dn/geo/text_table.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "column_meaning.h"
#include "text_sample.h"

namespace dn::files_internal {

/// Steps of the time, s, that are plausible for a kind of file.
struct StepRange {
  double least_s, most_s;
  double usual_s;  ///< among several plausible units other than s, the one with this step is taken
};

/// The column of the time, perhaps with a column of GPS weeks or of nanoseconds.
struct TimeColumn {
  std::size_t at = 0;
  std::optional<std::size_t> week = {};
  std::string name = "t";  ///< t, t_min, t_ms, t_100us, t_us, t_ns, t_utc or time_of_day
  std::optional<std::size_t> nanoseconds = {};
  std::optional<DateColumn> date = {};  ///< for time_of_day
};

/// A column with the name of its quantity.
struct NamedColumn {
  std::string name;
  std::size_t at;
};

/// Finds the time by the names of the columns (stamps of sensors before GPS times, and these before
/// a date with its time of day, and this before others). Without names it takes the first column,
/// or the one next to a column of GPS weeks. The unit follows from the name, else from the size of
/// the steps. Returns nullopt if the time does not increase, or has no plausible step in any unit.
std::optional<TimeColumn> FindTime(const TextSample& sample, const StepRange& steps);

/// Returns whether a column is a GPS week: one whole number, or two adjacent ones.
bool IsWeek(const TextTable& table, std::size_t at);

/// Returns the meanings of the columns; without a header, none has a name. Three adjacent rates or
/// forces with the numbers 0, 1, 2 or 1, 2, 3 are those of x, y, z.
std::vector<ColumnMeaning> FindMeanings(const TextSample& sample);

/// Returns whether a column has no name of known meaning.
bool IsUnnamed(const std::vector<ColumnMeaning>& meanings, std::size_t at);

/// Returns whether the header names both angular rates and specific forces.
bool NamesInertialData(const std::vector<ColumnMeaning>& meanings);

/// Returns the column with this name, the first if there are several.
std::optional<NamedColumn> FindColumn(const std::vector<ColumnMeaning>& meanings,
                                      const std::string& name);

/// Returns the columns with minutes and seconds of latitude and longitude.
std::vector<NamedColumn> FindMinutes(const std::vector<ColumnMeaning>& meanings);

/// Returns the rows with time [s] and the given columns. Rows with a value that is not finite are
/// left out.
TextTable PickRows(const TextSample& sample, const TimeColumn& time,
                   const std::vector<NamedColumn>& columns);

/// Returns whether PickRows has left out few rows only.
bool AreNumbers(const TextTable& picked, const TextSample& sample);

/// Returns the names of all columns of the file up to the last one used.
ColumnNames FormatNames(const TimeColumn& time, const std::vector<NamedColumn>& columns);

/// Returns the median of the positive steps of the time, s; 0 if there are none.
double MedianTimeStep(const TextTable& table);

}  // namespace dn::files_internal
