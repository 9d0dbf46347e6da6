#include "output_folder.h"

#include <dn/error.h>
#include <dn/files/accuracy_files.h>
#include <dn/files/atomic_file.h>
#include <dn/files/flight.h>
#include <dn/files/scanners.h>
#include <dn/files/strip_files.h>
#include <dn/geo/read_file.h>
#include <dn/names.h>
#include <dn/sim/scenario.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <set>
#include <utility>

#include "json_file.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

bool Same(const fs::path& a, const fs::path& b) {
  std::error_code none;
  return fs::equivalent(a, b, none);
}

/// Device and inode number, which are equal for two names of one file.
using FileId = std::pair<dev_t, ino_t>;

std::optional<FileId> FindFileId(const fs::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return std::nullopt;
  return FileId(status.st_dev, status.st_ino);
}

std::set<FileId> FileIds(const fs::path& folder, const std::vector<std::string>& names) {
  std::set<FileId> ids;
  for (const std::string& name : names) {
    if (const auto id = FindFileId(folder / name)) ids.insert(*id);
  }
  return ids;
}

void AddData(const fs::path& file, Inputs* inputs) {
  inputs->files.push_back(file);
  inputs->folders.push_back(file.parent_path());
}

void AddAccuracy(const FlightConfig& config, Inputs* inputs) {
  const AccuracyFiles accuracy = FindAccuracyFiles(config);
  for (const auto& file : {accuracy.covariance, accuracy.series}) {
    if (file) AddData(*file, inputs);
  }
}

void AddFolder(const fs::path& folder, Inputs* inputs) {
  for (const fs::path& each : {folder, folder / "lidar", folder / "strips", folder / "control"}) {
    inputs->folders.push_back(each);
  }
}

void AddCircularLinks(const fs::path& flight_folder, Inputs* inputs) {
  for (const char* folder : {"lidar", "strips"}) {
    std::error_code none;
    for (const fs::directory_entry& entry : fs::directory_iterator(flight_folder / folder, none)) {
      if (IsCircularLink(entry.path())) inputs->circular_links.push_back(entry.path());
    }
  }
  std::sort(inputs->circular_links.begin(), inputs->circular_links.end());
}

/// Adds the folders of the scanners of a list.
void AddScannerFolders(const FlightConfig& config, Inputs* inputs) {
  for (const std::string& name : ScannerNames(config)) {
    if (name.empty()) continue;
    inputs->folders.push_back(config.folder / ("lidar_" + name));
    inputs->folders.push_back(config.folder / ("strips_" + name));
  }
}

void AddPairFiles(const fs::path& folder, const std::vector<std::string>& patterns,
                  Inputs* inputs) {
  for (const fs::path& file : FindPairFiles(folder, patterns)) AddData(file, inputs);
}

void AddDataFiles(const fs::path& folder_or_file, const std::vector<std::string>& changes,
                  Inputs* inputs) {
  try {
    const FlightConfig config = ReadFlightConfig(folder_or_file, changes);
    const fs::path& folder = config.folder;
    AddFolder(folder, inputs);
    AddScannerFolders(config, inputs);
    inputs->files.push_back(config.file);
    if (config.imu) AddData(folder / config.imu->file, inputs);
    if (config.gnss) AddData(folder / config.gnss->file, inputs);
    if (config.trajectory) AddData(folder / config.trajectory->file, inputs);
    if (HasControl(config)) {
      const ControlConfig control = config.control.value_or(ControlConfig());
      for (const fs::path& file : FindPairFiles(folder, control.files)) AddData(file, inputs);
    }
    inputs->strips = FindStripFiles(config);
    AddCircularLinks(folder, inputs);
    if (config.trajectory) AddAccuracy(config, inputs);
    if (!config.lidar) return;
    for (std::size_t k = 0; k < NumScanners(config); ++k) {
      AddPairFiles(folder, ScannerAt(config, k).p2p, inputs);
      AddPairFiles(folder, ScannerAt(config, k).surface_pairs, inputs);
    }
    for (const PairsBetween& between : config.pairs_between) {
      AddPairFiles(folder, between.p2p, inputs);
    }
    for (const TieFiles& files : config.ties) AddPairFiles(folder, files.p2p, inputs);
  } catch (const std::exception&) {
    return;  // the command will say what is wrong
  }
}

}  // namespace

