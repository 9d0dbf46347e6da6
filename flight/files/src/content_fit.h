#pragma once

#include <dn/files/file_content.h>
#include <dn/geo/week_seconds.h>

#include <string>
#include <utility>

namespace dn::files_internal {

/// A kind of file that a text may be, and how well it fits.
struct ContentFit {
  FileContent content;
  double score = 0.0;  ///< share of the tests that the text passes, less what is unusual; 1: all
  std::string failed;  ///< the first test that it fails; empty if the text is of this kind

  bool fits() const { return failed.empty(); }
};

/// Counts the tests of a kind that a text passes.
class FitTests {
 public:
  explicit FitTests(double count) : count_(count) {}

  /// Returns whether the text passes all tests up to this one.
  bool Expect(bool passes, std::string failure) {
    if (!failed_.empty()) return false;
    if (passes) {
      ++passed_;
    } else {
      failed_ = std::move(failure);
    }
    return passes;
  }

  ContentFit Result(FileContent content) const {
    return {std::move(content), passed_ / count_, failed_};
  }

 private:
  double count_, passed_ = 0.0;
  std::string failed_;
};

/// Offset of time tags that are seconds since 1980 or 1970: the beginning of their GPS week.
/// Returns 0 for seconds of week and for other times.
double FindTimeOffset(double t_s);

/// Returns whether a time is a second of week, or seconds since 1980 or 1970.
inline bool IsTime(double t_s) { return IsWeekSeconds(t_s) || FindTimeOffset(t_s) != 0.0; }

}  // namespace dn::files_internal
