#include "output_folder.h"

#include <dn/error.h>
#include <dn/flight/accuracy_files.h>
#include <dn/flight/flight.h>
#include <dn/flight/strip_files.h>
#include <dn/report/json.h>
#include <dn/sim/scenario.h>
#include <fmt/format.h>

#include <algorithm>
#include <fstream>

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

bool Same(const fs::path& a, const fs::path& b) {
  std::error_code none;
  return fs::equivalent(a, b, none);
}

bool Holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
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
  for (const fs::path& each : {folder, folder / "lidar", folder / "strips"}) {
    inputs->folders.push_back(each);
  }
}

void AddDataFiles(const fs::path& folder_or_file, const std::vector<std::string>& changes,
                  Inputs* inputs) {
  try {
    const FlightConfig config = ReadFlightConfig(folder_or_file, changes);
    const fs::path& folder = config.folder;
    AddFolder(folder, inputs);
    inputs->files.push_back(config.file);
    if (config.imu) AddData(folder / config.imu->file, inputs);
    if (config.gnss) AddData(folder / config.gnss->file, inputs);
    if (config.trajectory) AddData(folder / config.trajectory->file, inputs);
    inputs->strips = FindStripFiles(folder);
    if (config.trajectory) AddAccuracy(config, inputs);
    if (!config.lidar) return;
    for (const fs::path& file : FindPairFiles(folder, config.lidar->p2p)) AddData(file, inputs);
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
  constexpr std::uintmax_t kLargestReport = std::uintmax_t{64} << 20;
  const fs::path file = out / "report.json";
  std::error_code none;
  if (!fs::is_regular_file(fs::symlink_status(file, none))) return {};
  if (fs::file_size(file, none) > kLargestReport) return {};
  std::ifstream in(file, std::ios::binary);
  const Json report = Json::parse(in, nullptr, false);
  if (!report.is_object() || report.value("schema", Json()) != "dn.report/1") return {};
  std::vector<std::string> names;
  for (const Json& name : report.value("files", Json::array())) {
    if (name.is_string()) names.push_back(name.get<std::string>());
  }
  return names;
}

void ExpectHarmless(const fs::path& out, const Inputs& inputs, bool makes_flight) {
  for (const fs::path& folder : inputs.folders) {
    if (!Same(out, folder)) continue;
    throw InvalidConfig(fmt::format(
        "--out {} is a folder of the input data; give a folder of its own", out.string()));
  }
  const std::vector<std::string> earlier = EarlierResults(out);
  for (const std::string& name : earlier) {
    for (const fs::path& input : inputs.All()) {
      if (!Same(out / name, input)) continue;
      throw InvalidConfig(fmt::format(
          "--out {} holds an earlier result, which would be removed, and the input {} is part of "
          "it; give another folder",
          out.string(), input.string()));
    }
  }
  std::error_code none;
  const bool flight = fs::exists(fs::symlink_status(out / "flight.yaml", none));
  if (!flight || (makes_flight && Holds(earlier, "flight.yaml"))) return;
  throw InvalidConfig(
      fmt::format("--out {} is a flight folder, it holds a flight.yaml{}; give another folder",
                  out.string(), makes_flight ? " that dn simulate did not write" : ""));
}

}  // namespace dn::apps
