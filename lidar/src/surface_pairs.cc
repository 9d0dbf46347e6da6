#include <dn/error.h>
#include <dn/geo/text_table.h>
#include <dn/lidar/surface_pairs.h>

#include "laser_vector.h"
#include "repeated_pairs.h"
#include "text_rows.h"

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kColumns = 12;
constexpr double kLeastSigmaM = 1e-6, kMostSigmaM = 1e3;

SurfacePair ToSurfacePair(const double* row, int file, const FileLocation& where) {
  SurfacePair pair;
  LidarPair& ends = pair.ends;
  ends.t_i_s = row[0];
  ends.t_j_s = row[1];
  ends.u_i_s = Vector3d(row[2], row[3], row[4]);
  ends.u_j_s = Vector3d(row[5], row[6], row[7]);
  ends.file = file;
  ends.line = where.line;
  for (const double t_s : {ends.t_i_s, ends.t_j_s}) {
    if (!IsWeekSeconds(t_s)) CheckWeekSeconds(t_s, where);
  }
  lidar_internal::CheckLaserVector(ends.u_i_s, where);
  lidar_internal::CheckLaserVector(ends.u_j_s, where);
  const Vector3d normal(row[8], row[9], row[10]);
  if (!(normal.norm() > 0.0)) {
    throw InvalidInput("the normal of the surface (columns 9 to 11) has no length", where);
  }
  pair.normal_m = normal.normalized();
  pair.sigma_m = row[11];
  if (!(pair.sigma_m >= kLeastSigmaM && pair.sigma_m <= kMostSigmaM)) {
    throw InvalidInput("sigma of the surface pair (column 12) must lie between 1e-6 and 1e3 m",
                       where);
  }
  return pair;
}

void AppendFile(const std::filesystem::path& path, double time_offset_s, SurfacePairData* data) {
  TextTable table = ReadTextTable(path, {kColumns});
  const int file = static_cast<int>(data->files.size());
  data->files.push_back(path);
  FileLocation where{path.string(), 0, 0};
  for (std::size_t i = 0; i < table.rows(); ++i) {
    where.line = table.lines[i];
    for (std::size_t c = 0; c < 2; ++c) table.values[i * table.columns + c] -= time_offset_s;
    data->pairs.push_back(ToSurfacePair(table.row(i), file, where));
  }
}

}  // namespace

SurfacePairData ReadSurfacePairs(const std::filesystem::path& folder,
                                 const std::vector<std::string>& patterns, double time_offset_s) {
  SurfacePairData data;
  for (const std::filesystem::path& file : FindPairFiles(folder, patterns)) {
    AppendFile(file, time_offset_s, &data);
  }
  data.repeated_pairs_dropped = lidar_internal::DropRepeats(
      data.pairs, [](const SurfacePair& pair) -> const LidarPair& { return pair.ends; });
  return data;
}

std::string FormatSurfacePairs(const std::vector<SurfacePair>& pairs, const VectorOrigin& origin) {
  std::string text = FormatOriginLine(origin);
  for (const SurfacePair& pair : pairs) {
    std::string line;
    lidar_internal::AppendNumbers(&pair.ends.t_i_s, 1, line);
    lidar_internal::AppendNumbers(&pair.ends.t_j_s, 1, line);
    lidar_internal::AppendNumbers(pair.ends.u_i_s.data(), 3, line);
    lidar_internal::AppendNumbers(pair.ends.u_j_s.data(), 3, line);
    lidar_internal::AppendNumbers(pair.normal_m.data(), 3, line);
    lidar_internal::AppendNumbers(&pair.sigma_m, 1, line);
    text += line + '\n';
  }
  return text;
}

}  // namespace dn
