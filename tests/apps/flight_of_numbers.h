#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "damaged_flight.h"

namespace dn::testing {

/// Numbers of a text file: one vector per row, one number per column.
using Table = std::vector<std::vector<double>>;

/// A damaged flight whose files are read and written as tables of numbers.
class FlightOfNumbers : public DamagedFlight {
 public:
  using DamagedFlight::DamagedFlight;

  /// Reads the rows of a text file, without comments.
  Table Rows(const std::string& name) const;
  void WriteRows(const std::string& name, const Table& rows) const;
  /// Applies `change` to every row of a text file.
  void EachRow(const std::string& name,
               const std::function<void(std::vector<double>&)>& change) const;

  /// Returns the sorted names of the pair files, such as lidar/1_2.txt.
  std::vector<std::string> PairFiles() const;
  void EachPair(const std::function<void(std::vector<double>&)>& change) const;

  /// Sets a key of flight.yaml, such as lidar.lever_arm_m. The key must be on its own line.
  void Set(const std::string& key, const std::string& value) const;
  /// Replaces files of this flight with those of another one.
  void Take(const std::filesystem::path& other, const std::vector<std::string>& names) const;
};

}  // namespace dn::testing
