#pragma once

#include <dn/report/json_reader.h>
#include <dn/study/study.h>
#include <dn/study/study_output.h>

#include <cstdint>
#include <string>
#include <vector>

namespace dn {

/// A value of a swept key.
struct SweepValue {
  std::string label;  ///< name in the file, else the value itself
  std::string yaml;
};

/// A key of the scenario, and its values.
struct SweepKey {
  std::string path;  ///< "plan.lines"; "estimate": the unknowns estimated with the boresight
  std::vector<SweepValue> values;
};

/// A family of designs: a base scenario with every combination of the values of its keys.
///
///   base: lar3_rest                  # a shipped scenario, or a file in this folder
///   estimate: [gnss_lever_arm]       # estimated with the boresight; default: nothing
///   sweep:
///     plan.lines: {opposite: [[..], [..]], cross: [[..], [..]]}    # name: value
///     imu.preset: [airins, apx15]                                  # or values alone
class Sweep {
 public:
  /// Reads a sweep. `where` is the file, named in messages. Throws InvalidConfig for an unknown
  /// key, a key without values, and two values of a key with the same name. Also throws for more
  /// than 10000 designs, an invalid base, and combinations that are not valid scenarios.
  static Sweep Parse(const std::string& yaml_text, const std::string& where);

  const std::vector<SweepKey>& keys() const { return keys_; }
  std::uint64_t size() const;  ///< number of designs

  /// Returns the labels of a design, 1 to size(), one for each key; the last key changes fastest.
  /// Throws InvalidInput for another number.
  std::vector<std::string> Labels(std::uint64_t number) const;
  /// Returns the scenario of a design, named after its number.
  Scenario DesignScenario(std::uint64_t number) const;
  /// Returns the unknowns that a design estimates with the boresight.
  std::string DesignEstimate(std::uint64_t number) const;

  const std::string& base_text() const { return base_text_; }

 private:
  std::vector<std::size_t> Choice(std::uint64_t number) const;
  void ExpectScenarios() const;

  std::vector<SweepKey> keys_;
  std::string where_;
  std::string base_;
  std::string base_text_;
  std::string estimate_;
};

/// Results of one design of a sweep.
struct SweepRecord {
  std::uint64_t number = 0;
  std::vector<std::string> labels;
  /// Reason why the design is singular or cannot be flown; the numbers below are then zero.
  std::string failure;
  Eigen::Vector3d sigma_rad = Eigen::Vector3d::Zero();
  double condition_number = 0.0;
  double correlation_angles = 0.0;  ///< largest one between two angles
  double correlation_biases = 0.0;  ///< largest one with a bias, over the flight
  StripSigmas strips;
};

/// Studies one design. Throws Interrupted.
SweepRecord StudySweepDesign(const Sweep& sweep, std::uint64_t number,
                             const DesignOptions& options);

/// These two functions convert a record to JSON and back; doubles stay unchanged.
/// SweepRecordFromJson throws InvalidInput if the value is not a record or is out of range.
Json ToJson(const SweepRecord& record);
SweepRecord SweepRecordFromJson(const JsonPlace& json);

/// Returns sweep.csv with a row for each design.
std::string SweepCsv(const std::vector<std::string>& paths,
                     const std::vector<SweepRecord>& records);

/// Returns sweep.json with `keys` and the designs. A design has `number`, `labels`, `singular` (the
/// reason, else empty) and the columns of sweep.csv. The sigmas of the boresight are in
/// `sigma_deg`.
Json SweepJson(const std::vector<std::string>& paths, const std::vector<SweepRecord>& records);

/// Returns the contents of sweep.json as a text table.
std::string SweepTable(const std::vector<std::string>& paths,
                       const std::vector<SweepRecord>& records);

/// Returns plots of the sigmas of all designs by the values of a key, for each key with several
/// values.
std::vector<StudyPlot> SweepPlots(const std::vector<std::string>& paths,
                                  const std::vector<SweepRecord>& records);

}  // namespace dn
