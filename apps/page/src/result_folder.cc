#include "result_folder.h"

#include <dn/error.h>
#include <dn/geo/read_file.h>
#include <dn/report/json_reader.h>

#include <memory>
#include <utility>

namespace dn::page_internal {
namespace {

// Limits far above those of any file that a command writes.
constexpr std::size_t kMostTextBytes = std::size_t{16} << 20;
constexpr std::size_t kMostRows = 100'000;

}  // namespace

ResultFolder::ResultFolder(std::filesystem::path folder)
    : folder_(std::move(folder)),
      rows_left_(std::make_shared<std::size_t>(kMostRows)),
      values_left_(JsonLimits{}.values) {
  report_ = Read("report.json");
  if (report_["schema"].text() == "dn.report/1") return;
  throw InvalidInput("not a result folder of dn: it has no report.json of schema dn.report/1",
                     {folder_.string()});
}

bool ResultFolder::Has(const std::string& name) const {
  std::error_code none;
  return std::filesystem::is_regular_file(folder_ / name, none);
}

Facts ResultFolder::Read(const std::string& name) const {
  const auto known = files_.find(name);
  if (known != files_.end()) return known->second;
  const std::filesystem::path file = FilePath(name);
  std::error_code none;
  if (!std::filesystem::exists(file, none)) return {name, Json(), rows_left_};
  JsonLimits limits;
  limits.values = values_left_;
  Json json = ParseJson(ReadWholeFile(file, limits.bytes), file.string(), limits);
  values_left_ -= CountValues(json);
  return files_.emplace(name, Facts(name, std::move(json), rows_left_)).first->second;
}

std::optional<TextTable> ResultFolder::Numbers(const std::string& name, std::size_t columns) const {
  if (!Has(name)) return std::nullopt;
  return ReadTextTable(FilePath(name), {columns});
}

std::string ResultFolder::Text(const std::string& name) const {
  return Has(name) ? ReadWholeFile(FilePath(name), kMostTextBytes) : "";
}

std::optional<FlightConfig> ResultFolder::Config() const {
  try {
    return ParseFlightConfig(Text("config.resolved.yaml"), folder_);
  } catch (const InvalidInput&) {
    return std::nullopt;  // the configuration of a scenario, or none
  }
}

}  // namespace dn::page_internal
