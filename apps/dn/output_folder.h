#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace dn::apps {

/// Files and folders that a run reads and must therefore not overwrite.
struct Inputs {
  std::vector<std::filesystem::path> folders;  ///< flight folder and folders of its data
  std::vector<std::filesystem::path> files;
  std::vector<std::filesystem::path> strips = {};  ///< point clouds; only some commands read them
  std::vector<std::filesystem::path> circular_links = {};  ///< links among the data, left out

  std::vector<std::filesystem::path> All() const;  ///< files and strips
};

/// Returns the inputs of a flight: its YAML file, its data folder and the files it names.
/// `changes`: --set values, as in ReadFlightConfig. Errors in the YAML file are not reported here;
/// the command that reads the file reports them.
Inputs FlightInputs(const std::filesystem::path& folder_or_file,
                    const std::vector<std::string>& changes, const std::string& trajectory = "");

/// Returns the inputs of a scenario: its file, unless it is a shipped one, and the trajectory that
/// it replays.
Inputs ScenarioInputs(const std::string& name_or_path,
                      const std::vector<std::string>& changes = {});

/// Returns the files of an earlier run in the folder, as its report.json lists them.
std::vector<std::string> EarlierResults(const std::filesystem::path& out);

/// Throws InvalidConfig if results in `out` would overwrite an input or a flight folder. A command
/// that makes flights may replace a flight folder that such a command made.
void ExpectHarmless(const std::filesystem::path& out, const Inputs& inputs, bool writes_flight);

/// Returns a name as the name of a folder: letters, digits, dot, dash and underscore.
std::string FolderName(const std::string& name);

/// Throws UnusableOutput if a file or a link has the name of a folder of the results.
void ExpectRealFolder(const std::filesystem::path& folder);

}  // namespace dn::apps
