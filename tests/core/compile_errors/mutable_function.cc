// says: omit `mutable`
#include <dn/network.h>

int main() {
  dn::Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  int calls = 0;
  const auto right = [calls](const auto& x) { return x[0] + double(calls); };
  const auto counts = [calls](const auto& x) mutable { return x[0] + double(++calls); };
  net.Add(right, dn::Noise<1>::Sigma(1.0), p);
  net.Add(counts, dn::Noise<1>::Sigma(1.0), p);  // wrong
}
