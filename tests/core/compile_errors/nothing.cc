// says: dn: the function must return a number or an Eigen vector
#include <dn/network.h>

int main() {
  dn::Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  net.Add([](const auto& x) { return x[0]; }, dn::Noise<1>::Sigma(1.0), p);
  net.Add([](const auto&) {}, dn::Noise<1>::Sigma(1.0), p);  // wrong
}
