// says: a function needs the noise of its result
#include <dn/network.h>

int main() {
  dn::Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  const auto length = [](const auto& x) { return x.norm(); };
  net.Add(length, dn::Noise<1>::Sigma(1.0), p);
  net.Add(length, p);  // wrong
}
