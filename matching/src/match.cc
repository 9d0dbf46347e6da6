#include <dn/matching/match.h>

#include <cmath>
#include <functional>
#include <vector>

#include "coarse_alignment.h"
#include "matcher.h"
#include "plant_offset.h"
#include "scanners_matcher.h"
#include "strip_sample.h"

namespace dn {
namespace {

using Eigen::Vector3d;
using matching_internal::AlignmentFit;
using matching_internal::CoarsePair;
using matching_internal::Matcher;
using matching_internal::PlantOptions;
using matching_internal::PlantPair;
using matching_internal::ScannersMatcher;
using matching_internal::StripSample;

constexpr double kPlantOffsetSigma_gsd = 0.5;  // prior; simulated forests have 0.3 to 0.4

class FlightMatcher : public Matcher {
 public:
  FlightMatcher(FlightMatchSource* source, const MatchOptions& options)
      : Matcher(source, options), source_(*source), given_rad_(source->mounting().boresight_rad) {}

 private:
  double FirstSearch() const override { return ShiftByAngles(); }

  AlignmentFit Align(const std::vector<CoarsePair>& pairs, double tolerance_m) override {
    return matching_internal::AlignBoresight(pairs, given_rad_, tolerance_m, options(), &source_);
  }

  bool HasBoresight() const override { return true; }
  bool MustOverlap() const override { return options().must_overlap; }
  bool TakesSurfaces() const override { return options().beams == 1; }
  Vector3d Boresight() const override { return source_.mounting().boresight_rad; }

  bool RemovePlantOffset(MatchResult* result) const override {
    const std::vector<std::vector<PlantPair>> pairs = MakePlantPairs(*result);
    std::vector<PlantPair> all;
    for (const std::vector<PlantPair>& each : pairs)
      all.insert(all.end(), each.begin(), each.end());
    const matching_internal::PlantOffset found = EstimatePlantOffset(all, PlantSettings(*result));
    double share = 0.0;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      for (std::size_t p = 0; p < pairs[k].size(); ++p) {
        Correct(result->strip_pairs[k].i, pairs[k][p], found, &result->strip_pairs[k].pairs[p]);
        share += pairs[k][p].volumetric_share.topLeftCorner<2, 2>().trace() / 2.0;
      }
    }
    result->plant_offset = {found.offset_m, found.sigma_m, share / static_cast<double>(all.size())};
    return true;
  }

  PlantOptions PlantSettings(const MatchResult& result) const {
    PlantOptions settings;
    settings.lever_arm_b_m = source_.mounting().lever_arm_b_m;
    settings.boresight_rad = source_.mounting().boresight_rad;
    settings.strip_position_sigma_m = options().sigma_ned_m.maxCoeff();
    settings.strip_attitude_sigma_rad = options().sigma_rph_rad.maxCoeff();
    settings.offset_sigma_m = kPlantOffsetSigma_gsd * result.gsd_m;
    settings.strips = source_.strips().size();
    return settings;
  }

  std::vector<std::vector<PlantPair>> MakePlantPairs(const MatchResult& result) const {
    const auto make_end = [&](double t_s, const Vector3d& u_s) {
      return matching_internal::MakeMatchEnd(source_, t_s, u_s, options());
    };
    std::vector<std::vector<PlantPair>> all;
    for (const StripPairMatch& match : result.strip_pairs) {
      all.emplace_back();
      for (const MatchedPair& pair : match.pairs) {
        const LidarPair& p = pair.pair;
        all.back().push_back(
            {{make_end(p.t_i_s, p.u_i_s), make_end(p.t_j_s, p.u_j_s), *p.covariance_m2},
             match.i,
             match.j,
             pair.volumetric_share,
             Beam(p.t_i_s, p.u_i_s),
             Beam(p.t_j_s, p.u_j_s)});
      }
    }
    return all;
  }

  Vector3d Beam(double t_s, const Vector3d& u_s) const {
    const Vector3d u_b = LaserVectorInBody(source_.mounting(), u_s);
    return source_.PoseAt(t_s).q_mb * u_b.normalized();
  }

  void Correct(std::size_t strip_i, const PlantPair& at,
               const matching_internal::PlantOffset& found, MatchedPair* pair) const {
    const Vector3d effect = at.Effect();
    LidarPair& p = pair->pair;
    const Vector3d p_i_m = source_.Position(strip_i, p.t_i_s, p.u_i_s);
    p.u_i_s = source_.RawAt(strip_i, p.t_i_s, p_i_m - found.offset_m * effect);
    *p.covariance_m2 += found.sigma_m * found.sigma_m * effect * effect.transpose();
  }

  void AsGiven(const std::function<void()>& work) override {
    const Vector3d found_rad = source_.mounting().boresight_rad;
    source_.SetBoresight(given_rad_);
    work();
    source_.SetBoresight(found_rad);
  }

  FlightMatchSource& source_;
  Vector3d given_rad_;
};

class BareMatcher : public Matcher {
 public:
  BareMatcher(BareMatchSource* source, const MatchOptions& options)
      : Matcher(source, options), source_(*source) {}

 private:
  double FirstSearch() const override { return options().search_m; }

  AlignmentFit Align(const std::vector<CoarsePair>& pairs, double tolerance_m) override {
    return matching_internal::AlignShifts(pairs, tolerance_m, &source_);
  }

  void AsGiven(const std::function<void()>& work) override {
    std::vector<Vector3d> found_m;
    for (std::size_t s = 0; s < source_.strips().size(); ++s) {
      found_m.push_back(source_.shift_m(s));
      source_.SetShift(s, Vector3d::Zero());
    }
    work();
    for (std::size_t s = 0; s < found_m.size(); ++s) source_.SetShift(s, found_m[s]);
  }

  BareMatchSource& source_;
};

}  // namespace

std::size_t MatchResult::pairs() const {
  std::size_t count = 0;
  for (const StripPairMatch& match : strip_pairs) count += match.pairs.size();
  return count;
}

MatchResult MatchFlight(FlightMatchSource* source, const MatchOptions& options) {
  return FlightMatcher(source, options).Run();
}

std::vector<MatchLevel> AlignFlight(FlightMatchSource* source, const MatchOptions& options) {
  return FlightMatcher(source, options).BringTogether().levels;
}

MatchResult MatchBareStrips(BareMatchSource* source, const MatchOptions& options) {
  return BareMatcher(source, options).Run();
}

MatchResult MatchScanners(ScannersMatchSource* source, const MatchOptions& options) {
  return ScannersMatcher(source, options).Run();
}

}  // namespace dn
