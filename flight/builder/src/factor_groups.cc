#include "factor_groups.h"

#include <dn/axis_names.h>

#include <vector>

namespace dn::builder_internal {
namespace {

std::vector<RowName> Rows(const char* const (&axes)[3]) {
  return {{axes[0]}, {axes[1]}, {axes[2]}};
}

FactorGroup BiasProcess(const char* sensor) {
  return {"bias process", Rows(kXyz), sensor, FactorGroup::Kind::kProcess};
}

FactorGroup Inertial() {
  FactorGroup group{"inertial"};
  for (const char* quantity : {"gyro", "velocity", "position"}) {
    for (const char* axis : kXyz) group.rows.push_back({axis, quantity});
  }
  return group;
}

}  // namespace

const FactorGroup& InertialGroup() {
  static const FactorGroup group = Inertial();
  return group;
}

const FactorGroup& GnssPositionGroup() {
  static const FactorGroup group{"gnss position", Rows(kEnu)};
  return group;
}

const FactorGroup& GnssVelocityGroup() {
  static const FactorGroup group{"gnss velocity", Rows(kEnu)};
  return group;
}

const FactorGroup& PairGroup() {
  static const FactorGroup group{"lidar p2p", Rows(kEnu)};
  return group;
}

const FactorGroup& ControlGroup(bool plane) {
  static const FactorGroup points{"control", Rows(kEnu)}, planes{"control plane", {{"normal"}}};
  return plane ? planes : points;
}

const FactorGroup& ControlReturnGroup(bool plane, bool used) {
  static const FactorGroup withheld{"withheld control", {}, {}, FactorGroup::Kind::kPrior};
  if (!used) return withheld;
  static const FactorGroup points{"lidar control", Rows(kEnu)};
  static const FactorGroup planes{"lidar control plane", {{"normal"}}};
  return plane ? planes : points;
}

const FactorGroup& TiePointGroup() {
  static const FactorGroup group{"tie point", {}, {}, FactorGroup::Kind::kPrior};
  return group;
}

const FactorGroup& SurfaceGroup() {
  static const FactorGroup group{"lidar surface", {{"normal"}}};
  return group;
}

const FactorGroup& BiasProcessGroup(bool gyro) {
  static const FactorGroup gyro_group = BiasProcess("gyro"), accel_group = BiasProcess("accel");
  return gyro ? gyro_group : accel_group;
}

const FactorGroup& GnssErrorGroup() {
  static const FactorGroup group{"gnss error process", Rows(kEnu), {}, FactorGroup::Kind::kProcess};
  return group;
}

const FactorGroup& PriorGroup() {
  static const FactorGroup group{"prior", {}, {}, FactorGroup::Kind::kPrior};
  return group;
}

}  // namespace dn::builder_internal
