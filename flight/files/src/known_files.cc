#include "known_files.h"

#include <array>
#include <string_view>

namespace dn::files_internal {
namespace {

/// A text near the beginning of a file that shows its format.
struct Signature {
  std::string_view text;
  std::size_t most_bytes;  ///< before the end of the text
  const char* reason;
};

constexpr std::size_t kLine = 128, kHead = 4096;

constexpr std::array<Signature, 14> kSignatures{
    {{"<gpx", kHead,
      "a GPX track: convert it to a table of time (UTC as 2023-09-21T09:49:42Z), latitude, "
      "longitude and height; its heights are often above the sea"},
     {"<kml", kHead,
      "a KML file for display: export the positions with their times as a table of t, lat, lon, h"},
     {"RINEX VERSION / TYPE", kLine,
      "RINEX, raw GNSS data: compute positions with RTKLIB or another program, and give its "
      "solution (.pos)"},
     {"CRINEX VERS", kLine,
      "compressed RINEX, raw GNSS data: compute positions with RTKLIB or another program, and give "
      "its solution (.pos)"},
     {"ply\n", 4, "a PLY file of points: convert strips to LAS"},
     {"ply\r\n", 5, "a PLY file of points: convert strips to LAS"},
     {"# .PCD", 6, "a PCD file of points: convert strips to LAS"},
     {",Ellh", kHead,
      "positions at the photos (DJI .MRK): give the positions of the whole flight, from RTKLIB "
      "(.pos) or as a table of t, lat, lon, h"},
     {"PK\x03\x04", 4, "a ZIP archive: unpack it"},
     {"\x1f\x8b", 2, "compressed by gzip: unpack it"},
     {"\xb5\x62", 2,
      "a u-blox log in binary form: convert it to NMEA, or compute positions with RTKLIB"},
     {"\xaa\x44\x12", 3, "a NovAtel log in binary form: convert it to ASCII"},
     {"ULog\x01", 5, "a ULog of PX4: convert it to CSV with ulog2csv"},
     {"#ROSBAG", 7, "a bag of ROS: export its topics as CSV"}}};

}  // namespace

std::string KnownFileReason(const std::string& beginning) {
  for (const Signature& signature : kSignatures) {
    const std::size_t at = beginning.find(signature.text);
    if (at != beginning.npos && at + signature.text.size() <= signature.most_bytes) {
      return signature.reason;
    }
  }
  return {};
}

}  // namespace dn::files_internal
