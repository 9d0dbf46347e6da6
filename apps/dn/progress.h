#pragma once

#include <dn/stopwatch.h>

#include <optional>
#include <string>
#include <vector>

namespace dn::apps {

/// Completed part of a stage: `done` of `of` things. `of` = 1 is displayed in percent.
struct Share {
  double done = 0.0, of = 1.0;
  std::string things;
};

/// Estimates the remaining time from the rate of progress.
class TimeLeft {
 public:
  /// Returns the remaining time in s, or nullopt before any progress. `now_s`: present time, s. The
  /// estimate restarts if the counted things change or the share decreases.
  std::optional<double> At(const Share& share, double now_s);

 private:
  Share first_, last_;
  double first_s_ = 0.0;
  bool begun_ = false;
};

/// Prints progress on stderr: a live line on a terminal, otherwise one line per stage.
/// With `as_json` it prints JSON lines instead: one per stage and up to ten per second within a
/// stage. Keys: command, stage, elapsed_s and, if known, detail, done, of, left_s.
class Progress {
 public:
  Progress(std::string command, bool as_json);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Enters a stage, or updates the detail of the one it is in.
  void Stage(const std::string& stage, const std::string& detail = "");
  /// Enters or updates a stage, with the completed part and the estimated remaining time.
  void Stage(const std::string& stage, const Share& share);
  void Warn(const std::string& message);

  /// Returns the stages, each once, in the order in which they were last entered.
  const std::vector<std::string>& stages() const { return stages_; }

 private:
  struct Moment {
    std::string stage, detail;
    std::optional<Share> share;
    std::optional<double> left_s;
  };

  void Show(const Moment& moment);
  void ShowJson(const Moment& moment, bool entered);
  void EndLine();

  std::string command_;
  std::string stage_;
  std::vector<std::string> stages_;
  TimeLeft time_left_;
  Stopwatch watch_;
  double last_json_s_ = 0.0;
  bool as_json_;
  bool terminal_;
  bool line_open_ = false;
};

}  // namespace dn::apps
