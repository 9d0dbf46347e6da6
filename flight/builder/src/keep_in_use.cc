#include <dn/builder/keep_in_use.h>
#include <dn/builder/use_surface.h>
#include <dn/builder/use_survey.h>

#include <cstddef>
#include <map>

namespace dn {
namespace {

bool SamePair(const LidarPair& a, const LidarPair& b) {
  return a.t_i_s == b.t_i_s && a.t_j_s == b.t_j_s && a.u_i_s == b.u_i_s && a.u_j_s == b.u_j_s;
}

/// Activates exactly the positions and velocities that are active in the other network, as far as
/// it has them.
void KeepGnss(const FlightNetwork& other, FlightNetwork* network) {
  std::map<std::size_t, const GnssEdge*> by_epoch;
  for (const GnssEdge& edge : other.gnss().edges()) by_epoch[edge.epoch] = &edge;
  const auto keep = [&](FactorId theirs, FactorId ours) {
    if (theirs < 0 || ours < 0) return;
    network->net().SetActive(ours, other.net().factor(theirs).active);
  };
  for (const GnssEdge& edge : network->gnss().edges()) {
    const auto found = by_epoch.find(edge.epoch);
    if (found == by_epoch.end()) continue;
    keep(found->second->position, edge.position);
    keep(found->second->velocity, edge.velocity);
  }
}

/// Activates exactly the pairs that are active in the other network. Both networks must have their
/// pairs in the order of the flight.
void KeepPairs(const FlightNetwork& other, FlightNetwork* network) {
  std::size_t theirs = 0;
  for (const PairEdge& edge : network->pairs().edges()) {
    std::size_t k = theirs;
    while (k < other.pairs().edges().size() && !SamePair(other.pairs().edges()[k].pair, edge.pair))
      ++k;
    const bool found = k < other.pairs().edges().size();
    network->net().SetActive(edge.id,
                             found && other.net().factor(other.pairs().edges()[k].id).active);
    if (found) theirs = k + 1;
  }
}

/// Activates exactly the surface pairs that are active in the other network. Both networks must
/// have those of the same flight.
void KeepSurfaces(const FlightNetwork& other, FlightNetwork* network) {
  std::map<std::size_t, bool> active;
  for (const ControlNode& surface : other.surfaces().points()) {
    active[surface.point] = IsSurfaceInUse(surface, other);
  }
  for (const ControlNode& surface : network->surfaces().points()) {
    const auto found = active.find(surface.point);
    UseSurface(surface, found != active.end() && found->second, network);
  }
}

/// Activates exactly the surveys of control points that are active in the other network.
void KeepControl(const FlightNetwork& other, FlightNetwork* network) {
  std::map<std::size_t, FactorId> theirs;
  for (const ControlNode& point : other.control().points()) theirs[point.point] = point.survey;
  for (const ControlNode& point : network->control().points()) {
    const auto found = theirs.find(point.point);
    UseSurvey(point, found != theirs.end() && other.net().factor(found->second).active, network);
  }
}

}  // namespace

void KeepInUse(const FlightNetwork& other, FlightNetwork* network) {
  KeepGnss(other, network);
  KeepPairs(other, network);
  KeepControl(other, network);
  KeepSurfaces(other, network);
}

}  // namespace dn
