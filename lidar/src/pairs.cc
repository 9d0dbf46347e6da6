#include <dn/error.h>
#include <dn/geo/text_table.h>
#include <dn/lidar/pairs.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "beam_number.h"
#include "glob.h"
#include "pair_rows.h"
#include "repeated_pairs.h"
#include "text_rows.h"

namespace dn {
namespace {

using lidar_internal::AppendInteger;
using lidar_internal::AppendNumbers;
using lidar_internal::AppendUpperTriangle;
using lidar_internal::FromUpperTriangle;

constexpr std::size_t kPairColumns = lidar_internal::kEndColumns;
constexpr std::size_t kPairColumnsWithCovariance = 14;
constexpr std::size_t kBeamColumns = 2;
constexpr double kLeastVarianceM2 = 1e-12;
constexpr double kMostVarianceM2 = 1e12;

const Eigen::Matrix3d& CheckedCovariance(const Eigen::Matrix3d& M_m2, const FileLocation& where) {
  const Eigen::LLT<Eigen::Matrix3d> llt(M_m2);
  if (llt.info() != Eigen::Success || !llt.matrixLLT().allFinite()) {
    throw InvalidInput(
        "covariance of the pair (upper triangle xx, xy, xz, yy, yz, zz in m^2) is not positive "
        "definite",
        where);
  }
  const Eigen::Vector3d variances_m2 = M_m2.diagonal();
  if (variances_m2.minCoeff() < kLeastVarianceM2 || variances_m2.maxCoeff() > kMostVarianceM2) {
    throw InvalidInput(
        "covariance of the pair: every variance must lie between 1e-12 and 1e12 m^2; is it in m^2?",
        where);
  }
  return M_m2;
}

bool HasBeams(std::size_t columns) {
  return columns == kPairColumns + kBeamColumns ||
         columns == kPairColumnsWithCovariance + kBeamColumns;
}

LidarPair ToPair(const double* row, std::size_t columns, int file, const FileLocation& where) {
  LidarPair pair = lidar_internal::ReadEnds(row, file, where);
  if (columns >= kPairColumnsWithCovariance) {
    pair.covariance_m2 = CheckedCovariance(FromUpperTriangle(row + kPairColumns), where);
  }
  if (HasBeams(columns)) {
    pair.beam_i = lidar_internal::CheckedPairBeam(row[columns - 2], where);
    pair.beam_j = lidar_internal::CheckedPairBeam(row[columns - 1], where);
  }
  return pair;
}

/// Returns the least reliable origin that the comment lines of a file state. They may be anywhere,
/// because files may be joined.
VectorOrigin ReadOrigin(const std::filesystem::path& path) {
  VectorOrigin weakest;
  LineReader lines(path);
  for (std::string_view line; lines.Next(&line);) {
    if (!line.starts_with('#')) continue;
    try {
      if (const auto origin = ParseOriginLine(line)) weakest = Weaker(weakest, *origin);
    } catch (const InvalidInput& e) {
      throw InvalidInput(e.what(), {path.string(), lines.line(), 0});
    }
  }
  return weakest;
}

void AppendFile(const std::filesystem::path& path, double time_offset_s, PairData& data) {
  const int file = static_cast<int>(data.files.size());
  data.files.push_back(path);
  data.origins.push_back(ReadOrigin(path));
  lidar_internal::ForEachPairRow(
      path,
      {kPairColumns, kPairColumns + kBeamColumns, kPairColumnsWithCovariance,
       kPairColumnsWithCovariance + kBeamColumns},
      time_offset_s, [&](const double* row, std::size_t columns, const FileLocation& where) {
        data.pairs.push_back(ToPair(row, columns, file, where));
      });
}

}  // namespace

std::vector<std::filesystem::path> FindPairFiles(const std::filesystem::path& folder,
                                                 const std::vector<std::string>& patterns) {
  std::vector<std::filesystem::path> files;
  for (const std::string& pattern : patterns) {
    const std::vector<std::filesystem::path> found = lidar_internal::Glob(folder, pattern);
    if (found.empty()) {
      throw InvalidInput("no pair file matches '" + pattern + "' in " + folder.string());
    }
    files.insert(files.end(), found.begin(), found.end());
  }
  std::sort(files.begin(), files.end());
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

PairData ReadPairs(const std::filesystem::path& folder, const std::vector<std::string>& patterns,
                   double time_offset_s) {
  PairData data;
  for (const std::filesystem::path& file : FindPairFiles(folder, patterns))
    AppendFile(file, time_offset_s, data);
  if (data.pairs.empty()) {
    throw InvalidInput("no lidar pair in " + folder.string() + ": no file pattern is given");
  }
  data.repeated_pairs_dropped = lidar_internal::DropRepeats(
      data.pairs, [](const LidarPair& pair) -> const LidarPair& { return pair; });
  return data;
}

std::string FormatPairs(const std::vector<LidarPair>& pairs, const VectorOrigin& origin) {
  std::string text = FormatOriginLine(origin);
  std::string line;
  const bool with_beams = std::any_of(pairs.begin(), pairs.end(),
                                      [](const LidarPair& pair) { return pair.has_beams(); });
  for (const LidarPair& pair : pairs) {
    line.clear();
    AppendNumbers(&pair.t_i_s, 1, line);
    AppendNumbers(&pair.t_j_s, 1, line);
    AppendNumbers(pair.u_i_s.data(), 3, line);
    AppendNumbers(pair.u_j_s.data(), 3, line);
    if (pair.covariance_m2) AppendUpperTriangle(*pair.covariance_m2, line);
    if (with_beams) {
      AppendInteger(pair.beam_i, line);
      AppendInteger(pair.beam_j, line);
    }
    text += line;
    text += '\n';
  }
  return text;
}

double MeanRange(const std::vector<LidarPair>& pairs) {
  double mean_m = 0.0;
  for (const LidarPair& pair : pairs) {
    mean_m += (pair.u_i_s.norm() + pair.u_j_s.norm()) / (2.0 * static_cast<double>(pairs.size()));
  }
  return mean_m;
}

}  // namespace dn
