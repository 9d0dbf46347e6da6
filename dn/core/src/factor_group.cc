#include <dn/factor_group.h>

#include <cstddef>

namespace dn {
namespace {

const RowName* GroupName(const FactorGroup& group, int row) {
  return group.rows.empty() ? nullptr : &group.rows.at(static_cast<std::size_t>(row));
}

}  // namespace

std::string FactorGroup::Channel(int row) const {
  const RowName* of = GroupName(*this, row);
  std::string channel = sensor.empty() ? name : sensor + " " + name;
  if (of != nullptr && !of->quantity.empty()) channel.append(" ").append(of->quantity);
  return channel;
}

std::string FactorGroup::Axis(int row) const {
  const RowName* of = GroupName(*this, row);
  return of == nullptr ? std::to_string(row) : of->axis;
}

std::string FactorGroup::QuantityAndAxis(int row) const {
  const RowName* of = GroupName(*this, row);
  return of == nullptr || of->quantity.empty() ? Axis(row) : of->quantity + "_" + of->axis;
}

}  // namespace dn