std::vector<fs::path> Inputs::All() const {
  std::vector<fs::path> all = files;
  all.insert(all.end(), strips.begin(), strips.end());
  return all;
}

Inputs FlightInputs(const fs::path& folder_or_file, const std::vector<std::string>& changes,
                    const std::string& trajectory) {
  Inputs inputs;
  AddFolder(folder_or_file, &inputs);
  AddDataFiles(folder_or_file, changes, &inputs);
  if (!trajectory.empty()) inputs.files.emplace_back(trajectory);
  return inputs;
}

Inputs ScenarioInputs(const std::string& name_or_path, const std::vector<std::string>& changes) {
  Inputs inputs;
  inputs.files.emplace_back(name_or_path);
  try {
    if (const auto replay = ReadScenario(name_or_path, changes).plan.replay) {
      inputs.files.push_back(*replay);
    }
  } catch (const std::exception&) {
    return inputs;  // the command will say what is wrong
  }
  return inputs;
}

std::vector<std::string> EarlierResults(const fs::path& out) {
  const fs::path file = out / "report.json";
  std::error_code none;
  if (!fs::is_regular_file(fs::symlink_status(file, none))) return {};
  std::vector<std::string> names;
  try {
    const Json report = ReadJsonFile(file);
    const JsonPlace place(report, file.string());
    if (place.At("schema").Text() != "dn.report/1") return {};
    for (const JsonPlace& name : place.At("files").Elements()) {
      if (!name.json().is_string() || !IsResultName(name.Text())) continue;
      names.push_back(name.Text());
    }
  } catch (const InvalidInput&) {
    return {};  // another program's file, or a damaged one: nothing in it is known to be ours
  }
  return names;
}

void ExpectHarmless(const fs::path& out, const Inputs& inputs, bool writes_flight) {
  for (const fs::path& folder : inputs.folders) {
    if (!Same(out, folder)) continue;
    throw InvalidConfig(fmt::format(
        "--out {} is a folder of the input data; give a folder of its own", out.string()));
  }
  const std::vector<std::string> earlier = EarlierResults(out);
  const std::set<FileId> results = FileIds(out, earlier);
  for (const fs::path& input : inputs.All()) {
    const auto id = FindFileId(input);
    if (!id || !results.contains(*id)) continue;
    throw InvalidConfig(fmt::format(
        "--out {} contains an earlier result, which this run would remove, and the input {} is "
        "part of it; give another folder",
        out.string(), input.string()));
  }
  std::error_code none;
  const bool flight = fs::exists(fs::symlink_status(out / "flight.yaml", none));
  if (!flight || (writes_flight && HasName(earlier, "flight.yaml"))) return;
  throw InvalidConfig(
      fmt::format("--out {} is a flight folder: it contains a flight.yaml{}; give another folder",
                  out.string(), writes_flight ? " that dn simulate did not write" : ""));
}

void ExpectRealFolder(const fs::path& folder) {
  std::error_code none;
  const fs::file_status status = fs::symlink_status(folder, none);
  if (!fs::exists(status) || fs::is_directory(status)) return;
  throw UnusableOutput(folder.string() +
                       " is a file or link, but the results need a folder of this name; rename it, "
                       "or give another --out");
}

std::string FolderName(const std::string& name) {
  std::string folder;
  for (const char c : name) {
    const bool kept = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_' ||
                      (c == '.' && !folder.empty());
    folder += kept ? c : '_';
  }
  return folder.empty() ? "flight" : folder;
}

}  // namespace dn::apps
