// says: dn: the function cannot be called with these blocks
#include <dn/network.h>

int main() {
  dn::Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  const auto gap = [](const auto& x, const auto& y) { return (x - y).norm(); };
  const auto q = net.AddVector<3>("q", Eigen::Vector3d::Zero());
  net.Add(gap, dn::Noise<1>::Sigma(1.0), p, q);
  net.Add(gap, dn::Noise<1>::Sigma(1.0), p);  // wrong
}
