#include "strip_text.h"

#include <dn/geo/week_seconds.h>

#include "beam_number.h"
#include "chunk_points.h"
#include "laser_vector.h"
#include "text_rows.h"

namespace dn::lidar_internal {
namespace {

constexpr std::size_t kStripColumns = 7;
constexpr std::size_t kStripColumnsWithCovariance = 13;
// Coordinates of all systems in use are smaller than this.
constexpr double kMostCoordinateM = 3e7;

bool HasBeam(std::size_t columns) {
  return columns == kStripColumns + 1 || columns == kStripColumnsWithCovariance + 1;
}

Eigen::Vector3d Coordinates(const double* row, const FileLocation& where) {
  Eigen::Vector3d p_c(row[1], row[2], row[3]);
  if (p_c.cwiseAbs().maxCoeff() <= kMostCoordinateM) return p_c;
  throw InvalidInput("a coordinate exceeds 3e7 m: is it in millimetres? Divide it by 1000", where);
}

}  // namespace

StripTextReader::StripTextReader(const std::filesystem::path& file)
    : table_(file, {kStripColumns, kStripColumns + 1, kStripColumnsWithCovariance,
                    kStripColumnsWithCovariance + 1}) {}

bool StripTextReader::Next(StripCloud* chunk) {
  chunk->Clear();
  if (!table_.Next(kChunkPoints)) return false;
  const TextTable& table = table_.table();
  FileLocation where{table.file.string(), 0, 0};
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double* row = table.row(i);
    where.line = table.lines[i];
    CheckWeekSeconds(row[0], where);
    chunk->t_s.push_back(row[0]);
    chunk->p_c.push_back(Coordinates(row, where));
    chunk->u_s.emplace_back(row[4], row[5], row[6]);
    CheckLaserVector(chunk->u_s.back(), where);
    if (table.columns >= kStripColumnsWithCovariance) {
      chunk->covariance_c_m2.push_back(FromUpperTriangle(row + kStripColumns));
    }
    if (HasBeam(table.columns)) {
      chunk->beam.push_back(CheckedBeam(row[table.columns - 1], where));
    }
  }
  return true;
}

std::unique_ptr<StripWriter> StripTextReader::MakeWriter(const std::filesystem::path& file,
                                                         const StripAdditions& additions) const {
  return std::make_unique<StripTextWriter>(file, additions.covariance);
}

void StripTextWriter::Append(const StripCloud& points) {
  std::string text;
  std::string line;
  for (std::size_t i = 0; i < points.size(); ++i) {
    line.clear();
    AppendNumbers(&points.t_s[i], 1, line);
    AppendNumbers(points.p_c[i].data(), 3, line);
    AppendNumbers(points.u_s[i].data(), 3, line);
    if (with_covariance_) AppendUpperTriangle(points.covariance_c_m2[i], line);
    if (!points.beam.empty()) AppendInteger(points.beam[i], line);
    text += line;
    text += '\n';
  }
  file_.Append(text);
}

}  // namespace dn::lidar_internal
