#pragma once

#include <dn/files/flight_config.h>
#include <dn/geo/text_table.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "facts.h"

namespace dn::page_internal {

/// The files of a result folder.
class ResultFolder {
 public:
  /// Throws InvalidInput if the folder has no report.json of a run that ended with results.
  explicit ResultFolder(std::filesystem::path folder);

  const Facts& report() const { return report_; }
  bool Has(const std::string& name) const;
  /// Reads a JSON file; returns an empty value if it is absent. Throws InvalidInput if it is not a
  /// regular file or not JSON. Also throws if the files of the folder together have more values
  /// than ParseJson allows.
  Facts Read(const std::string& name) const;
  /// Reads a table of numbers with so many columns; returns nullopt if it is absent. Throws as
  /// ReadTextTable.
  std::optional<TextTable> Numbers(const std::string& name, std::size_t columns) const;
  /// Reads a text file; returns "" if it is absent.
  std::string Text(const std::string& name) const;
  std::filesystem::path FilePath(const std::string& name) const { return folder_ / name; }
  /// Returns the flight of config.resolved.yaml; nullopt if the file does not describe a flight.
  std::optional<FlightConfig> Config() const;

 private:
  std::filesystem::path folder_;
  RowsLeft rows_left_;
  mutable std::size_t values_left_;
  mutable std::map<std::string, Facts> files_;  // those that were read, by name
  Facts report_;
};

}  // namespace dn::page_internal
