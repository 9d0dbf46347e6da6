#include <dn/files/flight.h>

#include <map>
#include <set>

#include "testing/expect_invalid.h"

namespace dn::files_test {

using testing::ExpectInvalid;
using Strategy = PairSelection::Strategy;

/// Appends `count` pairs of a file, one every `step_s` from t0_s on.
void Append(int file, int count, double t0_s, double step_s, std::vector<LidarPair>& pairs) {
  for (int i = 0; i < count; ++i) {
    LidarPair pair;
    pair.file = file;
    pair.t_i_s = t0_s + i * step_s;
    pair.t_j_s = pair.t_i_s + 1000.0;
    pair.line = i + 1;
    pairs.push_back(pair);
  }
}

std::map<int, int> CountByFile(const std::vector<LidarPair>& pairs) {
  std::map<int, int> counts;
  for (const LidarPair& pair : pairs) ++counts[pair.file];
  return counts;
}

std::vector<double> Times(const std::vector<LidarPair>& pairs) {
  std::vector<double> t_s;
  for (const LidarPair& pair : pairs) t_s.push_back(pair.t_i_s);
  return t_s;
}

std::vector<LidarPair> ThreeFiles() {
  std::vector<LidarPair> pairs;
  Append(0, 1000, 100.0, 0.1, pairs);
  Append(1, 20, 300.0, 5.0, pairs);
  Append(2, 500, 500.0, 0.2, pairs);
  return pairs;
}

PairSelection Max(long count, std::uint64_t seed) {
  PairSelection selection;
  selection.strategy = Strategy::kMax;
  selection.count = count;
  selection.seed = seed;
  return selection;
}

TEST(SelectPairs, AllKeepsEverything) {
  const std::vector<LidarPair> pairs = ThreeFiles();
  EXPECT_EQ(Times(SelectPairs(pairs, {})), Times(pairs));
}

TEST(SelectPairs, MaxGivesFilesEqualSharesAndTheSmallOnesTheirAll) {
  const std::map<int, int> expected{{0, 140}, {1, 20}, {2, 140}};
  EXPECT_EQ(CountByFile(SelectPairs(ThreeFiles(), Max(300, 1))), expected);
}

TEST(SelectPairs, MaxKeepsAllWhenThereAreFewer) {
  EXPECT_EQ(SelectPairs(ThreeFiles(), Max(100000, 1)).size(), 1520u);
}

TEST(SelectPairs, MaxSpreadsOverTime) {
  std::vector<LidarPair> pairs;
  Append(0, 1000, 0.0, 0.1, pairs);
  const std::vector<LidarPair> kept = SelectPairs(pairs, Max(10, 3));
  ASSERT_EQ(kept.size(), 10u);
  for (int i = 0; i < 10; ++i) {  // one in each tenth of the 100 s
    EXPECT_EQ(static_cast<int>(kept[static_cast<std::size_t>(i)].t_i_s / 10.0), i);
  }
}

TEST(SelectPairs, TheSeedDecides) {
  const std::vector<LidarPair> pairs = ThreeFiles();
  const auto first = Times(SelectPairs(pairs, Max(100, 1)));
  EXPECT_EQ(first, Times(SelectPairs(pairs, Max(100, 1))));
  EXPECT_NE(first, Times(SelectPairs(pairs, Max(100, 2))));
}

TEST(SelectPairs, KeepsNoPairTwiceAndTheirOrder) {
  const std::vector<LidarPair> kept = SelectPairs(ThreeFiles(), Max(700, 5));
  std::set<std::pair<int, long>> seen;
  int last_file = 0;
  for (const LidarPair& pair : kept) {
    EXPECT_TRUE(seen.insert({pair.file, pair.line}).second);
    EXPECT_GE(pair.file, last_file);
    last_file = pair.file;
  }
}

TEST(SelectPairs, FreqKeepsThePairsNearestToTheRaster) {
  std::vector<LidarPair> pairs;
  for (const double t_s : {11.3, 10.0, 10.45, 10.9, 11.05, 14.2, 12.6}) {
    Append(0, 1, t_s, 1.0, pairs);
  }
  PairSelection selection;
  selection.strategy = Strategy::kFreq;
  selection.freq_hz = 1.0;
  // Ticks 10, 11, 12 (no pair within half a second), 13, 14; the pairs keep the order of the file.
  EXPECT_EQ(Times(SelectPairs(pairs, selection)), (std::vector<double>{10.0, 11.05, 14.2, 12.6}));
}

TEST(SelectPairs, FreqWorksPerFile) {
  PairSelection selection;
  selection.strategy = Strategy::kFreq;
  selection.freq_hz = 1.0;
  const std::map<int, int> counts = CountByFile(SelectPairs(ThreeFiles(), selection));
  EXPECT_NEAR(counts.at(0), 100, 1);  // the last tick may be later than the last pair
  EXPECT_EQ(counts.at(1), 20);
  EXPECT_NEAR(counts.at(2), 100, 1);
}

TEST(SelectPairs, TimeWindowKeepsOneInEachWindowThatHoldsAny) {
  std::vector<LidarPair> pairs;
  Append(0, 50, 0.0, 0.1, pairs);
  Append(0, 50, 20.0, 0.1, pairs);
  PairSelection selection;
  selection.strategy = Strategy::kTimeWindow;
  selection.window_s = 2.5;
  std::set<int> windows;
  const std::vector<LidarPair> kept = SelectPairs(pairs, selection);
  for (const LidarPair& pair : kept) windows.insert(static_cast<int>(pair.t_i_s / 2.5));
  EXPECT_EQ(kept.size(), 4u);
  EXPECT_EQ(windows, (std::set<int>{0, 1, 8, 9}));
}

TEST(SelectPairs, NothingFromNothing) { EXPECT_TRUE(SelectPairs({}, Max(5, 1)).empty()); }

TEST(SelectPairs, RejectsAStrategyWithoutItsParameter) {
  PairSelection selection;
  selection.strategy = Strategy::kMax;
  ExpectInvalid([&] { SelectPairs({}, selection); }, "max needs a count", 0);
  selection.strategy = Strategy::kFreq;
  selection.freq_hz = 0.0;
  ExpectInvalid([&] { SelectPairs({}, selection); }, "freq needs freq_hz", 0);
  selection.strategy = Strategy::kTimeWindow;
  ExpectInvalid([&] { SelectPairs({}, selection); }, "time_window needs window_s", 0);
}

}  // namespace dn::files_test
