#pragma once

#include <dn/flight/flight_config.h>
#include <dn/geo/text_table.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "facts.h"

namespace dn::internal {

/// The files of a result.
class ResultFolder {
 public:
  /// Throws InvalidInput where no run has ended with results in it.
  explicit ResultFolder(std::filesystem::path folder);

  const Facts& report() const { return report_; }
  bool Has(const std::string& name) const;
  /// A JSON file; nothing where it is absent. Throws InvalidInput for what is no regular file, no
  /// JSON, and where the files of the folder together have more values than ParseJson allows.
  Facts Read(const std::string& name) const;
  /// A table of numbers; nothing where it is absent or has other columns.
  std::optional<TextTable> Numbers(const std::string& name, std::size_t columns) const;
  /// A text; empty where it is absent.
  std::string Text(const std::string& name) const;
  std::filesystem::path PathOf(const std::string& name) const { return folder_ / name; }
  /// The flight that config.resolved.yaml describes, where it describes one.
  std::optional<FlightConfig> Config() const;

 private:
  std::filesystem::path folder_;
  RowsLeft rows_left_;
  mutable std::size_t values_left_;
  mutable std::map<std::string, Facts> files_;  // those that were read, by name
  Facts report_;
};

}  // namespace dn::internal
