// says: end it with .eval()
#include <dn/network.h>

int main() {
  dn::Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  const auto twice = [](const auto& x) { return (2.0 * x).eval(); };
  net.Add(twice, dn::Noise<3>::Sigma(1.0), p);
  net.Add([](const auto& x) { return 2.0 * x; }, dn::Noise<3>::Sigma(1.0), p);  // wrong
}
