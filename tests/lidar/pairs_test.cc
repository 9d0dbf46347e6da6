#include <dn/lidar/pairs.h>

#include "testing/expect_invalid.h"
#include "testing/temp_folder.h"

namespace dn {
namespace {

using ::testing::ElementsAre;
using testing::ExpectInvalid;
using testing::TempFolder;

const char* const kPlain = "100.5, 200.25, 1, 2, 3, 4, 5, 6\n";
const char* const kFull = "100.5, 200.25, 1, 2, 3, 4, 5, 6, 0.04, 0.01, 0, 0.09, 0.02, 0.16\n";

TEST(ReadPairs, ReadsTheEightColumns) {
  const TempFolder folder;
  folder.Write("LiDAR_p2p.txt", std::string("# comment\n\n") + kPlain);
  const PairData data = ReadPairs(folder.path(), {"LiDAR_p2p.txt"});
  ASSERT_EQ(data.pairs.size(), 1u);
  const LidarPair& pair = data.pairs[0];
  EXPECT_EQ(pair.t_i_s, 100.5);
  EXPECT_EQ(pair.t_j_s, 200.25);
  EXPECT_EQ(pair.u_i_s, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(pair.u_j_s, Eigen::Vector3d(4, 5, 6));
  EXPECT_FALSE(pair.covariance_m2);
  EXPECT_EQ(pair.line, 3);
}

TEST(ReadPairs, ReadsTheCovarianceByItsUpperTriangle) {
  const TempFolder folder;
  folder.Write("a.txt", kFull);
  const PairData data = ReadPairs(folder.path(), {"a.txt"});
  Eigen::Matrix3d expected;
  expected << 0.04, 0.01, 0, 0.01, 0.09, 0.02, 0, 0.02, 0.16;
  ASSERT_TRUE(data.pairs[0].covariance_m2);
  EXPECT_EQ(*data.pairs[0].covariance_m2, expected);
}

TEST(ReadPairs, TakesFilesOfAPatternInSortedOrderEachOnce) {
  const TempFolder folder;
  for (const char* name : {"lidar/2_3.txt", "lidar/1_2.txt", "lidar/1_3.txt"}) {
    folder.Write(name, kPlain);
  }
  folder.Write("lidar/notes.md", "not a pair file");
  const PairData data = ReadPairs(folder.path(), {"lidar/*.txt", "lidar/1_?.txt"});
  std::vector<std::string> names;
  for (const auto& file : data.files) names.push_back(file.filename().string());
  EXPECT_THAT(names, ElementsAre("1_2.txt", "1_3.txt", "2_3.txt"));
  ASSERT_EQ(data.pairs.size(), 3u);
  EXPECT_EQ(data.pairs[2].file, 2);
}

TEST(ReadPairs, ExpandsPatternsInFolderNamesAndTakesTheFlightFolderLiterally) {
  const TempFolder folder;
  folder.Write("flight [1]/day_a/p.txt", kPlain);
  folder.Write("flight [1]/day_b/p.txt", kPlain);
  EXPECT_EQ(ReadPairs(folder.path() / "flight [1]", {"day_[ab]/*.txt"}).files.size(), 2u);
}

TEST(ReadPairs, NeedsNoOrderOfTimes) {
  const TempFolder folder;
  folder.Write("a.txt", "300, 5, 1, 0, 0, 1, 0, 0\n100, 400, 1, 0, 0, 1, 0, 0\n");
  EXPECT_EQ(ReadPairs(folder.path(), {"a.txt"}).pairs[0].t_i_s, 300.0);
}

TEST(ReadPairs, NamesThePatternThatMatchesNothing) {
  const TempFolder folder;
  folder.Write("a.txt", kPlain);
  ExpectInvalid([&] { ReadPairs(folder.path(), {"a.txt", "lidar/*.txt"}); }, "'lidar/*.txt'", 0);
  ExpectInvalid([&] { ReadPairs(folder.path(), {}); }, "no pattern", 0);
}

TEST(ReadPairs, NamesTheLineOfBadData) {
  const TempFolder folder;
  const auto expect = [&](const std::string& row, const std::string& what) {
    SCOPED_TRACE(row);
    folder.Write("a.txt", "# header\n" + row);
    ExpectInvalid([&] { ReadPairs(folder.path(), {"a.txt"}); }, what, 2);
  };
  expect("1, 2, 0, 0, 0, 1, 2, 3\n", "zero length");
  expect("1, 2, 1, 2, 3, 0, 0, 0\n", "zero length");
  expect("1, 2, 1, 2, 3, 4, 5\n", "8");
  expect("1, 2, 1, 2, 3, 4, 5, x\n", "x");
  expect("1, 2, 1, 2, 3, 4, 5, nan\n", "nan");
  expect("1, 2, 1, 2, 3, 4, 5, 6, 1, 2, 0, 1, 0, 1\n", "not positive definite");
  expect("1, 2, 1, 2, 3, 4, 5, 6, 0, 0, 0, 0, 0, 0\n", "not positive definite");
}

TEST(ReadPairs, RejectsAnEmptyFile) {
  const TempFolder folder;
  folder.Write("a.txt", "");
  EXPECT_THROW(ReadPairs(folder.path(), {"a.txt"}), InvalidInput);
}

TEST(FormatPairs, RoundTripsEveryBit) {
  const TempFolder folder;
  LidarPair pair;
  pair.t_i_s = 381263.24940880001;
  pair.t_j_s = 0.1 + 0.2;
  pair.u_i_s = Eigen::Vector3d(1.0 / 3.0, -1e-17, 216.55663);
  pair.u_j_s = Eigen::Vector3d(2.0 / 7.0, 1e5, -123.527340000000001);
  pair.covariance_m2 = Eigen::Matrix3d(Eigen::Vector3d(1.0 / 3.0, 0.1, 0.7).asDiagonal());
  folder.Write("a.txt", FormatPairs({pair, pair}));
  const PairData data = ReadPairs(folder.path(), {"a.txt"});
  ASSERT_EQ(data.pairs.size(), 2u);
  EXPECT_EQ(data.pairs[1].t_i_s, pair.t_i_s);
  EXPECT_EQ(data.pairs[1].t_j_s, pair.t_j_s);
  EXPECT_EQ(data.pairs[1].u_i_s, pair.u_i_s);
  EXPECT_EQ(data.pairs[1].u_j_s, pair.u_j_s);
  EXPECT_EQ(*data.pairs[1].covariance_m2, *pair.covariance_m2);
}

}  // namespace
}  // namespace dn
