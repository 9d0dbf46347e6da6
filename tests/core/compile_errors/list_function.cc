// says: dn: the function cannot be called with these blocks
#include <dn/network.h>

int main() {
  dn::Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  const std::vector blocks{p, net.AddVector<3>("q", Eigen::Vector3d::Zero())};
  const auto right = [](const auto& x) { return x[0][0] - x[1][0]; };
  const auto pair = [](const auto& x, const auto& y) { return x[0] - y[0]; };
  net.Add(right, dn::Noise<1>::Sigma(1.0), blocks);
  net.Add(pair, dn::Noise<1>::Sigma(1.0), blocks);  // wrong
}
