#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "rough_path.h"

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

/// The mounting that the points of strips show.
struct ShownMounting {
  /// How far it can be relied on.
  enum class Source {
    kChosen,      ///< there are no laser vectors: the axes of the scanner are free
    kCourse,      ///< from a level body along the course: to some degrees
    kTrajectory,  ///< it leads from the laser vectors to the points
  };
  Source source = Source::kChosen;
  Eigen::Matrix3d R_bs = Eigen::Matrix3d::Identity();
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();  ///< kTrajectory: that of the points
  std::optional<Eigen::Vector3d> lever_arm_b_m;             ///< kTrajectory, if observable
  double rms_m = 0.0;                                       ///< remaining distance of a coordinate
};

/// A scanner as its strips show it.
struct StripScanner {
  std::string name;  ///< NAME of the folder strips_NAME; empty for strips/
  std::vector<std::filesystem::path> strips;
  ScannerAxes axes;
  /// Smallest and largest rotation of a laser vector about the scan axis from nadir, deg.
  double low_deg = 0.0, high_deg = 0.0;
  std::optional<ShownMounting> mounting;
  std::optional<double> gsd_m;
  std::string crs;  ///< system in which the points lie about the path, if no file states one
};

/// Returns the folders strips/ and strips_NAME/ of a flight with their point clouds.
std::vector<StripScanner> FindStripFolders(const std::filesystem::path& flight_folder);

/// Finds the axes by some of the first points of each strip. With a path, also finds the mounting,
/// and the system and the spacing of the points. `guesses`: systems to try if the files state none.
/// Returns false if nothing is found: no strip has laser vectors, and no point lies about the path.
bool SettleScannerByStrips(const RoughPath* path, const std::vector<std::string>& guesses,
                           StripScanner* scanner);

}  // namespace dn::apps
