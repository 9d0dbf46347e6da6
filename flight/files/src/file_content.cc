#include <dn/error.h>
#include <dn/files/file_content.h>
#include <dn/geo/text_table.h>
#include <dn/geo/trajectory.h>
#include <dn/median.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <numbers>
#include <system_error>

#include "plausible_motion.h"
#include "trajectory_content.h"

namespace dn {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kRowsLookedAt = 4000;
// With this limit, a day at 200 Hz keeps some rows of every half minute.
constexpr std::size_t kMostSpacedRows = 50000;
constexpr double kMostSigmaM = 1000.0;
// Limit between GNSS receivers and inertial sensors: the former have at most this rate, the latter
// a higher one.
constexpr double kMostGnssHz = 25.0;
// Limits of a mean specific force of 1 g, including the motion of a flight.
constexpr double kLeastForce = 7.0, kMostForce = 14.0;
constexpr double kMostRmsRateRadps = 2.0;

constexpr std::array<std::size_t, 4> kGnssColumns{4, 7, 10, 13};

/// Seconds from the Unix epoch to the GPS epoch, and GPS time minus UTC.
constexpr double kUnixBeforeGps_s = 315964800.0;
constexpr double kLeapSeconds_s = 18.0;
// Least time that is taken for seconds since 1970, reached in September 2020; seconds since 1980
// reach it in September 2030.
constexpr double kLeastUnix_s = 1.6e9;

double TimeOffset(double t_s) {
  if (IsWeekSeconds(t_s) || t_s < 3e8 || t_s > 3e9) return 0.0;
  const double since_1970_s = t_s >= kLeastUnix_s ? kUnixBeforeGps_s - kLeapSeconds_s : 0.0;
  return since_1970_s + kWeekS * std::floor((t_s - since_1970_s) / kWeekS);
}

/// Returns the median time step of the rows.
double MedianTimeStep(const TextTable& table) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < table.rows(); ++i) {
    const double step = table.row(i)[0] - table.row(i - 1)[0];
    if (step > 0.0) steps.push_back(step);
  }
  return steps.empty() ? 0.0 : Median(steps);
}

template <class Test>
bool EveryRow(const TextTable& table, const Test& test) {
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (!test(table.row(i))) return false;
  }
  return true;
}

bool IsTime(double t_s) { return IsWeekSeconds(t_s) || TimeOffset(t_s) != 0.0; }

bool IsPairs(const TextTable& table) {
  if (table.columns != 8 && table.columns != 14) return false;
  return EveryRow(table, [](const double* row) {
    const double range_m = Eigen::Map<const Eigen::Vector3d>(row + 2).norm();
    return IsTime(row[0]) && IsTime(row[1]) && std::abs(row[0] - row[1]) < kWeekS &&
           range_m > 0.0 && row[1] > 10.0;
  });
}

bool ArePositive(const double* values, std::size_t count) {
  return std::all_of(values, values + count, [](double x) { return x > 0.0 && x < kMostSigmaM; });
}

/// Returns whether columns 2 to 4 can be latitude, longitude (deg or rad, in any order) and height
/// with a plausible speed.
bool AreCoordinates(const TextTable& table) {
  double lat = table.row(0)[1], lon = table.row(0)[2];
  return EveryRow(table, [&](const double* row) {
    const double limit =
        0.01 + 60.0 * files_internal::kMostSpeedMps / files_internal::kMetresPerDeg;
    const bool near = std::abs(row[1] - lat) < limit && std::abs(row[2] - lon) < limit;
    lat = row[1];
    lon = row[2];
    return near && std::abs(lat) <= 360.0 && std::abs(lon) <= 360.0 && std::abs(row[3]) < 2e4;
  });
}

bool IsGnss(const TextTable& table, double step_s) {
  if (std::find(kGnssColumns.begin(), kGnssColumns.end(), table.columns) == kGnssColumns.end() ||
      step_s * kMostGnssHz < 1.0 || !AreCoordinates(table)) {
    return false;
  }
  return EveryRow(table, [&](const double* row) {
    return table.columns == 4 || ArePositive(row + table.columns - 3, 3);
  });
}

