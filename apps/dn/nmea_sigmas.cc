#include "nmea_sigmas.h"

#include <dn/error.h>
#include <dn/gnss/gnss_data.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace dn::apps {
namespace {

/// Usual sigmas of a quality, numbered as in RTKLIB.
struct QualitySigma {
  int quality;
  const char* sigma_enu_m;
  const char* name;
};
constexpr std::array<QualitySigma, 4> kQualitySigmas{
    {{1, "[0.03, 0.03, 0.05]", "fixed ambiguities (GGA quality 4)"},
     {2, "[0.3, 0.3, 0.5]", "float ambiguities (GGA quality 5)"},
     {4, "[0.5, 0.5, 1]", "differential code (GGA quality 2)"},
     {5, "[2, 2, 3]", "a single receiver (GGA quality 1)"}}};

const QualitySigma& SigmaOrSingle(int quality) {
  const auto found = std::ranges::find(kQualitySigmas, quality, &QualitySigma::quality);
  return found == kQualitySigmas.end() ? kQualitySigmas.back() : *found;
}

int MostFrequent(const NmeaQualities& qualities) {
  if (qualities.empty()) return kQualitySigmas.back().quality;
  return std::ranges::max_element(qualities, {}, &NmeaQualities::value_type::second)->first;
}

}  // namespace

NmeaQualities CountNmeaQualities(const std::filesystem::path& file) {
  NmeaQualities qualities;
  try {
    for (const GnssEpoch& epoch : ReadGnss(file, GnssFormat::kNmea).epochs) {
      ++qualities[epoch.quality];
    }
  } catch (const InvalidInput&) {  // reading the flight says so
    return {};
  }
  return qualities;
}

std::string NmeaSigmaText(const NmeaQualities& qualities) {
  const QualitySigma& usual = SigmaOrSingle(MostFrequent(qualities));
  return fmt::format("  sigma_enu_m: {}   # assumed, {}: the file states none\n", usual.sigma_enu_m,
                     usual.name);
}

std::string MixedQualitiesText(const NmeaQualities& qualities) {
  if (qualities.size() < 2) return {};
  std::string text = "; they are of several qualities (";
  const char* separator = "";
  for (const auto& [quality, count] : qualities) {
    text += fmt::format("{}{}: {}", separator, SigmaOrSingle(quality).name, count);
    separator = ", ";
  }
  return text + "), and the sigmas of the most frequent one are assumed for all";
}

}  // namespace dn::apps
