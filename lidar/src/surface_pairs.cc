#include <dn/error.h>
#include <dn/lidar/surface_pairs.h>

#include "pair_rows.h"
#include "repeated_pairs.h"
#include "text_rows.h"

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kColumns = lidar_internal::kEndColumns + 4;
constexpr double kLeastSigmaM = 1e-6, kMostSigmaM = 1e3;

SurfacePair ToSurfacePair(const double* row, int file, const FileLocation& where) {
  SurfacePair pair;
  pair.ends = lidar_internal::ReadEnds(row, file, where);
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
  const int file = static_cast<int>(data->files.size());
  data->files.push_back(path);
  lidar_internal::ForEachPairRow(path, {kColumns}, time_offset_s,
                                 [&](const double* row, std::size_t, const FileLocation& where) {
                                   data->pairs.push_back(ToSurfacePair(row, file, where));
                                 });
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
