// says: dn: the function cannot be called with these blocks
#include <dn/solvers/propagate.h>

int main() {
  dn::Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  const dn::Marginals marginals(net);
  const auto length = [](const auto& x) { return x.norm(); };
  dn::Propagate(marginals, length, p);
  dn::Propagate(marginals, length, p, p);  // wrong
}
