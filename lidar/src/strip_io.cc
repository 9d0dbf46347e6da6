#include <dn/error.h>
#include <dn/lidar/strip_io.h>

#include <algorithm>
#include <cctype>

#include "las_reader.h"
#include "strip_text.h"

namespace dn {

std::unique_ptr<StripReader> OpenStrip(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (ending == ".txt") return std::make_unique<lidar_internal::StripTextReader>(file);
  if (ending == ".las" || ending == ".laz")
    return std::make_unique<lidar_internal::LasReader>(file);
  throw InvalidInput("strips must be .las, .laz or .txt files, not '" + ending + "'",
                     FileLocation{file.string()});
}

}  // namespace dn
