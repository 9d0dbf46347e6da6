#pragma once

#include <dn/report/json_reader.h>
#include <dn/study/report.h>
#include <dn/study/study.h>

#include <cstdint>
#include <string>
#include <vector>

namespace dn {

/// One value of a key that is swept.
struct SweepValue {
  std::string label;  ///< its name in the file, else the value itself
  std::string yaml;
};

/// A key of the scenario, and the values that it takes.
struct SweepKey {
  std::string path;  ///< "plan.lines"; "estimate": what is free beside the boresight
  std::vector<SweepValue> values;
};

/// A family of designs: a base scenario, and every combination of the values of its keys.
///
///   base: lar3_rest                  # a shipped scenario, or a file beside this one
///   estimate: [gnss_lever_arm]       # what is free beside the boresight; default: nothing
///   sweep:
///     plan.lines: {opposite: [[..], [..]], cross: [[..], [..]]}    # name: value
///     imu.preset: [airins, apx15]                                  # or values alone
class Sweep {
 public:
  /// Reads a sweep. `where` is the file, named in messages. Throws InvalidConfig for an unknown key,
  /// a key without values, more than 10000 designs, two values of a key with one name, a base that
  /// is no scenario, and designs that are none.
  static Sweep Parse(const std::string& yaml_text, const std::string& where);

  const std::vector<SweepKey>& keys() const { return keys_; }
  std::uint64_t size() const;  ///< number of designs

  /// Labels of a design, 1 to size(), one for each key; the last key changes fastest.
  std::vector<std::string> Labels(std::uint64_t number) const;
  /// Its scenario, which is named after its number, and what is free in it.
  Scenario ScenarioOf(std::uint64_t number) const;
  std::string EstimateOf(std::uint64_t number) const;

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

/// What one design of a sweep determines.
struct SweepRecord {
  std::uint64_t number = 0;
  std::vector<std::string> labels;
  /// Why the design is singular or cannot be flown; the numbers below are zero then.
  std::string failure;
  Eigen::Vector3d sigma_rad = Eigen::Vector3d::Zero();
  double condition_number = 0.0;
  double correlation_angles = 0.0;  ///< largest between two angles
  double correlation_biases = 0.0;  ///< largest with a bias, over the flight
  StripSigmas strips;
};

/// Studies one design. Interrupted passes through.
SweepRecord StudyOfSweep(const Sweep& sweep, std::uint64_t number, const DesignOptions& options);

/// A record as JSON, and back: doubles survive unchanged. The second throws InvalidInput for what is
/// no record, and for a value beyond its range.
Json ToJson(const SweepRecord& record);
SweepRecord SweepRecordFromJson(const JsonPlace& json);

/// sweep.csv: a row per design.
std::string SweepCsv(const std::vector<std::string>& paths,
                     const std::vector<SweepRecord>& records);

/// sweep.json: `keys`, and per design `number`, `labels`, `singular` (why, else empty) and the columns
/// of sweep.csv, the sigmas of the boresight in `sigma_deg`.
Json SweepJson(const std::vector<std::string>& paths, const std::vector<SweepRecord>& records);

/// The same as a table for the eye.
std::string SweepTable(const std::vector<std::string>& paths,
                       const std::vector<SweepRecord>& records);

/// For each key the sigmas of all designs, by its values; a key with one value has none.
std::vector<StudyPlot> SweepPlots(const std::vector<std::string>& paths,
                                  const std::vector<SweepRecord>& records);

}  // namespace dn
