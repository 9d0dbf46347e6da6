#include "scanner_beams.h"

#include <dn/files/scanners.h>
#include <fmt/format.h>

#include <algorithm>

namespace dn::apps {

std::vector<ScannerBeams> CountScannerBeams(const Flight& flight) {
  std::vector<ScannerBeams> all;
  for (std::size_t k = 0; k < NumScanners(flight.config); ++k) {
    const LidarConfig& scanner = ScannerAt(flight.config, k);
    const std::size_t stated = scanner.beams ? scanner.beams->count : 0;
    BeamEnds ends = CountBeamEnds(flight.pairs->pairs, k, stated);
    if (!ends.of_beam.empty()) all.push_back({scanner.name, stated, std::move(ends)});
  }
  return all;
}

std::string Words(const ScannerBeams& beams) {
  const std::string of = beams.scanner.empty() ? "" : " of scanner " + beams.scanner;
  const std::vector<long>& ends = beams.ends.of_beam;
  const std::size_t measured = NumMeasuredBeams(ends);
  if (measured == 0) {
    return fmt::format(
        "{} beams{} stated, but no pair names them: their corrections are not estimated",
        beams.stated, of);
  }
  const auto [fewest, most] = std::minmax_element(ends.begin(), ends.end());
  std::string text = fmt::format("{} of {} beams{} measured pairs, {} to {} ends each", measured,
                                 ends.size(), of, *fewest, *most);
  if (beams.ends.without_beam > 0) {
    text += fmt::format("; {} ends without a beam", beams.ends.without_beam);
  }
  return text + (beams.stated > 0 ? "; calibrate estimates their corrections"
                                  : "; calibrate takes them for one beam: state lidar.beams");
}

Json ToJson(const std::vector<ScannerBeams>& all) {
  Json list = Json::array();
  for (const ScannerBeams& beams : all) {
    list.push_back({{"scanner", beams.scanner},
                    {"stated", beams.stated},
                    {"ends", beams.ends.of_beam},
                    {"without_beam", beams.ends.without_beam}});
  }
  return list;
}

}  // namespace dn::apps
