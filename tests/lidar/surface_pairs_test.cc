#include <dn/lidar/surface_pairs.h>

#include "testing/expect_invalid.h"
#include "testing/temp_folder.h"

namespace dn::lidar_test {

using testing::ExpectInvalid;
using testing::TempFolder;

constexpr const char* kRow = "100.5, 200.25, 1, 2, 300, 4, 5, 300, 0, 0, 2, 0.01\n";

TEST(SurfacePairs, AreReadAndWritten) {
  const TempFolder folder;
  folder.Write("a.txt", std::string("# comment\n") + kRow);
  const SurfacePairData data = ReadSurfacePairs(folder.path(), {"*.txt"}, 0.5);
  ASSERT_EQ(data.pairs.size(), 1u);
  const SurfacePair& pair = data.pairs[0];
  EXPECT_EQ(pair.ends.t_i_s, 100.0);
  EXPECT_EQ(pair.ends.t_j_s, 199.75);
  EXPECT_EQ(pair.ends.u_j_s, Eigen::Vector3d(4, 5, 300));
  EXPECT_EQ(pair.ends.line, 2);
  EXPECT_EQ(pair.normal_m, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(pair.sigma_m, 0.01);
  folder.Write("b.csv", FormatSurfacePairs(data.pairs));
  const SurfacePairData again = ReadSurfacePairs(folder.path(), {"b.csv"});
  EXPECT_EQ(again.pairs[0].ends.u_i_s, pair.ends.u_i_s);
  EXPECT_EQ(again.pairs[0].normal_m, pair.normal_m);
  EXPECT_EQ(again.pairs[0].sigma_m, pair.sigma_m);
}

TEST(SurfacePairs, ARepeatedOneCountsOnce) {
  const TempFolder folder;
  folder.Write("a.txt", kRow);
  folder.Write("b.txt", "200.25, 100.5, 4, 5, 300, 1, 2, 300, 0, 0, 1, 0.01\n");
  const SurfacePairData data = ReadSurfacePairs(folder.path(), {"*.txt"});
  EXPECT_EQ(data.pairs.size(), 1u);
  EXPECT_EQ(data.repeated_pairs_dropped, 1);
}

TEST(SurfacePairs, BadRowsAreNamedWithTheirLine) {
  const TempFolder folder;
  const auto expect = [&](const std::string& row, const std::string& what) {
    folder.Write("a.txt", std::string(kRow) + row);
    ExpectInvalid([&] { ReadSurfacePairs(folder.path(), {"a.txt"}); }, what, 2);
  };
  expect("100.5, 200.25, 1, 2, 300, 4, 5, 300, 0, 0, 0, 0.01\n", "has no length");
  expect("100.5, 200.25, 1, 2, 300, 4, 5, 300, 0, 0, 1, 0\n", "sigma of the surface pair");
  expect("100.5, 200.25, 1, 2, 300, 4, 5, 300, 0, 0, 1, 2e3\n", "sigma of the surface pair");
  expect("100.5, 200.25, 0, 0, 0, 4, 5, 300, 0, 0, 1, 0.01\n", "zero length");
  expect("1e9, 200.25, 1, 2, 300, 4, 5, 300, 0, 0, 1, 0.01\n", "week");
}

}  // namespace dn::lidar_test
