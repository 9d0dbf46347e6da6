#pragma once

#include <dn/geo/file_writer.h>
#include <dn/geo/text_table.h>
#include <dn/lidar/strip_io.h>

namespace dn::lidar_internal {

/// Reads the points of a LiMatch text file.
class StripTextReader final : public StripReader {
 public:
  explicit StripTextReader(const std::filesystem::path& file);

  bool Next(StripCloud* chunk) override;
  bool has_time() const override { return true; }
  bool has_vectors() const override { return true; }
  const StripCrs& crs() const override { return crs_; }
  std::optional<std::uint64_t> points() const override { return std::nullopt; }
  std::unique_ptr<StripWriter> MakeWriter(const std::filesystem::path& file,
                                          const StripAdditions& additions) const override;

 private:
  TextTableReader table_;
  StripCrs crs_;
};

/// Writes a LiMatch text file with enough digits to read back identical values.
class StripTextWriter final : public StripWriter {
 public:
  StripTextWriter(const std::filesystem::path& file, bool with_covariance)
      : file_(file), with_covariance_(with_covariance) {}

  void Append(const StripCloud& points) override;
  void Finish() override { file_.Publish(); }

 private:
  FileWriter file_;
  bool with_covariance_;
};

}  // namespace dn::lidar_internal
