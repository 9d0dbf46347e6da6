// says: dn: the function returns a different number of residuals
#include <dn/builder/flight_network.h>

void AddSpeed(dn::FlightNetwork* flight) {
  const auto speed = [](const auto& state) { return state.v_m.norm(); };
  flight->AddAt(1.0, speed, dn::Noise<1>::Sigma(0.1));
  flight->AddAt(1.0, speed, dn::Noise<3>::Sigma(0.1));  // wrong
}
