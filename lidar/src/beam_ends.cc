#include <dn/lidar/beam_ends.h>

#include <algorithm>

namespace dn {

bool BeamEnds::any() const { return without_beam > 0 || NumMeasuredBeams(of_beam) > 0; }

BeamEnds CountBeamEnds(const std::vector<LidarPair>& pairs, std::size_t scanner,
                       std::size_t beams) {
  BeamEnds ends;
  ends.of_beam.resize(beams);
  const auto count = [&](int measured_by, int beam) {
    if (measured_by != static_cast<int>(scanner)) return;
    if (beam == kNoBeam) {
      ++ends.without_beam;
      return;
    }
    const auto k = static_cast<std::size_t>(beam);
    if (ends.of_beam.size() <= k) ends.of_beam.resize(k + 1);
    ++ends.of_beam[k];
  };
  for (const LidarPair& pair : pairs) {
    count(pair.scanner_i, pair.beam_i);
    count(pair.scanner_j, pair.beam_j);
  }
  return ends;
}

std::size_t NumMeasuredBeams(const std::vector<long>& ends_of_beam) {
  return static_cast<std::size_t>(
      std::count_if(ends_of_beam.begin(), ends_of_beam.end(), [](long ends) { return ends > 0; }));
}

}  // namespace dn