void DescribeGnss(const TextTable& table, FileContent* content) {
  content->kind = FileKind::kGnss;
  content->has_velocity = table.columns >= 10;
  content->has_sigma = table.columns == 7 || table.columns == 13;
  // In one of the two formats with 13 columns the sigmas come first, in the other the velocity.
  const bool sigma_first =
      EveryRow(table, [](const double* row) { return ArePositive(row + 4, 3); });
  const bool sigma_later = table.columns == 13 && EveryRow(table, [](const double* row) {
                             return ArePositive(row + 7, 3);
                           });
  if (table.columns == 13 && sigma_later && !sigma_first) {
    content->gnss_format = GnssFormat::kObGins;
  }
}

bool DescribeImu(const TextTable& table, double step_s, FileContent* content) {
  if ((table.columns != 7 && table.columns != 8) || !(step_s > 0.0) || step_s > 1.0) return false;
  double force = 0.0, rate2 = 0.0;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    rate2 += Eigen::Map<const Eigen::Vector3d>(table.row(i) + 1).squaredNorm();
    force += Eigen::Map<const Eigen::Vector3d>(table.row(i) + 4).norm();
  }
  force /= static_cast<double>(table.rows());
  double rms_rate = std::sqrt(rate2 / static_cast<double>(table.rows()));
  const auto is_gravity = [](double mps2) { return mps2 > kLeastForce && mps2 < kMostForce; };
  if (is_gravity(force)) {
    content->imu_format = ImuFormat::kOdyn;
  } else if (is_gravity(9.8 * force)) {
    content->forces_in_g = true;
  } else if (is_gravity(force / step_s)) {
    content->imu_format = ImuFormat::kIncrements;
    rms_rate /= step_s;
  } else {
    return false;
  }
  content->kind = FileKind::kImu;
  content->rates_in_deg = rms_rate > kMostRmsRateRadps;
  return true;
}

std::string Beginning(const fs::path& file, std::size_t bytes) {
  std::ifstream in(file, std::ios::binary);
  std::string text(bytes, '\0');
  in.read(text.data(), static_cast<std::streamsize>(bytes));
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(in.gcount(), 0)));
  return text;
}

/// Returns whether the beginning of a file looks like binary data.
bool IsBinary(const std::string& beginning) {
  return beginning.find('\0') != std::string::npos ||
         std::count_if(beginning.begin(), beginning.end(), [](char c) {
           return static_cast<unsigned char>(c) >= 0x80;
         }) > static_cast<std::ptrdiff_t>(beginning.size() / 10);
}

double LittleEndianDouble(const std::string& bytes, std::size_t index) {
  std::uint64_t bits = 0;
  for (std::size_t i = 8; i-- > 0;) {
    bits = (bits << 8) | static_cast<unsigned char>(bytes[8 * index + i]);
  }
  return std::bit_cast<double>(bits);
}

void DescribeBinary(const std::string& beginning, std::uintmax_t size, FileContent* content) {
  constexpr std::size_t kSbetValues = 17, kSmrmsgValues = 10;
  const auto value = [&](std::size_t index) { return LittleEndianDouble(beginning, index); };
  const auto small = [&](std::size_t index, double limit) {
    return std::abs(value(index)) <= limit;
  };
  content->why = "binary, but neither an SBET nor an smrmsg file";
  if (beginning.size() < 8 * kSbetValues) return;
  constexpr double kPi = std::numbers::pi;
  if (size % (8 * kSbetValues) == 0 && IsWeekSeconds(value(0)) && small(1, kPi / 2) &&
      small(2, 2 * kPi) && small(3, 1e5) && small(7, kPi) && small(8, kPi)) {
    content->kind = FileKind::kTrajectory;
  } else if (size % (8 * kSmrmsgValues) == 0 && IsWeekSeconds(value(0)) && small(1, 1e4)) {
    content->kind = FileKind::kSmrmsg;
  }
  const std::string extension = content->file.extension().string();
  if (content->kind != FileKind::kUnknown && extension != ".out" && extension != ".sbet") {
    content->kind = FileKind::kUnknown;
    content->why = "an SBET or smrmsg file, whose name must end in .out";
  }
}

