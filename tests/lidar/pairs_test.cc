#include <dn/lidar/pairs.h>
#include <sys/stat.h>

#include <filesystem>

#include "testing/expect_invalid.h"
#include "testing/temp_folder.h"

namespace dn::lidar_test {

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

TEST(ReadPairs, ReadsTheBeamsOfTheTwoEnds) {
  const TempFolder folder;
  folder.Write("a.txt", "100.5, 200.25, 1, 2, 3, 4, 5, 6, 0, 31\n");
  folder.Write("b.txt", std::string(kFull).substr(0, std::string(kFull).size() - 1) + ", -1, 7\n");
  folder.Write("c.txt", kPlain);
  const PairData plain = ReadPairs(folder.path(), {"c.txt"});
  EXPECT_FALSE(plain.pairs[0].has_beams());
  const PairData data = ReadPairs(folder.path(), {"a.txt"});
  EXPECT_EQ(data.pairs[0].beam_i, 0);
  EXPECT_EQ(data.pairs[0].beam_j, 31);
  EXPECT_FALSE(data.pairs[0].covariance_m2);
  const PairData full = ReadPairs(folder.path(), {"b.txt"});
  EXPECT_EQ(full.pairs[0].beam_i, kNoBeam);
  EXPECT_EQ(full.pairs[0].beam_j, 7);
  EXPECT_EQ((*full.pairs[0].covariance_m2)(2, 2), 0.16);
  folder.Write("d.txt", FormatPairs(full.pairs));
  EXPECT_EQ(ReadPairs(folder.path(), {"d.txt"}).pairs[0].beam_j, 7);
}

TEST(ReadPairs, ABeamIsANumberFromMinusOneTo1023) {
  for (const char* beam : {"1024", "-2", "0.5", "1e9"}) {
    const TempFolder folder;
    folder.Write("a.txt", "100.5, 200.25, 1, 2, 3, 4, 5, 6, 1, " + std::string(beam) + "\n");
    ExpectInvalid([&] { ReadPairs(folder.path(), {"a.txt"}); }, "is not an integer from -1", 1);
  }
}

TEST(ReadPairs, TakesFilesOfAPatternInSortedOrderEachOnce) {
  const TempFolder folder;
  int row = 0;
  for (const char* name : {"lidar/2_3.txt", "lidar/1_2.txt", "lidar/1_3.txt"}) {
    folder.Write(name, std::to_string(++row) + ", 200.25, 1, 2, 3, 4, 5, 6\n");
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

TEST(ReadPairs, CountsEqualPairsOnceWhereverTheyStand) {
  const TempFolder folder;
  const std::string a = "100.5, 200.25, 1, 2, 3, 4, 5, 6\n";
  const std::string b = "100.5, 200.25, 1, 2, 3, 4, 5, 7\n";
  const std::string a_swapped = "200.25, 100.5, 4, 5, 6, 1, 2, 3\n";
  folder.Write("p.txt", b + a + a_swapped + a);
  folder.Write("q.txt", "# the same rows\n" + a + b);
  std::filesystem::create_symlink("p.txt", folder.path() / "link.txt");
  std::filesystem::create_hard_link(folder.path() / "p.txt", folder.path() / "hard.txt");
  const PairData one = ReadPairs(folder.path(), {"p.txt"});
  ASSERT_EQ(one.pairs.size(), 2u);
  EXPECT_EQ(one.pairs[0].u_j_s.z(), 7.0);  // the first of the equal pairs stays, in file order
  EXPECT_EQ(one.pairs[1].line, 2);
  EXPECT_EQ(one.repeated_pairs_dropped, 2);
  const PairData all = ReadPairs(folder.path(), {"*.txt", "./p.txt"});
  EXPECT_EQ(all.pairs.size(), 2u);
  EXPECT_EQ(all.repeated_pairs_dropped, 4 * 4 + 2 - 2);
  const PairData listed = ReadPairs(folder.path(), std::vector<std::string>(25, "q.txt"));
  EXPECT_EQ(listed.pairs.size(), 2u);
}

TEST(ReadPairs, RejectsFilesThatAreNotRegular) {
  const TempFolder folder;
  folder.Write("lidar/a.txt", kPlain);
  ASSERT_EQ(mkfifo((folder.path() / "lidar/pipe.txt").c_str(), 0600), 0);
  ExpectInvalid([&] { ReadPairs(folder.path(), {"lidar/*.txt"}); }, "a named pipe", 0);
  ExpectInvalid([&] { ReadPairs(folder.path(), {"lidar"}); }, "a folder, not a regular file", 0);
}

TEST(ReadPairs, AWildPatternPassesALinkToItselfBy) {
  const TempFolder folder;
  folder.Write("lidar/a.txt", kPlain);
  std::filesystem::create_symlink("b.txt", folder.path() / "lidar/b.txt");
  EXPECT_EQ(ReadPairs(folder.path(), {"lidar/*.txt"}).files.size(), 1u);
}

TEST(ReadPairs, NamesThePatternThatMatchesNothing) {
  const TempFolder folder;
  folder.Write("a.txt", kPlain);
  ExpectInvalid([&] { ReadPairs(folder.path(), {"a.txt", "lidar/*.txt"}); }, "'lidar/*.txt'", 0);
  ExpectInvalid([&] { ReadPairs(folder.path(), {}); }, "no file pattern", 0);
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
  expect("1, 2, 300000, 400000, 0, 1, 2, 3\n", "length 5e+05, must lie between 0.001 and 50000 m");
  expect("1, 2, 300000, 400000, 0, 1, 2, 3\n", "in millimetres? Divide it by 1000");
  expect("1, 2, 1e-5, 0, 0, 1, 2, 3\n", "in kilometres? Multiply it by 1000");
  expect("1, 2, 1e200, 1e200, 0, 1, 2, 3\n", "e+200, must lie between");
  expect("381000250, 2, 1, 2, 3, 1, 2, 3\n", "milliseconds? Divide it by 1000");
  expect("1, 381000250, 1, 2, 3, 1, 2, 3\n", "milliseconds? Divide it by 1000");
  expect("1, 2, 1, 2, 3, 4, 5, 6, 1e-200, 0, 0, 1e-200, 0, 1e-200\n", "is it in m^2?");
  expect("1, 2, 1, 2, 3, 4, 5\n", "8");
  expect("1, 2, 1, 2, 3, 4, 5, x\n", "x");
  expect("1, 2, 1, 2, 3, 4, 5, nan\n", "nan");
  expect("1, 2, 1, 2, 3, 4, 5, 6, 1, 2, 0, 1, 0, 1\n", "not positive definite");
  expect("1, 2, 1, 2, 3, 4, 5, 6, 0, 0, 0, 0, 0, 0\n", "not positive definite");
  for (const char* cell : {"1e308", "-1e308", "1e155"}) {
    const std::string start = "1, 2, 1, 2, 3, 4, 5, 6, 1e-4, ";
    expect(start + cell + ", 0, 1e-4, 0, 1e-4\n", "not positive definite");
    expect(start + "0, " + cell + ", 1e-4, 0, 1e-4\n", "not positive definite");
    expect(start + "0, 0, 1e-4, " + cell + ", 1e-4\n", "not positive definite");
    expect(start + cell + ", " + cell + ", 1e-4, 0, 1e-4\n", "not positive definite");
  }
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
  pair.u_j_s = Eigen::Vector3d(2.0 / 7.0, 1e4, -123.527340000000001);
  pair.covariance_m2 = Eigen::Matrix3d(Eigen::Vector3d(1.0 / 3.0, 0.1, 0.7).asDiagonal());
  LidarPair other = pair;
  other.t_i_s = 1.0;
  folder.Write("a.txt", FormatPairs({other, pair}));
  const PairData data = ReadPairs(folder.path(), {"a.txt"});
  ASSERT_EQ(data.pairs.size(), 2u);
  EXPECT_EQ(data.pairs[1].t_i_s, pair.t_i_s);
  EXPECT_EQ(data.pairs[1].t_j_s, pair.t_j_s);
  EXPECT_EQ(data.pairs[1].u_i_s, pair.u_i_s);
  EXPECT_EQ(data.pairs[1].u_j_s, pair.u_j_s);
  EXPECT_EQ(*data.pairs[1].covariance_m2, *pair.covariance_m2);
}

TEST(PairOrigin, IsMeasuredUnlessALineSaysOtherwise) {
  const TempFolder folder;
  const VectorOrigin recorded{VectorOrigin::Kind::kRecorded, {0.1, -0.2, 1.0 / 3.0}};
  const VectorOrigin assumed{VectorOrigin::Kind::kAssumed, {0.0, 0.0, 0.0}};
  LidarPair pair;
  pair.u_i_s = pair.u_j_s = Eigen::Vector3d(1, 2, 3);
  const auto text = [&](double t_i_s, const VectorOrigin& origin) {
    pair.t_i_s = t_i_s;
    return FormatPairs({pair}, origin);
  };
  folder.Write("1.txt", text(1.0, {}));
  folder.Write("2.txt", text(2.0, recorded));
  folder.Write("3.txt", text(3.0, {}) + text(4.0, assumed) + text(5.0, recorded));  // joined
  const PairData data = ReadPairs(folder.path(), {"*.txt"});
  ASSERT_EQ(data.origins.size(), 3u);
  EXPECT_EQ(data.origins[0].kind, VectorOrigin::Kind::kMeasured);
  EXPECT_EQ(data.origins[1].kind, VectorOrigin::Kind::kRecorded);
  EXPECT_LT((data.origins[1].boresight_rad - recorded.boresight_rad).norm(), 1e-15);
  EXPECT_EQ(data.origins[2].kind, VectorOrigin::Kind::kAssumed);
  EXPECT_EQ(data.pairs.size(), 5u);
}

TEST(PairOrigin, ADamagedLineIsNamed) {
  for (const char* rest : {"0, 0, 0 deg: guessed", "0, 0 deg: assumed", "0, 0, 0, 0 deg: assumed",
                           "0, 0, x deg: assumed", "0, 0, 0"}) {
    const TempFolder folder;
    folder.Write("a.txt",
                 std::string(kPlain) + "# laser vectors computed with boresight " + rest + "\n");
    ExpectInvalid([&] { ReadPairs(folder.path(), {"a.txt"}); }, "", 2);
  }
}

}  // namespace dn::lidar_test
