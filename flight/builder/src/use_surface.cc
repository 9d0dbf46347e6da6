#include <dn/builder/use_surface.h>

namespace dn {

bool IsSurfaceInUse(const ControlNode& surface, const FlightNetwork& network) {
  return !network.net().block(surface.deviation).held;
}

void UseSurface(const ControlNode& surface, bool use, FlightNetwork* network) {
  Network& net = network->net();
  for (const std::size_t k : surface.edges) {
    net.SetActive(network->surfaces().edges()[k].id, use);
  }
  net.Hold(surface.deviation, !use);
}

}  // namespace dn
