#include <dn/error.h>
#include <dn/geo/read_file.h>
#include <dn/lidar/strip_io.h>

#include "las_reader.h"
#include "strip_text.h"

namespace dn {

std::unique_ptr<StripReader> OpenStrip(const std::filesystem::path& file) {
  constexpr std::size_t kSampleBytes = 4096;
  const std::string beginning = ReadBeginning(file, kSampleBytes);
  if (beginning.starts_with("LASF")) return std::make_unique<lidar_internal::LasReader>(file);
  if (!IsBinary(beginning)) return std::make_unique<lidar_internal::StripTextReader>(file);
  throw InvalidInput(
      "strips must be LAS or LAZ, or text of t, x, y, z, ux, uy, uz; this is neither",
      FileLocation{file.string()});
}

}  // namespace dn
