// says: dn: the class derived from Factor needs
#include <dn/network.h>

struct First : dn::Factor<First, 1, dn::Vec<3>> {
  double offset_m = 0.0;
};

int main() {
  dn::Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  net.Add(First{}, p);  // wrong
}
