#include <dn/files/accuracy_files.h>
#include <gtest/gtest.h>

#include "testing/temp_folder.h"

namespace dn::files_test {

/// Ten doubles of zeros: binary, as an smrmsg file is.
const std::string kBinary(80, '\0');

std::string FoundSeries(const testing::TempFolder& folder, const std::string& trajectory) {
  FlightConfig config;
  config.folder = folder.path();
  config.trajectory = TrajectoryConfig();
  config.trajectory->file = trajectory;
  const AccuracyFiles files = FindAccuracyFiles(config);
  return files.series ? files.series->filename().string() : "";
}

TEST(AccuracyFiles, TheCaseOfANameDoesNotMatter) {
  for (const char* name : {"smrmsg_mission.out", "SMRMSG_MISSION.OUT", "Smrmsg_Mission.Out",
                           "SMRMSG_MISSION.out", "smrmsg_mission.SMRMSG", "smrmsg_mission"}) {
    SCOPED_TRACE(name);
    testing::TempFolder folder;
    folder.Write(name, kBinary);
    EXPECT_EQ(FoundSeries(folder, "SBET_MISSION.OUT"), name);
    EXPECT_EQ(FoundSeries(folder, "sbet_mission.sbet"), name);
    EXPECT_EQ(FoundSeries(folder, "trajectory.out"), name);
  }
}

TEST(AccuracyFiles, TheFileOfTheSameMissionIsFound) {
  testing::TempFolder folder;
  folder.Write("SMRMSG_1.OUT", kBinary);
  folder.Write("SMRMSG_2.OUT", kBinary);
  folder.Write("smrmsg_notes.txt", "the standard deviations are those of the forward run\n");
  EXPECT_EQ(FoundSeries(folder, "sbet_2.out"), "SMRMSG_2.OUT");
  EXPECT_THROW(FoundSeries(folder, "sbet_3.out"), InvalidInput);
}

}  // namespace dn::files_test
