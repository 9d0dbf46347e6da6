#pragma once

#include <dn/geo/gps_time.h>
#include <dn/geo/text_table.h>

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dn::files_internal {

/// A date in one column, with the time of day in another.
struct DateColumn {
  std::size_t at = 0;    ///< of the date
  std::size_t time = 0;  ///< of the time of day
  DateOrder order = DateOrder::kYearFirst;
  bool is_guess = false;  ///< day and month may be exchanged
  bool is_gps = false;    ///< in GPS time, not in UTC

  /// Returns the name for flight.yaml, such as "date_utc_dmy".
  std::string Name() const;
  /// Returns GPS seconds since 1980 of a row; nullopt if it has no such date and time.
  std::optional<double> Seconds(const std::vector<std::string_view>& row) const;
};

/// Finds a date with separators next to a time of day with colons, by the fields of a row.
std::optional<DateColumn> FindDateColumn(const std::vector<std::string_view>& row);

/// Finds a date and a time of day without separators, such as 20230921 or 210923 and 094942.00, by
/// the names of the columns and all values.
std::optional<DateColumn> FindPlainDate(const std::vector<std::string>& names,
                                        const TextTable& table);

/// Returns whether the names of the two columns say that they are in GPS time.
bool NamesGpsTime(const DateColumn& column, const std::vector<std::string>& names);

/// Returns GPS seconds since 1980 of a row with a date and a time of day as numbers; nullopt if
/// they are not.
std::optional<double> PlainSeconds(const DateColumn& column, const double* row);

}  // namespace dn::files_internal
