#include <dn/files/strip_files.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "testing/expect_invalid.h"
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

}  // namespace dn::files_test
