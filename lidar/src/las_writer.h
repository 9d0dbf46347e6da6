#pragma once

#include <dn/geo/file_writer.h>
#include <dn/geo/little_endian.h>
#include <dn/lidar/strip_io.h>

#include <array>

#include "las_file.h"

namespace dn::lidar_internal {

/// Writes points into a copy of a LAS file. Header, records and the data after the points are kept,
/// except for fields that depend on the points. Coordinates are rounded to the grid of the file.
/// The points are compressed if the name of the new file ends in .laz.
class LasWriter final : public StripWriter {
 public:
  /// A covariance in `additions` adds six floats per point, the extra bytes VarianceX, VarianceY,
  /// VarianceZ, CovarianceXY, CovarianceXZ, CovarianceYZ (m^2).
  LasWriter(const std::filesystem::path& file, LasFile las, const StripAdditions& additions);

  void Append(const StripCloud& points) override;
  void Finish() override;

 private:
  void StartCompression();
  void AppendBytes(std::string_view bytes);
  void AppendRecord(const StripCloud& points, std::size_t i);
  void StorePosition(const Eigen::Vector3d& p_c, char* record);
  void FinishPoints();
  void CopyTail();
  void SupersedeIndexes(std::uint64_t tail_at);
  void StoreCounts();
  void MoveTail(std::uint64_t tail_at);

  template <class T>
  void Store(std::size_t at, T value) {
    StoreLittleEndian(value, head_.data() + at);
  }

  LasFile las_;
  std::string head_;  ///< header and records of the new file
  std::size_t record_bytes_ = 0;
  std::optional<std::array<std::size_t, 6>> covariance_at_;
  std::optional<laz::PointWriter> compressed_;
  FileWriter file_;
  std::string buffer_;
  std::uint64_t end_ = 0;  ///< length of the new file
  std::uint64_t written_ = 0;
  std::array<std::uint64_t, las::kReturns> returns_{};
  Eigen::Vector3d min_, max_;
};

}  // namespace dn::lidar_internal
