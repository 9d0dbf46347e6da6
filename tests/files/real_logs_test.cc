// Public logs outside this project; the tests are skipped if they are absent.
#include <dn/files/file_content.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "testing/temp_folder.h"

namespace dn::files_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
namespace fs = std::filesystem;

class RealLogs : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(Data("."))) GTEST_SKIP() << "no real data in " << Data(".");
  }
  static fs::path Data(const std::string& name) {
    return fs::path(DN_SHARED_DATA_DIR) / "data" / name;
  }
  /// Inspects a packed file. Its kind stays unknown, with an empty reason, if xz is absent.
  static FileContent InspectPacked(const std::string& name) {
    const testing::TempFolder folder;
    const fs::path file = folder.path() / "log.csv";
    const std::string command = "xz -dc '" + Data(name).string() + "' > '" + file.string() + "'";
    return std::system(command.c_str()) == 0 ? InspectFile(file) : FileContent{};
  }
};

TEST_F(RealLogs, InertialSensorsOfADrone) {
  for (const char* name : {"quad-imus/DOT1.csv.xz", "quad-imus/DOT2.csv.xz"}) {
    SCOPED_TRACE(name);
    const FileContent content = InspectPacked(name);
    if (content.kind == FileKind::kUnknown && content.why.empty()) GTEST_SKIP() << "no xz";
    EXPECT_EQ(content.kind, FileKind::kImu) << content.why;
    EXPECT_THAT(content.columns,
                ElementsAre("t_us", "skip", "skip", "skip", "fx", "fy", "fz", "wx", "wy", "wz"));
    EXPECT_TRUE(content.rates_in_deg);
    EXPECT_FALSE(content.forces_in_g);
  }
}

TEST_F(RealLogs, AFlightLogOfADrone) {
  const FileContent content = InspectPacked("quad-imus/airdata.csv.xz");
  if (content.kind == FileKind::kUnknown && content.why.empty()) GTEST_SKIP() << "no xz";
  EXPECT_EQ(content.kind, FileKind::kGnss) << content.why;
  EXPECT_THAT(content.why, HasSubstr("'altitude(meters)' is above the ellipsoid"));
}

TEST_F(RealLogs, PositionsOfPhones) {
  const FileContent solution = InspectFile(Data("gsdc-spp/rover_1Hz_spp.pos"));
  EXPECT_EQ(solution.kind, FileKind::kGnss) << solution.why;
  EXPECT_EQ(solution.gnss_format, GnssFormat::kRtklib);
  const FileContent reference = InspectFile(Data("gsdc-spp/reference.csv"));
  EXPECT_EQ(reference.kind, FileKind::kTrajectory) << reference.why;
  EXPECT_THAT(reference.columns, ElementsAre("t", "week", "lat", "lon", "h", "skip", "skip", "skip",
                                             "roll", "pitch", "heading"));
}

TEST_F(RealLogs, FilesOfDocumentedFormatsNeedNoNames) {
  struct Case {
    const char* name;
    FileKind kind;
  };
  for (const Case& each : {Case{"heli-track/GPS.txt", FileKind::kGnss},
                           {"thor75/GPS.txt", FileKind::kGnss},
                           {"thor75/IMU.txt", FileKind::kImu},
                           {"walk/GPS.txt", FileKind::kGnss},
                           {"walk/IMU.txt", FileKind::kImu},
                           {"psins-car/GPS.txt", FileKind::kGnss},
                           {"psins-car/IMU.txt", FileKind::kImu},
                           {"inertialnav-testlog2/GPS.txt", FileKind::kGnss},
                           {"inertialnav-testlog2/IMU.txt", FileKind::kImu},
                           {"smrmsg/smrmsg.smrmsg", FileKind::kSmrmsg},
                           {"leeward/sbet.out", FileKind::kTrajectory},
                           {"tent/trajectory.txt", FileKind::kTrajectory},
                           {"laz/simple.laz", FileKind::kPointCloud}}) {
    SCOPED_TRACE(each.name);
    const FileContent content = InspectFile(Data(each.name));
    EXPECT_EQ(content.kind, each.kind) << content.why;
    EXPECT_THAT(content.columns, IsEmpty());
  }
}

}  // namespace dn::files_test
