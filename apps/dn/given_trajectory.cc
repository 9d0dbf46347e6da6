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
  // The reader refuses files that are not regular.
  const auto is_there = [&](const std::filesystem::path& name) {
    std::error_code none;
    const auto type = std::filesystem::status(config.folder / name, none).type();
    return type != std::filesystem::file_type::not_found;
  };
  if (config.trajectory && is_there(config.trajectory->file)) return true;
  const std::string usual = TrajectoryConfig().file;
  const bool named = config.trajectory && config.trajectory->file != usual;
  return !named && (is_there(usual) || is_there("trajectory.txt"));
}

}  // namespace dn::apps
