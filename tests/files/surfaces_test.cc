#include <dn/files/flight.h>
#include <dn/files/surfaces.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "testing/expect_invalid.h"
#include "testing/temp_folder.h"

namespace dn::files_test {
namespace {

using testing::ExpectInvalid;
using testing::TempFolder;

FlightConfig Parse(const TempFolder& folder, const std::string& lidar) {
  return ParseFlightConfig("lidar:\n" + lidar, folder.path());
}

TEST(Surfaces, AreReadAsPlanesOfUnknownPosition) {
  const TempFolder folder;
  folder.Write("surfaces/a.txt",
               "100.5, 200.5, 1, 2, 300, 4, 5, 300, 0, 0.6, 0.8, 0.02\n"
               "101.5, 201.5, 1, 2, 300, 4, 5, 300, 0, 0, 1, 0.02\n");
  const FlightConfig config = Parse(
      folder, "  sigma_p_m: 0.05\n  time_offset_s: 0.5\n  surface_pairs: ['surfaces/*.txt']\n");
  const ControlData surfaces = ReadSurfaces(config);
  ASSERT_EQ(surfaces.points.size(), 2u);
  const ControlPoint& surface = surfaces.points[0];
  EXPECT_TRUE(surface.name.ends_with("surfaces/a.txt:1")) << surface.name;
  EXPECT_NEAR((surface.plane->normal_m - Eigen::Vector3d(0, 0.6, 0.8)).norm(), 0.0, 1e-15);
  ASSERT_EQ(surface.returns.size(), 2u);
  EXPECT_EQ(surface.returns[0].t_s, 100.0);
  EXPECT_EQ(surface.returns[1].t_s, 200.0);
  // The variance of the distance is that of both returns.
  EXPECT_NEAR(*surface.returns[0].sigma_m, 0.02 / std::sqrt(2.0), 1e-15);
}

TEST(Surfaces, AFlightWithoutThemHasNone) {
  const TempFolder folder;
  EXPECT_TRUE(ReadSurfaces(Parse(folder, "  sigma_p_m: 0.05\n")).points.empty());
}

TEST(Surfaces, TheResolvedConfigurationNamesThem) {
  const TempFolder folder;
  const FlightConfig config = Parse(folder, "  sigma_p_m: 0.05\n  surface_pairs: [s/*.txt]\n");
  EXPECT_THAT(FormatFlightConfig(config), ::testing::HasSubstr("surface_pairs: [\"s/*.txt\"]"));
}

TEST(Surfaces, AreRefusedForOtherScanners) {
  const TempFolder folder;
  const std::string scanner = "{sigma_p_m: 0.05, surface_pairs: [s.txt]";
  ExpectInvalid(
      [&] { ParseFlightConfig("lidar: " + scanner + ", beams: {count: 16}}\n", folder.path()); },
      "needs a scanner with one beam", 1);
  ExpectInvalid([&] { ParseFlightConfig("lidar: [" + scanner + "}]\n", folder.path()); },
                "surface_pairs", 1);
}

}  // namespace
}  // namespace dn::files_test
