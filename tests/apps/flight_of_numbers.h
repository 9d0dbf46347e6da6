#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "damaged_flight.h"

namespace dn::testing {

/// A number per column, a vector per row of a text file.
using Table = std::vector<std::vector<double>>;

/// A damaged flight whose numbers can be computed with.
class FlightOfNumbers : public DamagedFlight {
 public:
  using DamagedFlight::DamagedFlight;

  /// Rows of a text file without comments.
  Table Rows(const std::string& name) const;
  void WriteRows(const std::string& name, const Table& rows) const;
  /// Changes every row of a text file.
  void EachRow(const std::string& name,
               const std::function<void(std::vector<double>&)>& change) const;

  /// Names of the pair files, such as lidar/1_2.txt, sorted.
  std::vector<std::string> PairFiles() const;
  void EachPair(const std::function<void(std::vector<double>&)>& change) const;

  /// Sets a key of flight.yaml, such as lidar.lever_arm_m, that stands there on a line of its own.
  void Set(const std::string& key, const std::string& value) const;
  /// Takes files of another flight instead of this one's.
  void Take(const std::filesystem::path& other, const std::vector<std::string>& names) const;
};

}  // namespace dn::testing
