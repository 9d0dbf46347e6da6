#include <dn/error.h>
#include <dn/geo/text_table.h>
#include <dn/gnss/changed_positions.h>

#include <utility>

#include "gnss_readers.h"

namespace dn::gnss_internal {
namespace {

/// Columns at which the optional triples of a row begin; 0: the row does not have the triple.
struct Layout {
  std::size_t sigma, velocity, velocity_sigma;
};

Layout RowLayout(std::size_t columns) {
  switch (columns) {
    case 7:
      return {4, 0, 0};
    case 10:
      return {0, 4, 7};
    case 13:
      return {4, 7, 10};
    default:
      return {0, 0, 0};
  }
}

/// Returns position, sigma, velocity and its sigma, as far as the names have them. A velocity needs
/// its sigma.
std::vector<std::string> NamedQuantities(const ColumnNames& names) {
  const std::vector<std::string>& all = GnssQuantities();
  const auto has = [&](std::size_t triple) { return HasColumn(names, all[3 * triple]); };
  std::vector<std::string> quantities;
  for (const std::size_t triple : {0, 1, 2, 3}) {
    const bool velocity = triple >= 2;
    if (triple > 0 && !(velocity ? has(2) && has(3) : has(triple))) continue;
    quantities.insert(quantities.end(), all.begin() + static_cast<std::ptrdiff_t>(3 * triple),
                      all.begin() + static_cast<std::ptrdiff_t>(3 * triple + 3));
  }
  return quantities;
}

TextTable ReadColumns(const std::filesystem::path& file, const GnssColumns& columns) {
  if (columns.names.empty()) return ReadTextTable(file, {4, 7, 10, 13});
  return ReadNamedColumns(file, columns.names, NamedQuantities(columns.names), SIZE_MAX,
                          columns.only_changed ? EmptyRows::kLeaveOut : EmptyRows::kError);
}

/// Leaves out rows without a position and rows with that of the row before.
void KeepChangedPositions(TextTable* table, GnssData* data) {
  TextTable kept;
  kept.file = table->file;
  kept.columns = table->columns;
  const double* before = nullptr;
  long empty = 0, repeated = 0;
  for (std::size_t i = 0; i < table->rows(); ++i) {
    const double* row = table->row(i);
    const RowPosition position = ComparePosition(row + 1, before);
    if (position == RowPosition::kNone) ++empty;
    if (position == RowPosition::kRepeated) ++repeated;
    if (position != RowPosition::kNew) continue;
    before = row + 1;
    kept.values.insert(kept.values.end(), row, row + table->columns);
    kept.lines.push_back(table->lines[i]);
  }
  data->Count("gnss rows without a position, left out", empty);
  data->Count("gnss rows that repeat the position before, left out", repeated);
  if (kept.rows() == 0) throw InvalidInput("no row has a position", {table->file.string(), 0, 0});
  *table = std::move(kept);
}

}  // namespace

GnssData ReadOdynGnss(const std::filesystem::path& file, double time_offset_s,
                      const GnssColumns& columns) {
  TextTable table = ReadColumns(file, columns);
  GnssData data;
  if (columns.only_changed) KeepChangedPositions(&table, &data);
  const Layout layout = RowLayout(table.columns);
  std::vector<std::size_t> keep;
  data.repeated_rows_dropped = ContinueAndCheckTimes(table, keep, time_offset_s);
  data.epochs.reserve(keep.size());
  for (const std::size_t i : keep) {
    const double* row = table.row(i);
    const FileLocation where{file.string(), table.lines[i], 0};
    const auto triple = [row](std::size_t at) { return Eigen::Vector3d(row + at); };
    GnssEpoch epoch;
    epoch.t_s = row[0];
    epoch.antenna = columns.position.Read(row + 1, where);
    epoch.line = table.lines[i];
    if (layout.sigma > 0 && !triple(layout.sigma).isZero(0.0)) {
      epoch.covariance_enu_m2 = EnuSigmasToCovariance(triple(layout.sigma), "position", where);
    }
    if (layout.velocity > 0 && !triple(layout.velocity_sigma).isZero(0.0)) {
      epoch.velocity_enu_mps = triple(layout.velocity);
      CheckVelocity(*epoch.velocity_enu_mps, where);
      epoch.velocity_covariance_enu =
          EnuSigmasToCovariance(triple(layout.velocity_sigma), "velocity", where);
    }
    TurnToTrueNorth(columns, &epoch);
    data.epochs.push_back(epoch);
  }
  return data;
}

}  // namespace dn::gnss_internal
