#include <dn/error.h>
#include <dn/geo/accuracy_series.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/read_file.h>
#include <dn/geo/text_table.h>

#include <algorithm>
#include <string>

#include "little_endian_records.h"

namespace dn {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

constexpr std::size_t kSmrmsgColumns = 10;
constexpr geo_internal::RecordFormat<kSmrmsgColumns> kSmrmsg{
    "smrmsg",
    {"time", "rms of position north", "rms of position east", "rms of position down",
     "rms of velocity north", "rms of velocity east", "rms of velocity down", "rms of roll",
     "rms of pitch", "rms of heading"}};
constexpr double kRadPerArcMinute = kRadPerDeg / 60.0;

// Larger standard deviations carry no information on a trajectory.
constexpr double kMostM = 1e5;
constexpr double kMostRad = 100.0;

void ExpectUsable(const EpochAccuracy& epoch, const std::string& what, const FileLocation& where) {
  if (!(epoch.sigma_ned_m.minCoeff() > 0.0 && epoch.sigma_rph_rad.minCoeff() > 0.0)) {
    throw InvalidInput("a standard deviation" + what + " is not positive", where);
  }
  if (epoch.sigma_ned_m.maxCoeff() > kMostM || epoch.sigma_rph_rad.maxCoeff() > kMostRad) {
    throw InvalidInput("a standard deviation" + what + " exceeds 100 km or 100 rad", where);
  }
}

std::vector<EpochAccuracy> ReadText(const fs::path& file) {
  TextTable table = ReadTextTable(file, {kSmrmsgColumns});
  std::vector<std::size_t> keep;
  ContinueAndCheckTimes(table, keep);
  std::vector<EpochAccuracy> epochs;
  for (const std::size_t i : keep) {
    const double* row = table.row(i);
    epochs.push_back(
        {row[0], Vector3d(row[2], row[1], row[3]), Vector3d(row[7], row[8], row[9]) * kRadPerDeg});
    ExpectUsable(epochs.back(), "", {file.string(), table.lines[i], 0});
  }
  return epochs;
}

std::vector<EpochAccuracy> ReadSmrmsg(const fs::path& file) {
  const FileLocation where{file.string(), 0, 0};
  auto records = geo_internal::DecodeRecords(ReadWholeFile(file), kSmrmsg, where);
  geo_internal::MakeTimesContinuous(kSmrmsg, where, &records);
  std::vector<EpochAccuracy> epochs;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const geo_internal::Record<kSmrmsgColumns>& c = records[i];
    epochs.push_back(
        {c[0], Vector3d(c[1], c[2], c[3]), Vector3d(c[7], c[8], c[9]) * kRadPerArcMinute});
    ExpectUsable(epochs.back(), " of smrmsg " + geo_internal::RecordName(i), where);
  }
  return epochs;
}

}  // namespace

AccuracySeries::AccuracySeries(const fs::path& file)
    : file_(file), epochs_(IsBinaryFile(file) ? ReadSmrmsg(file) : ReadText(file)) {}

EpochAccuracy AccuracySeries::At(double t_s) const {
  const auto after =
      std::upper_bound(epochs_.begin(), epochs_.end(), t_s,
                       [](double t, const EpochAccuracy& epoch) { return t < epoch.t_s; });
  if (after == epochs_.begin() || t_s > epochs_.back().t_s) {
    throw InvalidInput("the epoch " + FormatDouble(t_s) +
                           " s lies outside the standard deviations of the trajectory (" +
                           FormatDouble(epochs_.front().t_s) + " s to " +
                           FormatDouble(epochs_.back().t_s) +
                           " s); give those of the same run, or remove the file",
                       FileLocation{file_.string(), 0, 0});
  }
  const EpochAccuracy& a = *(after - 1);
  const EpochAccuracy& b = after == epochs_.end() ? a : *after;
  const double s = b.t_s > a.t_s ? (t_s - a.t_s) / (b.t_s - a.t_s) : 0.0;
  return {t_s, (1.0 - s) * a.sigma_ned_m + s * b.sigma_ned_m,
          (1.0 - s) * a.sigma_rph_rad + s * b.sigma_rph_rad};
}

}  // namespace dn
