// says: the function returns a different number of residuals than its Noise<R>
#include <dn/network.h>

int main() {
  dn::Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  const auto length = [](const auto& x) { return x.norm(); };
  net.Add(length, dn::Noise<1>::Sigma(1.0), p);
  net.Add(length, dn::Noise<3>::Sigma(1.0), p);  // wrong
}
