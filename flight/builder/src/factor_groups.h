#pragma once

#include <dn/factor_group.h>

namespace dn::internal {

/// The groups of the factors of a flight, as reports name them.
const FactorGroup& InertialGroup();
const FactorGroup& GnssPositionGroup();
const FactorGroup& GnssVelocityGroup();
const FactorGroup& PairGroup();
const FactorGroup& BiasProcessGroup(bool gyro);
const FactorGroup& GnssErrorGroup();
const FactorGroup& PriorGroup();

}  // namespace dn::internal
