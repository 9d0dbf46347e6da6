#include <dn/files/across.h>
#include <gtest/gtest.h>

#include "testing/temp_folder.h"

namespace dn::files_test {

AcrossConfig Across(const std::string& yaml) {
  return ParseAcross(ParseYaml("across: " + yaml + "\n", "flight.yaml")["across"]);
}

TEST(Across, IsOneConstantBoresightUnlessStated) {
  EXPECT_EQ(Across("~"), AcrossConfig());
  EXPECT_EQ(Across("[boresight]"), AcrossConfig());
  EXPECT_EQ(Across("boresight"), AcrossConfig());
}

TEST(Across, ReadsBack) {
  for (const char* text : {"[boresight]", "[boresight, lidar_lever_arm, lidar_range_offset]",
                           "[{unknown: boresight, random_walk_deg: estimate}]",
                           "[{unknown: boresight, random_walk_deg: 0.25}, lidar_range_offset]"}) {
    EXPECT_EQ(FormatAcross(Across(text)), text);
  }
  EXPECT_DOUBLE_EQ(*Across("[{unknown: boresight, random_walk_deg: 180}]").walk_rad,
                   3.14159265358979323846);
}

TEST(Across, IsReadFromAFlight) {
  const testing::TempFolder folder;
  folder.Write("flight.yaml", "name: monday\nacross: [boresight, lidar_range_offset]\n");
  EXPECT_EQ(ReadAcross(folder.path()).unknowns, std::vector<std::string>{"lidar_range_offset"});
}

}  // namespace dn::files_test
