#include <dn/geo/accuracy_series.h>
#include <dn/geo/local_frame.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "testing/expect_invalid.h"
#include "testing/temp_folder.h"

namespace dn::geo_test {

using Eigen::Vector3d;
using testing::ExpectInvalidIn;
using testing::TempFolder;

// Returns the bytes with the least significant byte first on any machine.
std::string LittleEndian(const std::vector<double>& values) {
  std::string bytes;
  for (const double value : values) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    for (int i = 0; i < 8; ++i) bytes.push_back(static_cast<char>(bits >> (8 * i)));
  }
  return bytes;
}

// North, east, down: 1, 2, 3 cm; roll, pitch, heading: 0.6, 0.9, 3 arc minutes.
const std::vector<double> kFirst{381000, 0.01, 0.02, 0.03, 1, 1, 1, 0.6, 0.9, 3.0};
const std::vector<double> kSecond{381010, 0.03, 0.02, 0.03, 1, 1, 1, 0.6, 0.9, 1.0};

void Expect(const EpochAccuracy& epoch, const Vector3d& sigma_ned_m, const Vector3d& rph_deg) {
  EXPECT_LE((epoch.sigma_ned_m - sigma_ned_m).norm(), 1e-14);
  EXPECT_LE((epoch.sigma_rph_rad - rph_deg * kRadPerDeg).norm(), 1e-14);
}

TEST(AccuracySeries, ReadsSmrmsgInArcMinutes) {
  TempFolder folder;
  folder.Write("smrmsg_7.out", LittleEndian(kFirst) + LittleEndian(kSecond));
  const AccuracySeries series(folder.path() / "smrmsg_7.out");
  Expect(series.At(381000), {0.01, 0.02, 0.03}, {0.01, 0.015, 0.05});
  Expect(series.At(381005), {0.02, 0.02, 0.03}, {0.01, 0.015, 0.1 / 3.0});
  Expect(series.At(381010), {0.03, 0.02, 0.03}, {0.01, 0.015, 1.0 / 60.0});
}

TEST(AccuracySeries, ReadsTextInEastNorthUpAndDegrees) {
  TempFolder folder;
  folder.Write("sigma.txt", "381000, 0.02, 0.01, 0.03, 1, 1, 1, 0.01, 0.015, 0.05\n");
  Expect(AccuracySeries(folder.path() / "sigma.txt").At(381000), {0.01, 0.02, 0.03},
         {0.01, 0.015, 0.05});
}

// The content decides, not the ending of the name.
TEST(AccuracySeries, AnyEnding) {
  for (const char* name : {"smrmsg.OUT", "SMRMSG.Out", "a.smrmsg", "a.bin", "a.txt", "a"}) {
    SCOPED_TRACE(name);
    TempFolder folder;
    folder.Write(name, LittleEndian(kFirst) + LittleEndian(kSecond));
    Expect(AccuracySeries(folder.path() / name).At(381000), {0.01, 0.02, 0.03},
           {0.01, 0.015, 0.05});
  }
  for (const char* name : {"sigma.TXT", "sigma.csv", "sigma.out"}) {
    SCOPED_TRACE(name);
    TempFolder folder;
    folder.Write(name, "381000, 0.02, 0.01, 0.03, 1, 1, 1, 0.01, 0.015, 0.05\n");
    Expect(AccuracySeries(folder.path() / name).At(381000), {0.01, 0.02, 0.03},
           {0.01, 0.015, 0.05});
  }
}

TEST(AccuracySeries, BadFilesAreNamed) {
  const auto expect = [](const std::string& content, const std::string& what) {
    TempFolder folder;
    folder.Write("smrmsg.out", content);
    ExpectInvalidIn([&] { AccuracySeries(folder.path() / "smrmsg.out"); }, what, "smrmsg.out");
  };
  expect("", "no rows of numbers");
  expect(LittleEndian(kFirst) + "abc", "record 2 has 3 of 80 bytes");
  std::vector<double> bad = kSecond;
  bad[8] = std::numeric_limits<double>::quiet_NaN();
  expect(LittleEndian(kFirst) + LittleEndian(bad), "rms of pitch of smrmsg record 2");
  bad[8] = 0.0;
  expect(LittleEndian(kFirst) + LittleEndian(bad), "record 2 is not positive");
  bad[8] = 1e200;
  expect(LittleEndian(kFirst) + LittleEndian(bad), "record 2 exceeds");
  expect(LittleEndian(kSecond) + LittleEndian(kFirst), "does not increase");
}

TEST(AccuracySeries, SaysNothingOutsideOfItsEpochs) {
  TempFolder folder;
  folder.Write("smrmsg.out", LittleEndian(kFirst) + LittleEndian(kSecond));
  const AccuracySeries series(folder.path() / "smrmsg.out");
  ExpectInvalidIn([&] { series.At(380999); }, "lies outside", "smrmsg.out");
  ExpectInvalidIn([&] { series.At(381010.5); }, "lies outside", "smrmsg.out");
}

}  // namespace dn::geo_test
