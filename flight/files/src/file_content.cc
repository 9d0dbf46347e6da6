#include <dn/error.h>
#include <dn/files/file_content.h>
#include <dn/geo/read_file.h>
#include <dn/geo/text_table.h>
#include <dn/lidar/beam.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <system_error>

#include "calendar_text.h"
#include "content_fit.h"
#include "gnss_content.h"
#include "imu_choices.h"
#include "imu_content.h"
#include "known_files.h"
#include "lower_case.h"
#include "message_log.h"
#include "picked_columns.h"
#include "spaced_rows.h"
#include "trajectory_content.h"
#include "trajectory_fit.h"

namespace dn {
namespace {

namespace fs = std::filesystem;
using files_internal::ContentFit;
using files_internal::IsTime;
using files_internal::TextSample;

constexpr std::size_t kRowsLookedAt = 4000;
constexpr std::size_t kBytesLookedAt = std::size_t{1} << 16;
// A log at 200 Hz has this many bytes in 10 s or more, with a position in each second.
constexpr std::size_t kMessageBytesLookedAt = std::size_t{1} << 20;

bool AreBeams(const double* two) {
  return std::all_of(two, two + 2, [](double value) {
    return value == std::floor(value) && value >= kNoBeam && value < kMostBeams;
  });
}

bool IsPairs(const TextTable& table) {
  const bool with_beams = table.columns == 10 || table.columns == 16;
  if (table.columns != 8 && table.columns != 14 && !with_beams) return false;
  if (files_internal::IsWeek(table, 0) || files_internal::IsWeek(table, 1)) return false;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double* row = table.row(i);
    const double range_m = Eigen::Map<const Eigen::Vector3d>(row + 2).norm();
    const bool fits = IsTime(row[0]) && IsTime(row[1]) && std::abs(row[0] - row[1]) < kWeekS &&
                      range_m > 0.0 && row[1] > 10.0 &&
                      (!with_beams || AreBeams(row + table.columns - 2));
    if (!fits) return false;
  }
  return true;
}

double LittleEndianDouble(const std::string& bytes, std::size_t index) {
  std::uint64_t bits = 0;
  for (std::size_t i = 8; i-- > 0;) {
    bits = (bits << 8) | static_cast<unsigned char>(bytes[8 * index + i]);
  }
  return std::bit_cast<double>(bits);
}

/// Returns whether the first values of the records are times that increase.
bool TimesIncrease(const std::string& bytes, std::size_t values) {
  constexpr double kLongestStepS = 3600.0;
  const std::size_t records = bytes.size() / 8 / values;
  for (std::size_t i = 1; i < records; ++i) {
    const double step_s =
        LittleEndianDouble(bytes, i * values) - LittleEndianDouble(bytes, (i - 1) * values);
    if (!(step_s > 0.0 && step_s < kLongestStepS)) return false;
  }
  return true;
}

void DescribeBinary(const std::string& beginning, std::uintmax_t size, FileContent* content) {
  constexpr std::size_t kSbetValues = 17, kSmrmsgValues = 10;
  const auto value = [&](std::size_t index) { return LittleEndianDouble(beginning, index); };
  const auto small = [&](std::size_t index, double limit) {
    return std::abs(value(index)) <= limit;
  };
  content->why = "binary, but neither an SBET nor an smrmsg file";
  if (beginning.size() < 8 * kSmrmsgValues) return;
  constexpr double kPi = std::numbers::pi;
  if (size % (8 * kSbetValues) == 0 && IsWeekSeconds(value(0)) && small(1, kPi / 2) &&
      small(2, 2 * kPi) && small(3, 1e5) && small(7, kPi) && small(8, kPi) &&
      TimesIncrease(beginning, kSbetValues)) {
    content->kind = FileKind::kTrajectory;
  } else if (size % (8 * kSmrmsgValues) == 0 && IsWeekSeconds(value(0)) && small(1, 1e4) &&
             TimesIncrease(beginning, kSmrmsgValues)) {
    content->kind = FileKind::kSmrmsg;
  }
  if (content->kind != FileKind::kUnknown) content->why.clear();
}

const char* KindWords(FileKind kind) {
  switch (kind) {
    case FileKind::kImu:
      return "inertial data";
    case FileKind::kGnss:
      return "GNSS positions";
    default:
      return "a trajectory";
  }
}

/// Says to which kinds a text is nearest and what it lacks, without a clear kind.
std::string Reason(std::vector<ContentFit> fits, const TextTable& table) {
  std::erase_if(fits, [](const ContentFit& fit) { return fit.fits(); });
  std::stable_sort(fits.begin(), fits.end(),
                   [](const ContentFit& a, const ContentFit& b) { return a.score > b.score; });
  std::string why = std::to_string(table.columns) + " columns, which match no known kind of file";
  const char* separator = "; nearest to ";
  for (std::size_t i = 0; i < std::min<std::size_t>(2, fits.size()); ++i) {
    why += separator + std::string(KindWords(fits[i].content.kind)) + ", but " + fits[i].failed;
    separator = "; then to ";
  }
  const bool said = why.find("gnss.crs") != why.npos;
  if (!said && table.columns >= 4 && files_internal::FindCoordinateSystem(table) == "utm:") {
    why += "; for GNSS positions in a grid, set gnss.file and gnss.crs";
  }
  return why;
}

/// Returns the sample of a file whose beginning is at rest on the ground, without a course.
TextSample SpacedSample(const fs::path& file) {
  TextSample sample;
  sample.table = files_internal::ReadSpacedRows(file, kRowsLookedAt);
  return sample;
}

/// Returns the GNSS positions in a file of inertial data, if there are any. Notes positions that
/// are not used.
std::optional<FileContent> GnssBesideImu(FileContent* imu) {
  if (imu->kind != FileKind::kImu || IsBinaryFile(imu->file)) return std::nullopt;
  const TextSample sample = files_internal::ReadTextSample(imu->file, kRowsLookedAt);
  const auto meanings = files_internal::FindMeanings(sample);
  const auto time = files_internal::FindImuTime(sample);
  if (!time || !files_internal::NamesInertialData(meanings)) return std::nullopt;
  std::optional<FileContent> gnss = files_internal::FindGnssBesideImu(sample, *time);
  if (gnss) {
    gnss->file = imu->file;
  } else if (files_internal::FindColumn(meanings, "lat") &&
             files_internal::FindColumn(meanings, "lon")) {
    imu->why += imu->why.empty() ? "" : "; ";
    imu->why +=
        "its latitude and longitude are not used: they are not positions of a receiver at "
        "25 Hz or less";
  }
  return gnss;
}

void DescribeText(FileContent* content) {
  const TextSample sample = files_internal::ReadTextSample(content->file, kRowsLookedAt);
  const auto take = [&](const ContentFit& fit) {
    const fs::path file = content->file;
    *content = fit.content;
    content->file = file;
    const std::string note = files_internal::DateNote(sample);
    content->why += (content->why.empty() || note.empty() ? "" : "; ") + note;
  };
  const ContentFit trajectory = files_internal::FitTrajectory(sample);
  const ContentFit gnss = files_internal::FitGnss(sample);
  const ContentFit imu = files_internal::FitImu(sample);
  const bool only_position = gnss.score < 0.9;
  const std::vector<files_internal::ColumnMeaning> meanings = files_internal::FindMeanings(sample);
  const bool may_be_imu = imu.fits() && !files_internal::NamesPosition(sample);
  // Without names, small angles may look like the sigmas of positions.
  const bool has_heading = files_internal::FindColumn(meanings, "heading").has_value();
  const bool certain =
      trajectory.fits() && (trajectory.content.trajectory->has_quaternion() || has_heading);
  if (certain) return take(trajectory);
  if (files_internal::NamesInertialData(meanings)) {
    if (imu.fits()) return take(imu);
    content->why = "a header of inertial data, but " + imu.failed;
    return;
  }
  if (gnss.fits() && !only_position && !(IsPairs(sample.table) && gnss.content.columns.empty())) {
    return take(gnss);
  }
  if (!sample.needs_names && IsPairs(sample.table)) {
    content->kind = FileKind::kPairs;
    content->time_offset_s = files_internal::FindTimeOffset(sample.table.row(0)[0]);
    return;
  }
  if (trajectory.fits()) return take(trajectory);
  if (may_be_imu) return take(imu);
  if (!sample.needs_names) {
    const ContentFit later = files_internal::FitTrajectory(SpacedSample(content->file));
    if (later.fits()) return take(later);
  }
  if (gnss.fits()) return take(gnss);
  content->why = files_internal::SingleSensorReason(sample);
  if (!content->why.empty()) return;
  content->why = Reason({imu, gnss, trajectory}, sample.table);
}

bool IsOwnFile(const fs::path& file) {
  const std::string stem = file.stem().string();
  static const std::array<const char*, 6> names{"trajectory_sigma", "trajectory_covariance",
                                                "biases",           "gnss_errors",
                                                "reference",        "initial_guess"};
  const std::string extension = files_internal::LowerCase(file.extension().string());
  return stem.starts_with('.') || extension == ".yaml" || extension == ".json" ||
         extension == ".html" || extension == ".svg" || extension == ".md" ||
         std::find(names.begin(), names.end(), stem) != names.end();
}

/// Names the sentences of a log without positions.
std::string SentenceReason(const std::string& beginning) {
  const std::string type = beginning.substr(1, beginning.find_first_of(",*\r\n") - 1);
  if (type.starts_with("VN") && type.size() == 5) {
    return "sentences of type " + type +
           ", an ASCII log of VectorNav: give a CSV file with the time, accelerations and rates of "
           "each row, exported from its binary log";
  }
  if (type == "POS" || type == "SAT") {
    return "the status file of RTKLIB; the solution is the .pos file";
  }
  return "sentences of type " + type.substr(0, 10) + ", but no GGA with positions";
}

void DescribeGnssLog(GnssFormat format, FileContent* content) {
  content->kind = FileKind::kGnss;
  content->gnss_format = format;
  content->has_sigma = format == GnssFormat::kRtklib;
}

void DescribeFile(FileContent* content) {
  const std::string beginning = ReadBeginning(content->file, kBytesLookedAt);
  const std::string sample = beginning.substr(0, 4096);
  if (beginning.empty()) {
    content->why = "empty";
  } else if (beginning.starts_with("LASF")) {
    content->kind = FileKind::kPointCloud;
  } else if (std::string known = files_internal::KnownFileReason(beginning); !known.empty()) {
    content->why = std::move(known);
  } else if (IsUtf16(sample)) {
    content->why = "text in UTF-16; save it as UTF-8 or ASCII";
  } else if (IsBinary(sample)) {
    DescribeBinary(beginning, fs::file_size(content->file), content);
  } else if (const auto format = files_internal::FindGnssFormat(beginning)) {
    DescribeGnssLog(*format, content);
  } else if (beginning.starts_with('$')) {
    content->why = SentenceReason(beginning);
  } else {
    DescribeText(content);
  }
}

/// Returns the contents of a log with messages; empty for other files. NMEA sentences in it are
/// used if it has no other positions.
std::vector<FileContent> InspectMessages(const fs::path& file) {
  const std::string beginning = ReadBeginning(file, kMessageBytesLookedAt);
  std::vector<FileContent> contents = files_internal::FindMessages(file, beginning);
  const bool has_gnss = std::any_of(contents.begin(), contents.end(), [](const FileContent& each) {
    return each.kind == FileKind::kGnss;
  });
  const auto format = files_internal::FindGnssFormat(beginning);
  if (!contents.empty() && !has_gnss && format) {
    contents.emplace_back().file = file;
    DescribeGnssLog(*format, &contents.back());
  }
  return contents;
}

/// Returns the contents of a file, at least one.
std::vector<FileContent> InspectParts(const fs::path& file) {
  FileContent content;
  content.file = file;
  try {
    ExpectRegularFile(file);
    std::vector<FileContent> messages = InspectMessages(file);
    if (!messages.empty()) return messages;
    DescribeFile(&content);
    if (auto gnss = GnssBesideImu(&content)) return {content, *gnss};
  } catch (const std::exception& error) {
    content = FileContent();
    content.file = file;
    content.why = error.what();
  }
  return {content};
}

}  // namespace

double files_internal::FindTimeOffset(double t_s) {
  // Seconds from the Unix epoch to the GPS epoch, and GPS time minus UTC.
  constexpr double kUnixBeforeGps_s = 315964800.0, kLeapSeconds_s = 18.0;
  // Least time that is taken for seconds since 1970, reached in September 2020; seconds since 1980
  // reach it in September 2030.
  constexpr double kLeastUnix_s = 1.6e9;
  if (IsWeekSeconds(t_s) || t_s < 3e8 || t_s > 3e9) return 0.0;
  const double since_1970_s = t_s >= kLeastUnix_s ? kUnixBeforeGps_s - kLeapSeconds_s : 0.0;
  return since_1970_s + kWeekS * std::floor((t_s - since_1970_s) / kWeekS);
}

FileContent InspectFile(const fs::path& file) { return InspectParts(file).front(); }

std::vector<FileContent> InspectFolder(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    std::error_code none;  // a link may lead nowhere; InspectFile says so
    if (!entry.is_directory(none) && !IsOwnFile(entry.path())) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<FileContent> contents;
  for (const fs::path& file : files) {
    for (FileContent& content : InspectParts(file)) contents.push_back(std::move(content));
  }
  return contents;
}

}  // namespace dn
