#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

/// Tests of one simulated flight and its calibration, which are made once for each suite.
class CalibratedFlight : public ::testing::Test {
 protected:
  /// Flies the short scenario with these changes, and calibrates it.
  static void Make(const std::vector<std::string>& changes) {
    folder_ = new TempFolder;
    std::vector<std::string> words{"simulate",    ShortScenario().string(), "--seed", "5", "--out",
                                   Path("flight")};
    for (const std::string& change : changes) words.insert(words.end(), {"--set", change});
    const ProgramRun simulated = RunProgram(words);
    ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
    run_ = new ProgramRun(RunProgram({"calibrate", Path("flight"), "--out", Path("result")}));
  }
  static void TearDownTestSuite() {
    delete run_;
    delete folder_;
  }
  static std::string Path(const std::string& name) { return (folder_->path() / name).string(); }

  inline static TempFolder* folder_ = nullptr;
  inline static ProgramRun* run_ = nullptr;
};

}  // namespace dn::testing::apps_test
