#include <dn/geo/text_table.h>

#include "gnss_readers.h"

namespace dn::gnss_internal {
namespace {

/// Converts standard deviations in the order north, east, down to a covariance in the order east,
/// north, up.
Eigen::Matrix3d NedSigmasToCovariance(const double* ned, const std::string& what,
                                      const FileLocation& where) {
  CheckSigmas(Eigen::Vector3d(ned), what, "NED", where);
  return EnuSigmasToCovariance({ned[1], ned[0], ned[2]}, what, where);
}

}  // namespace

GnssData ReadObGinsGnss(const std::filesystem::path& file, double time_offset_s,
                        const GnssColumns& columns) {
  TextTable table = ReadTextTable(file, {7, 13});
  const bool has_velocity = table.columns == 13;
  std::vector<std::size_t> keep;
  GnssData data;
  data.repeated_rows_dropped = ContinueAndCheckTimes(table, keep, time_offset_s);
  data.epochs.reserve(keep.size());
  for (const std::size_t i : keep) {
    const double* row = table.row(i);
    const FileLocation where{file.string(), table.lines[i], 0};
    GnssEpoch epoch;
    epoch.t_s = row[0];
    epoch.antenna = columns.position.Read(row + 1, where);
    epoch.line = table.lines[i];
    const double* sigma_ned = row + (has_velocity ? 7 : 4);
    if (!Eigen::Map<const Eigen::Vector3d>(sigma_ned).isZero(0.0)) {
      epoch.covariance_enu_m2 = NedSigmasToCovariance(sigma_ned, "position", where);
    }
    if (has_velocity && !Eigen::Map<const Eigen::Vector3d>(row + 10).isZero(0.0)) {
      epoch.velocity_enu_mps = Eigen::Vector3d(row[5], row[4], -row[6]);
      CheckVelocity(*epoch.velocity_enu_mps, where);
      epoch.velocity_covariance_enu = NedSigmasToCovariance(row + 10, "velocity", where);
    }
    TurnToTrueNorth(columns, &epoch);
    data.epochs.push_back(epoch);
  }
  return data;
}

}  // namespace dn::gnss_internal
