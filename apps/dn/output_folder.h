#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace dn::apps {

/// What a run reads, and so must not touch.
struct Inputs {
  std::vector<std::filesystem::path> folders;  ///< of the flight and of the data it names
  std::vector<std::filesystem::path> files;
  std::vector<std::filesystem::path> strips = {};  ///< point clouds, which few commands read
  std::vector<std::filesystem::path> circular_links = {};  ///< among the data; they are left out

  std::vector<std::filesystem::path> All() const;  ///< files and strips
};

/// The flight's YAML file with `changes` of it (ReadFlightConfig), its folder of data, and the files that are named as far as they can be
/// read. Faults of the YAML file are for the command to report.
Inputs FlightInputs(const std::filesystem::path& folder_or_file,
                    const std::vector<std::string>& changes, const std::string& trajectory = "");

/// The scenario's file, if it is no shipped scenario, and the trajectory that it replays.
Inputs ScenarioInputs(const std::string& name_or_path,
                      const std::vector<std::string>& changes = {});

/// The files that an earlier run left in a folder, as its report.json lists them.
std::vector<std::string> EarlierResults(const std::filesystem::path& out);

/// Throws InvalidConfig where results in `out` would harm an input, or a flight that is not ours:
/// only a command that makes flights may replace one, and only one that such a command made.
void ExpectHarmless(const std::filesystem::path& out, const Inputs& inputs, bool makes_flight);

/// Throws UnusableOutput where a file or a link stands in the place of a folder of the results.
void ExpectRealFolder(const std::filesystem::path& folder);

}  // namespace dn::apps
