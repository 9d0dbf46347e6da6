#pragma once

#include <dn/lidar/strip_io.h>

#include <array>
#include <fstream>

#include "las_file.h"

namespace dn::lidar_internal {

/// Reads the points of a LAS or LAZ file.
class LasReader final : public StripReader {
 public:
  explicit LasReader(const std::filesystem::path& file);

  bool Next(StripCloud* chunk) override;
  bool has_time() const override { return las_.time_at.has_value(); }
  bool has_vectors() const override { return vector_[0] != nullptr; }
  const StripCrs& crs() const override { return las_.crs; }
  std::optional<Eigen::Vector3d> boresight_rad() const override { return las_.boresight_rad; }
  std::optional<std::uint64_t> points() const override { return las_.points; }
  std::unique_ptr<StripWriter> MakeWriter(const std::filesystem::path& file,
                                          const StripAdditions& additions) const override;

 private:
  void ReadRecords(std::uint64_t count, StripCloud* chunk);
  void ReadPlain(std::string* records);
  void ReadCompressed(std::uint64_t count, std::string* records);
  void Decode(std::uint64_t index, const char* record, StripCloud* chunk);
  std::uint16_t Beam(std::uint64_t index, const char* record) const;
  double Time(std::uint64_t index, const char* record);
  FileLocation Where() const { return {las_.path.string()}; }

  LasFile las_;
  std::array<const ExtraDimension*, 3> vector_{};  ///< ux, uy, uz
  const ExtraDimension* beam_ = nullptr;
  std::ifstream in_;
  std::optional<laz::PointReader> compressed_;
  std::uint64_t read_ = 0;
  /// GPS time of the file minus seconds of week. It is a number of whole weeks, so that the
  /// subtraction is exact.
  std::optional<double> time_origin_s_;
};

}  // namespace dn::lidar_internal
