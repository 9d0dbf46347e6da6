#pragma once

#include <dn/factor_group.h>

namespace dn::builder_internal {

/// These functions return the factor groups of a flight, with their names in reports.
const FactorGroup& InertialGroup();
const FactorGroup& GnssPositionGroup();
const FactorGroup& GnssVelocityGroup();
const FactorGroup& PairGroup();
const FactorGroup& BiasProcessGroup(bool gyro);
const FactorGroup& GnssErrorGroup();
const FactorGroup& PriorGroup();

}  // namespace dn::builder_internal
