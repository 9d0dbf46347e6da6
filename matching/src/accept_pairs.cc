/// The part of Matcher that accepts registered cells as pairs or surfaces.
#include <Eigen/Eigenvalues>
#include <cmath>
#include <optional>
#include <utility>

#include "agree_with_neighbours.h"
#include "matcher.h"

namespace dn::matching_internal {
namespace {

using Eigen::Vector3d;

constexpr double kMostSigma_gsd = 0.5;  // three-dimensional sigma of a pair

/// Returns the surface of a pair whose shift is accurate in one direction only.
MatchedSurface AlongBestDirection(const MatchedPair& pair, const Eigen::Matrix3d& covariance_m2) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance_m2);
  MatchedSurface surface;
  surface.pair.ends = pair.pair;
  surface.pair.normal_m = Upward(eigen.eigenvectors().col(0));
  surface.pair.sigma_m = std::sqrt(eigen.eigenvalues()[0]);
  surface.radius_m = pair.radius_m;
  return surface;
}

}  // namespace

void Matcher::TakeDetermined(std::size_t k) {
  StripPairMatch& match = result_.strip_pairs[k];
  const double most_m = kMostSigma_gsd * result_.gsd_m;
  for (RegisteredCell& w : registered_[k].cells) {
    const Eigen::Matrix3d covariance_m2 = w.registration.Covariance(result_.variance_factor);
    if (std::sqrt(covariance_m2.trace()) > most_m) {
      AddSurface(AlongBestDirection(w.pair, covariance_m2), &match);
      continue;
    }
    w.pair.pair.covariance_m2 = covariance_m2;
    match.pairs.push_back(w.pair);
  }
  match.registered = match.pairs.size();
}

void Matcher::TakeSurfaces(std::size_t k) {
  for (RegisteredSurface& w : registered_[k].surfaces) {
    w.surface.pair.sigma_m = std::sqrt(w.registration.Variance(result_.surface_variance_factor));
    AddSurface(w.surface, &result_.strip_pairs[k]);
  }
}

void Matcher::AddSurface(MatchedSurface surface, StripPairMatch* match) const {
  const double most_m = kMostSigma_gsd / std::sqrt(3.0) * result_.gsd_m;
  const bool accurate = surface.pair.sigma_m <= most_m;  // false for a covariance without a root
  if (TakesSurfaces() && accurate && surface.pair.normal_m.z() >= kLeastUp) {
    match->surfaces.push_back(std::move(surface));
  }
}

void Matcher::KeepAgreeing(StripPairMatch* match) const {
  std::vector<PlacedShift> shifts;
  for (const MatchedPair& pair : match->pairs) {
    const Vector3d p_j_m = source_.Position(match->j, pair.pair.t_j_s, pair.pair.u_j_s);
    shifts.push_back({p_j_m.head<2>(), -Apart(*match, pair.pair), *pair.pair.covariance_m2});
  }
  const Agreement agreement = AgreeWithNeighbours(shifts);
  match->variance_factor = agreement.variance_factor;
  std::vector<MatchedPair> kept;
  for (std::size_t p = 0; p < shifts.size(); ++p) {
    if (!agreement.agrees[p]) continue;
    kept.push_back(match->pairs[p]);
    std::optional<Eigen::Matrix3d>& covariance_m2 = kept.back().pair.covariance_m2;
    covariance_m2 = agreement.Inflated(*covariance_m2);
  }
  match->pairs = std::move(kept);
}

void Matcher::KeepAgreeingSurfaces(StripPairMatch* match) const {
  std::vector<PlacedHeight> heights;
  for (const MatchedSurface& surface : match->surfaces) {
    const LidarPair& ends = surface.pair.ends;
    const Vector3d p_j_m = source_.Position(match->j, ends.t_j_s, ends.u_j_s);
    const double sigma_m = surface.pair.sigma_m;
    heights.push_back({p_j_m.head<2>(), -SurfacesApart(*match, surface), sigma_m * sigma_m});
  }
  const HeightAgreement agreement = AgreeInHeight(heights);
  match->surface_variance_factor = agreement.variance_factor;
  std::vector<MatchedSurface> kept;
  for (std::size_t k = 0; k < heights.size() && kept.size() < options_.most_pairs; ++k) {
    if (!agreement.agrees[k]) continue;
    kept.push_back(match->surfaces[k]);
    kept.back().pair.sigma_m *= std::sqrt(agreement.variance_factor);
  }
  match->surfaces = std::move(kept);
}

void Matcher::AlignAll() {
  std::vector<CoarsePair> pairs;
  for (const StripPairMatch& match : result_.strip_pairs) {
    for (const MatchedPair& pair : match.pairs) {
      pairs.push_back({match.i, match.j, pair.pair.t_i_s, pair.pair.t_j_s, pair.pair.u_i_s,
                       pair.pair.u_j_s, Apart(match, pair.pair)});
    }
  }
  Align(pairs, kToleranceCells * BaseCell());
}

void Matcher::PlacePairs() {
  for (StripPairMatch& match : result_.strip_pairs) {
    for (MatchedPair& pair : match.pairs) pair.after_m = Apart(match, pair.pair);
    for (MatchedSurface& surface : match.surfaces) {
      surface.after_m = SurfacesApart(match, surface);
    }
  }
  AsGiven([&] {
    for (StripPairMatch& match : result_.strip_pairs) {
      for (MatchedPair& pair : match.pairs) {
        pair.p_i_m = source_.Position(match.i, pair.pair.t_i_s, pair.pair.u_i_s);
        pair.p_j_m = source_.Position(match.j, pair.pair.t_j_s, pair.pair.u_j_s);
      }
      for (MatchedSurface& surface : match.surfaces) {
        const LidarPair& ends = surface.pair.ends;
        surface.p_j_m = source_.Position(match.j, ends.t_j_s, ends.u_j_s);
        surface.before_m = SurfacesApart(match, surface);
      }
    }
  });
}

Vector3d Matcher::Apart(const StripPairMatch& match, const LidarPair& pair) const {
  return source_.Position(match.i, pair.t_i_s, pair.u_i_s) -
         source_.Position(match.j, pair.t_j_s, pair.u_j_s);
}

double Matcher::SurfacesApart(const StripPairMatch& match, const MatchedSurface& surface) const {
  return surface.pair.normal_m.dot(Apart(match, surface.pair.ends));
}
}  // namespace dn::matching_internal
