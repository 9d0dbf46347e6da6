#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing {

/// A number per column, a vector per row of a text file.
using Table = std::vector<std::vector<double>>;

/// A flight folder copied so that it can be damaged, and a place for results.
class FlightCopy {
 public:
  explicit FlightCopy(const std::filesystem::path& flight);

  std::filesystem::path path() const { return folder_.path() / "flight"; }
  std::filesystem::path out() const { return folder_.path() / "out"; }

  /// Rows of a text file without comments.
  Table Rows(const std::string& name) const;
  void Write(const std::string& name, const Table& rows) const;
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

  ProgramRun Calibrate() const;

 private:
  TempFolder folder_;
};

}  // namespace dn::testing
