#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace dn::apps {

/// How much of the work at hand is done: `done` of `of` things. A whole of 1 is shown in percent.
struct Share {
  double done = 0.0, of = 1.0;
  std::string things;
};

/// Estimates the time that is left from how fast a share grows.
class TimeLeft {
 public:
  /// Seconds left at now_s; nothing before the share has grown. A share of something else, or one
  /// that has shrunk, begins anew.
  std::optional<double> At(const Share& share, double now_s);

 private:
  Share first_, last_;
  double first_s_ = 0.0;
  bool begun_ = false;
};

/// Progress on stderr: a live line on a terminal, else a line per stage, or with `as_json` a line of
/// JSON for each stage and up to ten each second within it: command, stage, elapsed_s and, as far
/// as they are known, detail, done, of, left_s.
class Progress {
 public:
  Progress(std::string command, bool as_json);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Enters a stage, or updates the detail of the one it is in.
  void Stage(const std::string& stage, const std::string& detail = "");
  /// The same with how much is done, and about how long the rest takes.
  void Stage(const std::string& stage, const Share& share);
  void Warn(const std::string& message);

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
  TimeLeft time_left_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double last_json_s_ = 0.0;
  bool as_json_;
  bool terminal_;
  bool line_open_ = false;
};

}  // namespace dn::apps
