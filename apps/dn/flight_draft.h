#pragma once

#include <dn/files/file_content.h>
#include <dn/files/flight_config.h>
#include <dn/imu/white_rows.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "data_hints.h"
#include "nmea_sigmas.h"
#include "strip_scanner.h"

namespace dn::apps {

/// Draft of a flight.yaml for recognised data files, with findings from the data as comments.
class FlightDraft {
 public:
  /// Takes one file of each kind; the remaining files become notes.
  FlightDraft(std::filesystem::path folder, const std::vector<FileContent>& contents);

  /// Reads the files and determines axes, noise and clocks from the data. A file that cannot be
  /// read becomes a note, and the next file of its kind is taken. If inertial and GNSS data do not
  /// fit each other, this becomes a note.
  void Settle();

  /// Returns the text of flight.yaml.
  std::string Text() const;

  bool empty() const { return !imu_ && !gnss_ && !trajectory_ && pairs_.empty(); }

  /// Findings from the data, one line each.
  const std::vector<std::string>& found() const { return found_; }
  /// Files that are not used, with the reason.
  const std::vector<std::string>& notes() const { return notes_; }
  /// Returns whether a file of a known kind could not be read.
  bool Rejected(const FileContent& content) const;
  /// Returns the missing data and the values that the user must supply, one line each.
  std::vector<std::string> Missing() const;

 private:
  void Take(const FileContent& content);
  void TakeOne(const FileContent& content, const char* usual, std::optional<FileContent>* place);
  /// Replaces the files of a sensor until one can be read.
  void TakeReadable(FileKind kind, std::optional<FileContent>* place);
  /// Notes the further files of each kind.
  void NoteOthers();
  /// Determines the clock of a GNSS log and the axes of the inertial data from attitudes.
  void SettleByAttitudes();
  void SettleSensors();
  /// Applies a hint to clocks or axes. Returns false if it concerns something else.
  bool SettleByHint(const DataHint& hint, const DataAgreement& agreement);
  /// Compares the rotations of all other inertial files with those of the file in use.
  void CompareOtherUnits();
  /// Compares the trajectory with GNSS and inertial data, and corrects its columns.
  void SettleTrajectory();
  std::vector<DataHint> HintsOnTrajectory() const;
  void UseTrajectoryColumns(const ColumnNames& columns);
  void SettleScanner();
  /// Compares the times of the strips with the trajectory or the GNSS positions.
  void CompareStrips();
  /// Returns the path of the trajectory, or else of the GNSS positions, if there is one.
  std::optional<RoughPath> FindPath() const;
  std::string SensorsText() const;
  std::string ImuText() const;
  std::string GnssText() const;
  std::string LidarText() const;
  std::string BeamsText() const;
  std::string GeoreferencingText() const;
  std::string TrajectoryText() const;
  std::string UnmodelledText() const;
  bool LacksScannerLeverArm() const;
  std::string ColumnsText() const;
  std::string Named(const std::filesystem::path& file) const;

  std::filesystem::path folder_;
  std::optional<FileContent> imu_, gnss_, trajectory_, smrmsg_;
  std::vector<FileContent> others_;    ///< further files of the kinds above
  std::vector<FileContent> rejected_;  ///< files that cannot be read
  std::vector<FileContent> pairs_;
  std::size_t num_beams_ = 0;  ///< that the pairs name; 0: none
  std::vector<StripScanner> strip_scanners_;
  /// Number of strips that neither contain laser vectors nor record the boresight of their points.
  std::size_t strips_without_vectors_ = 0;
  std::vector<std::string> found_, notes_, axes_notes_, trajectory_notes_, strip_notes_;
  Eigen::Matrix3d R_imu_to_body_ = Eigen::Matrix3d::Identity();
  bool axes_known_ = false;
  bool axes_by_attitudes_ = false;  ///< they follow from the attitudes of the GNSS file
  std::string utm_zone_;            ///< e.g. "32n", from the GNSS positions; empty if unknown
  double imu_offset_s_ = 0.0, gnss_offset_s_ = 0.0;
  NmeaQualities nmea_qualities_;
  std::string imu_summary_, gnss_summary_;
  WhiteNoiseDensities white_;  ///< with a margin
  ScannerAxes axes_;           ///< of the pairs
};

}  // namespace dn::apps
