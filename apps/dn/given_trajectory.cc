#include "given_trajectory.h"

#include <filesystem>
#include <system_error>

namespace dn::apps {

FlightConfig WithTrajectory(FlightConfig config, const std::string& trajectory) {
  if (trajectory.empty()) return config;
  if (!config.trajectory) config.trajectory = TrajectoryConfig();
  config.trajectory->file = std::filesystem::absolute(trajectory).string();
  return config;
}

bool HasTrajectory(const FlightConfig& config) {
  const auto is_file = [&](const std::filesystem::path& name) {
    std::error_code none;
    return std::filesystem::is_regular_file(config.folder / name, none);
  };
  if (config.trajectory && is_file(config.trajectory->file)) return true;
  const std::string usual = TrajectoryConfig().file;
  const bool named = config.trajectory && config.trajectory->file != usual;
  return !named && (is_file(usual) || is_file("trajectory.txt"));
}

}  // namespace dn::apps
