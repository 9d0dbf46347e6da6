#include <dn/error.h>
#include <dn/files/accuracy_files.h>
#include <dn/geo/read_file.h>

#include <string>
#include <system_error>
#include <vector>

#include "is_there.h"
#include "lower_case.h"

namespace dn {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCovarianceName = "trajectory_covariance.txt";
constexpr const char* kSigmaName = "trajectory_sigma.txt";

/// Returns whether a file is named like an smrmsg file and is not text. Its ending does not matter.
bool IsSmrmsg(const fs::path& file) {
  std::error_code none;
  return files_internal::LowerCase(file.filename().string()).find("smrmsg") != std::string::npos &&
         fs::is_regular_file(file, none) && (fs::is_empty(file, none) || IsBinaryFile(file));
}

/// Returns the smrmsg file of POSPac in a folder: for "sbet_<name>" it is "smrmsg_<name>" with any
/// ending, otherwise the only smrmsg file.
std::optional<fs::path> FindSmrmsg(const fs::path& trajectory) {
  std::string partner = files_internal::LowerCase(trajectory.stem().string());
  const std::size_t at = partner.find("sbet");
  if (at != std::string::npos) partner.replace(at, 4, "smrmsg");
  std::vector<fs::path> found;
  std::error_code none;
  const fs::path folder = trajectory.has_parent_path() ? trajectory.parent_path() : fs::path(".");
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, none)) {
    if (!IsSmrmsg(entry.path())) continue;
    if (files_internal::LowerCase(entry.path().stem().string()) == partner) return entry.path();
    found.push_back(entry.path());
  }
  if (found.size() > 1) {
    throw InvalidInput("several smrmsg files are in the folder of the trajectory " +
                           trajectory.string() + "; name the one that belongs to it with the key " +
                           "trajectory.sigma_file",
                       FileLocation{folder.string(), 0, 0});
  }
  return found.empty() ? std::nullopt : std::optional(found.front());
}

std::optional<fs::path> IfThere(const fs::path& file) {
  return files_internal::IsThere(file) ? std::optional(file) : std::nullopt;
}

}  // namespace

AccuracyFiles FindAccuracyFiles(const FlightConfig& flight) {
  const TrajectoryConfig& config = *flight.trajectory;
  AccuracyFiles files;
  if (!config.sigma_file.empty()) {
    files.named = true;
    const fs::path file = flight.folder / config.sigma_file;
    const bool joint = file.filename().string().find("covariance") != std::string::npos;
    (joint ? files.covariance : files.series) = file;
    return files;
  }
  const fs::path trajectory = flight.folder / config.file;
  files.covariance = IfThere(fs::path(trajectory).replace_filename(kCovarianceName));
  files.series = IfThere(fs::path(trajectory).replace_filename(kSigmaName));
  if (!files.series) files.series = FindSmrmsg(trajectory);
  return files;
}

}  // namespace dn
