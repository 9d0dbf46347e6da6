#include <dn/error.h>
#include <dn/geo/text_table.h>
#include <dn/lidar/pairs.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "glob.h"

namespace dn {
namespace {

constexpr std::size_t kPlainColumns = 8;
constexpr std::size_t kColumnsWithCovariance = 14;

/// Symmetric matrix from its upper triangle xx, xy, xz, yy, yz, zz.
Eigen::Matrix3d FromUpperTriangle(const double* c) {
  Eigen::Matrix3d M;
  M << c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5];
  return M;
}

bool IsPositiveDefinite(const Eigen::Matrix3d& M) {
  const Eigen::LLT<Eigen::Matrix3d> llt(M);
  return llt.info() == Eigen::Success;
}

LidarPair ToPair(const double* row, std::size_t columns, int file, const FileLocation& where) {
  LidarPair pair;
  pair.t_i_s = row[0];
  pair.t_j_s = row[1];
  pair.u_i_s = Eigen::Vector3d(row[2], row[3], row[4]);
  pair.u_j_s = Eigen::Vector3d(row[5], row[6], row[7]);
  pair.file = file;
  pair.line = where.line;
  if (!(pair.u_i_s.squaredNorm() > 0.0) || !(pair.u_j_s.squaredNorm() > 0.0)) {
    throw InvalidInput("laser vector of zero length; remove the pair", where);
  }
  if (columns == kColumnsWithCovariance) {
    const Eigen::Matrix3d covariance = FromUpperTriangle(row + kPlainColumns);
    if (!IsPositiveDefinite(covariance)) {
      throw InvalidInput(
          "covariance of the pair (upper triangle xx, xy, xz, yy, yz, zz in m^2) is not positive "
          "definite",
          where);
    }
    pair.covariance_m2 = covariance;
  }
  return pair;
}

void AppendFile(const std::filesystem::path& path, PairData& data) {
  const TextTable table = ReadTextTable(path, {kPlainColumns, kColumnsWithCovariance});
  const int file = static_cast<int>(data.files.size());
  data.files.push_back(path);
  data.pairs.reserve(data.pairs.size() + table.rows());
  FileLocation where{path.string(), 0, 0};
  for (std::size_t i = 0; i < table.rows(); ++i) {
    where.line = table.lines[i];
    data.pairs.push_back(ToPair(table.row(i), table.columns, file, where));
  }
}

void AppendNumbers(const double* values, Eigen::Index count, std::string& line) {
  for (Eigen::Index i = 0; i < count; ++i) {
    if (!line.empty()) line += ", ";
    line += FormatDouble(values[i]);
  }
}

}  // namespace

std::vector<std::filesystem::path> FindPairFiles(const std::filesystem::path& folder,
                                                 const std::vector<std::string>& patterns) {
  std::vector<std::filesystem::path> files;
  for (const std::string& pattern : patterns) {
    const std::vector<std::filesystem::path> found = internal::Glob(folder, pattern);
    if (found.empty()) {
      throw InvalidInput("no pair file matches '" + pattern + "' in " + folder.string());
    }
    files.insert(files.end(), found.begin(), found.end());
  }
  std::sort(files.begin(), files.end());
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

PairData ReadPairs(const std::filesystem::path& folder, const std::vector<std::string>& patterns) {
  PairData data;
  for (const std::filesystem::path& file : FindPairFiles(folder, patterns)) AppendFile(file, data);
  if (data.pairs.empty()) {
    throw InvalidInput("no lidar pair in " + folder.string() + ": no pattern is given");
  }
  return data;
}

std::string FormatPairs(const std::vector<LidarPair>& pairs) {
  std::string text;
  std::string line;
  for (const LidarPair& pair : pairs) {
    line.clear();
    AppendNumbers(&pair.t_i_s, 1, line);
    AppendNumbers(&pair.t_j_s, 1, line);
    AppendNumbers(pair.u_i_s.data(), 3, line);
    AppendNumbers(pair.u_j_s.data(), 3, line);
    if (pair.covariance_m2) {
      const Eigen::Matrix3d& C = *pair.covariance_m2;
      const double upper[6] = {C(0, 0), C(0, 1), C(0, 2), C(1, 1), C(1, 2), C(2, 2)};
      AppendNumbers(upper, 6, line);
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