void AppendRow(const TextTable& from, std::size_t row, TextTable* to) {
  to->columns = from.columns;
  to->values.insert(to->values.end(), from.row(row), from.row(row) + from.columns);
  to->lines.push_back(from.lines[row]);
}

TextTable EverySecondRow(const TextTable& table) {
  TextTable kept;
  kept.file = table.file;
  for (std::size_t i = 0; i < table.rows(); i += 2) AppendRow(table, i, &kept);
  return kept;
}

/// Returns rows of the whole file, evenly spaced if the file has more than kMostSpacedRows.
TextTable SpacedRows(const fs::path& file) {
  TextTableReader reader(file, {});
  TextTable rows;
  rows.file = file;
  std::size_t step = 1, skipped = 0;
  while (reader.Next(kRowsLookedAt)) {
    for (std::size_t i = 0; i < reader.table().rows(); ++i) {
      if (skipped > 0) {
        --skipped;
        continue;
      }
      AppendRow(reader.table(), i, &rows);
      if (rows.rows() >= kMostSpacedRows) {
        rows = EverySecondRow(rows);
        step *= 2;
      }
      skipped = step - 1;
    }
  }
  return rows;
}

void DescribeText(FileContent* content) {
  const TextTable table = ReadTextTable(content->file, {}, '#', kRowsLookedAt);
  content->columns = table.columns;
  content->time_offset_s = TimeOffset(table.row(0)[0]);
  const double step_s = MedianTimeStep(table);
  const auto take_trajectory = [content](const TextTable& rows) {
    content->trajectory = files_internal::FindTrajectoryColumns(rows);
    if (content->trajectory) content->kind = FileKind::kTrajectory;
    return content->trajectory.has_value();
  };
  if (table.columns == 8 && take_trajectory(table)) return;
  if (IsPairs(table)) {
    content->kind = FileKind::kPairs;
  } else if (table.columns >= 4 && IsGnss(table, step_s)) {
    DescribeGnss(table, content);
  } else if (!take_trajectory(table) && !DescribeImu(table, step_s, content) &&
             // The first rows may be at rest on the ground, without a course.
             !take_trajectory(SpacedRows(content->file))) {
    content->why = std::to_string(table.columns) + " columns, which match no known kind of file";
    if (table.columns >= 4 && files_internal::FindCoordinateSystem(table) == "utm:") {
      content->why += "; for GNSS positions in a grid, set gnss.file and gnss.crs";
    }
  }
}

bool IsOwnFile(const fs::path& file) {
  const std::string stem = file.stem().string();
  static const std::array<const char*, 6> names{"trajectory_sigma", "trajectory_covariance",
                                                "biases",           "gnss_errors",
                                                "reference",        "initial_guess"};
  const std::string extension = file.extension().string();
  return stem.starts_with('.') || extension == ".yaml" || extension == ".json" ||
         extension == ".html" || extension == ".svg" || extension == ".md" ||
         std::find(names.begin(), names.end(), stem) != names.end();
}

}  // namespace

FileContent InspectFile(const fs::path& file) {
  FileContent content;
  content.file = file;
  try {
    ExpectRegularFile(file);
    const std::string beginning = Beginning(file, 4096);
    if (beginning.empty()) {
      content.why = "empty";
    } else if (beginning.starts_with("LASF")) {
      content.kind = FileKind::kPointCloud;
    } else if (IsBinary(beginning)) {
      DescribeBinary(beginning, fs::file_size(file), &content);
    } else if (beginning.starts_with('$')) {
      content.kind = FileKind::kGnss;
      content.gnss_format = GnssFormat::kNmea;
    } else if (beginning.starts_with('%')) {
      content.kind = FileKind::kGnss;
      content.gnss_format = GnssFormat::kRtklib;
      content.has_sigma = true;
    } else {
      DescribeText(&content);
    }
  } catch (const std::exception& error) {
    content.kind = FileKind::kUnknown;
    content.why = error.what();
  }
  return content;
}

std::vector<FileContent> InspectFolder(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    std::error_code none;  // a link may lead nowhere; InspectFile says so
    if (!entry.is_directory(none) && !IsOwnFile(entry.path())) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<FileContent> contents;
  for (const fs::path& file : files) contents.push_back(InspectFile(file));
  return contents;
}

}  // namespace dn
