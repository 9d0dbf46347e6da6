#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace dn::apps {

/// Main axes of a scanner, by its laser vectors.
struct ScannerAxes {
  Eigen::Vector3d nadir_s = Eigen::Vector3d::UnitZ();  ///< axis of their main direction
  Eigen::Vector3d scan_s = Eigen::Vector3d::UnitX();   ///< axis with their smallest component
};

/// Sums laser vectors, to find the axes of their scanner.
class LaserVectorSums {
 public:
  void Add(const Eigen::Vector3d& u_s) {
    sum_ += u_s;
    squares_ += u_s.cwiseAbs2();
  }

  ScannerAxes Axes() const;

 private:
  Eigen::Vector3d sum_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d squares_ = Eigen::Vector3d::Zero();
};

/// A scanner as its strips show it.
struct StripScanner {
  std::string name;  ///< NAME of the folder strips_NAME; empty for strips/
  std::vector<std::filesystem::path> strips;
  ScannerAxes axes;
  /// Smallest and largest rotation of a laser vector about the scan axis from nadir, deg.
  double low_deg = 0.0, high_deg = 0.0;
};

/// Returns the folders strips/ and strips_NAME/ of a flight with their point clouds.
std::vector<StripScanner> FindStripFolders(const std::filesystem::path& flight_folder);

/// Finds the axes by the first points of each strip. Returns false if no strip has laser vectors.
bool SettleAxes(StripScanner* scanner);

}  // namespace dn::apps
