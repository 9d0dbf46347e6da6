#pragma once

namespace dn {

/// No message of Ceres reaches stderr while one lives in any thread: the threshold of the log is
/// the process's own. The last one gives back what the first one found.
class QuietLog {
 public:
  QuietLog();
  ~QuietLog();
  QuietLog(const QuietLog&) = delete;
  QuietLog& operator=(const QuietLog&) = delete;
};

}  // namespace dn
