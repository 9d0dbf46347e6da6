#pragma once

#include <dn/geo/text_table.h>

#include <filesystem>
#include <string>
#include <vector>

namespace dn {

/// Names of the columns of a text file, in the order of the file:
///   t, t_ms, t_us, t_ns  time in s, ms, us, ns; nsec: nanoseconds, added to t
///   t_min, t_100us       time in minutes, or in 0.1 ms
///   t_utc                calendar time (CalendarSeconds)
///   time_of_day          time of day (SecondsIntoDay)
///   date_utc             date (DateSeconds), added to t; the year is first. The day is first in
///                        date_utc_dmy, the month in date_utc_mdy; date_gps, date_gps_dmy and
///                        date_gps_mdy are in GPS time
///   week, skip           GPS week, counted from that of the first row; a column that is not used
///   NAME, -NAME          a quantity, with the opposite sign; NAME_rad: an angle in rad, not deg
///   lat_min, lat_sec     minutes and seconds, added to lat; the same for lon
///   lat_ns, lon_ew       letter of the hemisphere, the sign of lat and lon
///   lat_1e7, lat_ddmm    latitude in 1e-7 deg, and as ddmm.mmmm; the same for lon
///   h_mm, h_cm, h_ft     a length in another unit, also usft; the same for sigmas and coordinates
///   sigma_en             sigma_e and sigma_n
///   var_e, var_n, var_u  variances; their roots are the sigmas
///   undulation           height of the geoid, added to h
///   =TEXT, =TEXT|TEXT    only rows with this text are used; as first name, SplitMessage applies
///
/// Some quantities have several names: lat, east, x; lon, north, y; h, up, z; heading, yaw; and
/// vd, sigma_d, sigma_vd, which are -vu, sigma_u, sigma_vu.
using ColumnNames = std::vector<std::string>;

/// Returns whether the names contain a quantity, under any of its names and with any sign.
bool HasColumn(const ColumnNames& names, const std::string& quantity);

/// Returns the names as a list of YAML, such as "[t, fx, skip]".
std::string FormatColumnNames(const ColumnNames& names);

/// Throws InvalidInput, without a location, for a name of none of the quantities, for a quantity
/// that is named twice, and without a time.
void CheckColumnNames(const ColumnNames& names, const std::vector<std::string>& quantities);

/// Treatment of rows without any quantity after the time. Their fields are missing, empty, or a
/// word such as nan.
enum class EmptyRows { kError, kLeaveOut };

/// Reads a text file into a table with the columns time [s] and `quantities`. Lines before the
/// first row with a time and all columns are a header and ignored, as are lines that begin with #
/// or %. Columns after the last name and the values of columns named `skip` are ignored. Fields are
/// split by SplitFields. Throws InvalidInput naming file:line for a row with too few columns, and
/// for a value of a used column that is not a finite number. Throws InvalidInput if a quantity has
/// no column. Rows after the first max_rows are not read.
TextTable ReadNamedColumns(const std::filesystem::path& file, const ColumnNames& names,
                           const std::vector<std::string>& quantities,
                           std::size_t max_rows = SIZE_MAX, EmptyRows empty = EmptyRows::kError);

}  // namespace dn
