#include "beam_ends.h"

#include <dn/files/scanners.h>
#include <fmt/format.h>

#include <algorithm>

namespace dn::apps {
namespace {

void Count(int beam, BeamEnds* beams) {
  if (beam == kNoBeam) {
    ++beams->without_beam;
    return;
  }
  const auto k = static_cast<std::size_t>(beam);
  if (beams->ends.size() <= k) beams->ends.resize(k + 1);
  ++beams->ends[k];
}

}  // namespace

std::size_t BeamEnds::NumMeasured() const {
  return static_cast<std::size_t>(
      std::count_if(ends.begin(), ends.end(), [](long count) { return count > 0; }));
}

std::vector<BeamEnds> CountBeamEnds(const Flight& flight) {
  std::vector<BeamEnds> all(NumScanners(flight.config));
  for (std::size_t k = 0; k < all.size(); ++k) {
    const LidarConfig& scanner = ScannerAt(flight.config, k);
    all[k].scanner = scanner.name;
    if (!scanner.beams) continue;
    all[k].stated = scanner.beams->count;
    all[k].ends.resize(all[k].stated);
  }
  for (const LidarPair& pair : flight.pairs->pairs) {
    Count(pair.beam_i, &all[static_cast<std::size_t>(pair.scanner_i)]);
    Count(pair.beam_j, &all[static_cast<std::size_t>(pair.scanner_j)]);
  }
  std::erase_if(all, [](const BeamEnds& beams) { return beams.ends.empty(); });
  return all;
}

std::string Words(const BeamEnds& beams) {
  const std::string of = beams.scanner.empty() ? "" : " of scanner " + beams.scanner;
  if (beams.NumMeasured() == 0) {
    return fmt::format(
        "{} beams{} stated, but no pair names its beams: their corrections are not estimated; "
        "repeat dn match, or add the columns",
        beams.stated, of);
  }
  const auto [fewest, most] = std::minmax_element(beams.ends.begin(), beams.ends.end());
  std::string text = fmt::format("{} of {} beams{} measured pairs, {} to {} ends each",
                                 beams.NumMeasured(), beams.ends.size(), of, *fewest, *most);
  if (beams.without_beam > 0) {
    text += fmt::format("; {} ends without a beam", beams.without_beam);
  }
  return text + (beams.stated > 0 ? "; calibrate estimates their corrections"
                                  : "; calibrate takes them for one beam: state lidar.beams");
}

Json ToJson(const std::vector<BeamEnds>& all) {
  Json list = Json::array();
  for (const BeamEnds& beams : all) {
    list.push_back({{"scanner", beams.scanner},
                    {"stated", beams.stated},
                    {"ends", beams.ends},
                    {"without_beam", beams.without_beam}});
  }
  return list;
}

}  // namespace dn::apps
