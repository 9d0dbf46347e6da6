#include "fleet_unknowns.h"

#include <dn/error.h>
#include <dn/names.h>

#include <algorithm>

#include "effect_owner.h"

namespace dn::fleet_internal {
namespace {

// The deflection of the vertical is correlated over tens of kilometres.
constexpr double kPlaceM = 20e3;
constexpr double kSameArmM = 1e-9;

bool ArePlacesEqual(const ReducedFlight& a, const ReducedFlight& b) {
  return (ToEcef(a.origin) - ToEcef(b.origin)).norm() < kPlaceM;
}

bool AreArmsEqual(const ReducedFlight& a, const ReducedFlight& b) {
  return (a.mounting.gnss_lever_arm_b_m - b.mounting.gnss_lever_arm_b_m).norm() < kSameArmM;
}

/// Returns the first flight that has the same value of an effect as flight k.
std::size_t FindGroup(const std::vector<ReducedFlight>& flights, std::size_t k, EffectId effect) {
  for (std::size_t i = 0; i < k; ++i) {
    if (FindOwner(effect) == EffectOwner::kPlace && !ArePlacesEqual(flights[i], flights[k]))
      continue;
    if (effect == EffectId::kGnssLeverArm && !AreArmsEqual(flights[i], flights[k])) continue;
    return i;
  }
  return k;
}

bool IsShared(const ReducedEffect& effect, const AcrossConfig& across) {
  if (effect.estimated) return HasName(across.unknowns, EffectName(effect.effect));
  return FindOwner(effect.effect) != EffectOwner::kDay;
}

void ExpectEstimated(const ReducedFlight& flight, const AcrossConfig& across) {
  for (const std::string& name : across.unknowns) {
    const bool found = std::any_of(
        flight.effects.begin(), flight.effects.end(),
        [&](const auto& one) { return one.estimated && EffectName(one.effect) == name; });
    if (found) continue;
    throw InvalidConfig("across: '" + name + "' is not under `estimate` of flight " + flight.name +
                        "; add it there, or remove it from `across`");
  }
}

class Finder {
 public:
  Finder(const std::vector<ReducedFlight>& flights, const AcrossConfig& across)
      : flights_(flights), across_(across) {}

  SharedUnknowns Run() {
    for (std::size_t k = 0; k < flights_.size(); ++k) AddFlight(k);
    return std::move(found_);
  }

 private:
  void AddFlight(std::size_t k) {
    ExpectEstimated(flights_[k], across_);
    found_.rows.emplace_back();
    Eigen::Index row = 3;
    for (const ReducedEffect& effect : flights_[k].effects) {
      if (IsShared(effect, across_)) AddRows(effect, row, Shared(effect, k));
      row += effect.prior_sigma.size();
    }
  }

  SharedEffect* Shared(const ReducedEffect& effect, std::size_t k) {
    const std::size_t group = FindGroup(flights_, k, effect.effect);
    for (SharedEffect& one : found_.effects) {
      if (one.effect == effect.effect && one.estimated == effect.estimated && one.group == group &&
          one.components == effect.components) {
        one.prior_sigma = one.prior_sigma.cwiseMax(effect.prior_sigma);
        return &one;
      }
    }
    found_.effects.push_back({effect.effect, effect.estimated, group, effect.components,
                              effect.prior_sigma, effect.remedy, found_.size});
    found_.size += effect.prior_sigma.size();
    return &found_.effects.back();
  }

  void AddRows(const ReducedEffect& effect, Eigen::Index row, const SharedEffect* shared) {
    for (Eigen::Index c = 0; c < effect.prior_sigma.size(); ++c) {
      found_.rows.back().push_back({row + c, shared->first + c, effect.prior_sigma[c]});
    }
  }

  const std::vector<ReducedFlight>& flights_;
  const AcrossConfig& across_;
  SharedUnknowns found_;
};

}  // namespace

Eigen::VectorXd SharedUnknowns::PriorSigma() const {
  Eigen::VectorXd sigma(size);
  for (const SharedEffect& effect : effects) {
    sigma.segment(effect.first, effect.prior_sigma.size()) = effect.prior_sigma;
  }
  return sigma;
}

SharedUnknowns FindShared(const std::vector<ReducedFlight>& flights, const AcrossConfig& across) {
  return Finder(flights, across).Run();
}

}  // namespace dn::fleet_internal
