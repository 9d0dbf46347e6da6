#pragma once

namespace dn {

/// Suppresses Ceres's log messages on stderr while any object of this class exists in any thread.
/// The log threshold is global to the process; the last object restores the original threshold.
class QuietLog {
 public:
  QuietLog();
  ~QuietLog();
  QuietLog(const QuietLog&) = delete;
  QuietLog& operator=(const QuietLog&) = delete;
};

}  // namespace dn
