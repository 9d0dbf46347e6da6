#include <dn/files/file_content.h>
#include <dn/files/file_units.h>
#include <dn/files/flight.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "testing/expect_invalid.h"
#include "testing/temp_folder.h"

namespace dn::files_test {

using testing::ExpectInvalid;
using ::testing::HasSubstr;
using testing::TempFolder;

FlightConfig ParseBeams(const std::string& beams) {
  return ParseFlightConfig("lidar: {sigma_p_m: 0.03, beams: " + beams + "}\n", "/flights/one");
}

TEST(Beams, HaveAnglesAndPriors) {
  const FlightConfig config =
      ParseBeams("{angles_deg: [-15, 1, -13], angle_sigma_deg: 0.05, range_offset_sigma_m: 0}");
  const BeamConfig& beams = *config.lidar->beams;
  EXPECT_EQ(beams.count, 3u);
  EXPECT_DOUBLE_EQ(beams.angles_rad[0], RadFromDeg(-15.0));
  EXPECT_DOUBLE_EQ(beams.angle_sigma_rad, RadFromDeg(0.05));
  EXPECT_EQ(beams.range_sigma_m, 0.0);
  const FlightConfig again = ParseFlightConfig(FormatFlightConfig(config), "/flights/one");
  EXPECT_EQ(again.lidar->beams->angles_rad, beams.angles_rad);
  EXPECT_EQ(again.lidar->beams->angle_sigma_rad, beams.angle_sigma_rad);
  EXPECT_EQ(again.lidar->beams->range_sigma_m, 0.0);
}

TEST(Beams, AScannerWithoutThemIsFormattedWithoutThem) {
  const FlightConfig config = ParseFlightConfig("lidar: {sigma_p_m: 0.03}\n", "/flights/one");
  EXPECT_FALSE(config.lidar->beams);
  EXPECT_THAT(FormatFlightConfig(config), ::testing::Not(HasSubstr("beams")));
}

TEST(Beams, AnglesMayBeUnknown) {
  const FlightConfig config = ParseBeams("{count: 16}");
  EXPECT_EQ(config.lidar->beams->count, 16u);
  EXPECT_TRUE(config.lidar->beams->angles_rad.empty());
  const FlightConfig again = ParseFlightConfig(FormatFlightConfig(config), "/flights/one");
  EXPECT_EQ(again.lidar->beams->count, 16u);
}

TEST(Beams, MistakesAreNamed) {
  const auto refused = [](const char* beams, const char* why) {
    ExpectInvalid([&] { ParseBeams(beams); }, why, 1);
  };
  refused("{}", "angles_deg");
  refused("{angles_deg: []}", "two beams");
  refused("{angles_deg: 3}", "angles_deg");
  refused("{angles_deg: [1]}", "two beams");
  refused("{angles_deg: [0, 90]}", "between -90 and 90");
  refused("{angles_deg: [0, .nan]}", "angles_deg");
  refused("{count: 1}", "count");
  refused("{count: 1025}", "at most 1024");
  refused("{count: 3, angles_deg: [0, 1]}", "number of angles_deg, 2");
  refused("{count: 2, angle_sigma_deg: -1}", "angle_sigma_deg");
  refused("{count: 2, angle_sigma_deg: 6}", "at most 5");
  refused("{count: 2, range_offset_sigma_m: 2}", "at most 1");
  refused("{count: 2, angles: [1, 2]}", "angles_deg");
}

/// Reads a flight with one pair; both ends have 10 deg toward the scan axis x.
LidarPair ReadPair(const std::string& beams, const std::string& columns) {
  const TempFolder folder;
  folder.Write("flight.yaml", "lidar: {sigma_p_m: 0.03, beams: " + beams + "}\n");
  folder.Write("LiDAR_p2p.txt", "100.5, 200.25, 17.36, 0, 98.48, 17.36, 0, 98.48" + columns + "\n");
  return ReadFlight(folder.path(), {.pairs = true}).pairs->pairs.front();
}

TEST(Beams, OfPairsAreCheckedAgainstTheScanner) {
  const auto refused = [](const char* beams, const char* columns, const char* why, long line) {
    ExpectInvalid([&] { ReadPair(beams, columns); }, why, line);
  };
  refused("{count: 2}", ", 0, 2", "beam 2 does not exist", 1);
  refused("{count: 2}", "", "no pair has a beam", 0);
  refused("{angles_deg: [10, -10]}", ", 0, 1", "beam 1 are on average 10 deg", 0);
  EXPECT_EQ(ReadPair("{angles_deg: [10.5, 9.5]}", ", 0, 1").beam_j, 1);
  EXPECT_EQ(ReadPair("~", ", 0, 1").beam_j, 1);
}

// Positions with velocities have as many columns as pairs with beams.
TEST(Beams, PairsWithThemAreRecognised) {
  const TempFolder folder;
  std::string pairs, positions;
  for (int k = 0; k < 20; ++k) {
    const std::string t_s = std::to_string(381000 + k);
    pairs += t_s + ", " + std::to_string(381100 + k) + ", 1, 2, 90.5, 3, 4, 91.5, 3, -1\n";
    positions += t_s + ", 46.57, 6.52, 431.2, 20.1, 0.2, 0.1, 0.01, 0.01, 0.02\n";
  }
  folder.Write("pairs.txt", pairs);
  folder.Write("positions.txt", positions);
  EXPECT_EQ(InspectFile(folder.path() / "pairs.txt").kind, FileKind::kPairs);
  EXPECT_EQ(InspectFile(folder.path() / "positions.txt").kind, FileKind::kGnss);
}

}  // namespace dn::files_test
