#include <dn/error.h>
#include <dn/files/flight.h>
#include <dn/files/scanners.h>
#include <dn/files/ties.h>

#include <string>
#include <utility>

namespace dn {
namespace {

void ExpectOneBeam(const FlightConfig& config) {
  ExpectOneScanner(config, "the section ties");
  if (!config.lidar) {
    throw InvalidConfig("the section 'ties' needs the section 'lidar'", {config.file.string()});
  }
  if (!config.lidar->beams) return;
  throw InvalidConfig("pairs with another flight (ties) need a scanner with one beam",
                      {config.file.string()});
}

void ExpectKnownBoresight(const PairData& data) {
  for (std::size_t k = 0; k < data.origins.size(); ++k) {
    if (data.origins[k].kind != VectorOrigin::Kind::kAssumed) continue;
    throw InvalidInput(
        "these laser vectors were computed with an assumed boresight, and pairs between flights "
        "need measured ones: declare the boresight of the strips (lidar.georeferenced_with) and "
        "match them again",
        FileLocation{data.files[k].string(), 0, 0});
  }
}

/// Returns the name that a pair has in both of its flights.
std::string TieName(const std::filesystem::path& file, long line) {
  return file.parent_path().filename().string() + "/" + file.filename().string() + ":" +
         std::to_string(line);
}

void AddPoint(const LidarPair& pair, const std::filesystem::path& file, const TieFiles& files,
              const FlightConfig& config, TieData* ties) {
  ControlPoint point;
  point.name = TieName(file, pair.line);
  point.is_check = true;
  point.where = {file.string(), pair.line, 0};
  // The noise of a pair is that of its difference, in covariance_m2. The returns have almost none.
  constexpr double kReturnSigmaM = 1e-3;
  point.returns.push_back(files.second ? ControlReturn{pair.t_j_s, pair.u_j_s}
                                       : ControlReturn{pair.t_i_s, pair.u_i_s});
  point.returns.back().sigma_m = kReturnSigmaM;
  point.returns.back().where = point.where;
  ties->points.points.push_back(std::move(point));
  ties->covariance_m2.emplace_back();
  if (files.second) return;
  const double sigma_m = PairSigma(config, pair);
  ties->covariance_m2.back() =
      pair.covariance_m2.value_or(sigma_m * sigma_m * Eigen::Matrix3d::Identity());
}

}  // namespace

TieData ReadTies(const FlightConfig& config) {
  ExpectOneBeam(config);
  TieData ties;
  for (const TieFiles& files : config.ties) {
    const PairData data = ReadPairs(config.folder, files.p2p, config.lidar->time_offset_s);
    ExpectKnownBoresight(data);
    const auto selected =
        SelectPairs(data.pairs, {PairSelection::Strategy::kMax, files.count, {}, {}, 0});
    for (const LidarPair& pair : selected) {
      AddPoint(pair, data.files[static_cast<std::size_t>(pair.file)], files, config, &ties);
    }
    ties.points.files.insert(ties.points.files.end(), data.files.begin(), data.files.end());
  }
  return ties;
}

}  // namespace dn
