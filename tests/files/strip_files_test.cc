#include <dn/files/flight_config.h>
#include <dn/files/strip_files.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "testing/expect_invalid.h"
#include "testing/las_bytes.h"
#include "testing/temp_folder.h"

namespace dn::files_test {

using testing::ExpectInvalidIn;
using ::testing::HasSubstr;

TEST(StripFiles, AreFoundByTheirEndings) {
  const testing::TempFolder folder;
  EXPECT_TRUE(FindStripFiles(folder.path()).empty());
  for (const char* name : {"b.las", "a.TXT", "c.laz", "D.LAS", "e.CSV", "d.ply", ".hidden.las"}) {
    folder.Write(std::string("strips/") + name, "");
  }
  std::vector<std::string> names;
  for (const auto& file : FindStripFiles(folder.path())) names.push_back(file.filename().string());
  EXPECT_EQ(names, (std::vector<std::string>{"D.LAS", "a.TXT", "b.las", "c.laz", "e.CSV"}));
}

TEST(StripFiles, ALinkToItselfIsNone) {
  const testing::TempFolder folder;
  folder.Write("strips/a.las", "");
  std::filesystem::create_symlink("b.las", folder.path() / "strips/b.las");
  std::filesystem::create_symlink("d.las", folder.path() / "strips/c.las");
  std::filesystem::create_symlink("c.las", folder.path() / "strips/d.las");
  EXPECT_EQ(FindStripFiles(folder.path()).size(), 1u);
}

TEST(StripCrsCheck, AContradictionIsNamed) {
  StripCrs utm;
  utm.epsg = 32632;
  utm.name = "utm:32n";
  EXPECT_EQ(CheckStripCrs(utm, "utm:32n", "a.las"), "");
  EXPECT_EQ(CheckStripCrs(utm, "epsg:32632", "a.las"), "");
  EXPECT_EQ(CheckStripCrs(utm, "none", "a.las"), "");
  ExpectInvalidIn([&] { CheckStripCrs(utm, "map", "a.las"); }, "write strips_crs: utm:32n",
                  "a.las");
  ExpectInvalidIn([&] { CheckStripCrs(utm, "utm:33n", "a.las"); }, "in EPSG:32632", "a.las");
  StripCrs albers;
  albers.epsg = 3005;
  ExpectInvalidIn([&] { CheckStripCrs(albers, "map", "a.las"); }, "convert them to UTM", "a.las");
  EXPECT_THAT(CheckStripCrs(albers, "utm:10n", "a.las"), HasSubstr("used as utm:10n"));
  EXPECT_EQ(CheckStripCrs({}, "map", "a.las"), "");
  utm.heights_from_geoid = true;
  EXPECT_THAT(CheckStripCrs(utm, "utm:32n", "a.las"), HasSubstr("used as ellipsoidal"));
}

/// A LAS file whose header names a system by its code.
std::string LasIn(std::uint16_t epsg) {
  testing::LasBytes las;
  las.points.resize(1);
  std::string keys(24, '\0');
  const std::uint16_t words[] = {1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, epsg};
  for (std::size_t k = 0; k < 12; ++k) testing::LasBytes::Put(words[k], 2 * k, &keys);
  las.vlrs = {{"LASF_Projection", 34735, keys}};
  return las.Build();
}

TEST(StripsCrs, IsWhatTheHeadersSayUnlessItIsStated) {
  const testing::TempFolder folder;
  folder.Write("flight.yaml", "name: x\n");
  const auto read = [&] { return ReadFlightConfig(folder.path(), {}).strips_crs; };
  EXPECT_EQ(read(), "map");
  folder.Write("strips/a.las", LasIn(2056));
  folder.Write("strips/b.las", LasIn(2056));
  EXPECT_EQ(read(), "epsg:2056");
  folder.Write("flight.yaml", "strips_crs: epsg:32632\n");
  EXPECT_EQ(read(), "utm:32n");
  folder.Write("flight.yaml", "name: x\n");
  folder.Write("strips/b.las", LasIn(32632));
  EXPECT_EQ(read(), "map");
  folder.Write("strips/b.las", "damaged");
  EXPECT_EQ(read(), "map");
}

}  // namespace dn::files_test
