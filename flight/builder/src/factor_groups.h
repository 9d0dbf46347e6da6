#pragma once

#include <dn/factor_group.h>

namespace dn::builder_internal {

/// These functions return the factor groups of a flight, with their names in reports.
const FactorGroup& InertialGroup();
const FactorGroup& GnssPositionGroup();
const FactorGroup& GnssVelocityGroup();
const FactorGroup& PairGroup();
/// Returns the group of the surveys of control points or planes, and that of the returns on them.
/// The returns on withheld points are no measurements for the tests of the fit.
const FactorGroup& ControlGroup(bool plane);
const FactorGroup& ControlReturnGroup(bool plane, bool used);
/// The returns on tie points are no measurements for the tests of the fit.
const FactorGroup& TiePointGroup();
const FactorGroup& SurfaceGroup();
const FactorGroup& BiasProcessGroup(bool gyro);
const FactorGroup& GnssErrorGroup();
const FactorGroup& PriorGroup();

}  // namespace dn::builder_internal
