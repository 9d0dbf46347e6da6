#include <dn/lidar/beam_ends.h>
#include <gtest/gtest.h>

namespace dn::lidar_test {

LidarPair BeamPair(int scanner_i, int beam_i, int scanner_j, int beam_j) {
  LidarPair pair;
  pair.scanner_i = scanner_i;
  pair.beam_i = beam_i;
  pair.scanner_j = scanner_j;
  pair.beam_j = beam_j;
  return pair;
}

TEST(BeamEnds, AreCountedForOneScanner) {
  const std::vector<LidarPair> pairs = {BeamPair(0, 1, 0, 3), BeamPair(0, 1, 1, 0),
                                        BeamPair(0, kNoBeam, 0, 0)};
  const BeamEnds ends = CountBeamEnds(pairs, 0, 5);
  EXPECT_EQ(ends.of_beam, (std::vector<long>{1, 2, 0, 1, 0}));
  EXPECT_EQ(ends.without_beam, 1);
  EXPECT_TRUE(ends.any());
  EXPECT_EQ(NumMeasuredBeams(ends.of_beam), 3U);
}

TEST(BeamEnds, BeamsBeyondTheStatedOnesAreCounted) {
  const BeamEnds ends = CountBeamEnds({BeamPair(0, 6, 0, kNoBeam)}, 0, 2);
  EXPECT_EQ(ends.of_beam, (std::vector<long>{0, 0, 0, 0, 0, 0, 1}));
}

TEST(BeamEnds, OfAnotherScannerAreNone) {
  const BeamEnds ends = CountBeamEnds({BeamPair(1, 0, 1, kNoBeam)}, 0, 2);
  EXPECT_FALSE(ends.any());
  EXPECT_EQ(NumMeasuredBeams(ends.of_beam), 0U);
}

}  // namespace dn::lidar_test
