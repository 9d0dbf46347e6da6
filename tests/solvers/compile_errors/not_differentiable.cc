// says: do not convert it to double
#include <dn/solvers/propagate.h>

int main() {
  dn::Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  const dn::Marginals marginals(net);
  const auto right = [](const auto& x) { return x.norm(); };
  dn::Propagate(marginals, right, p);
  const auto other = [](const auto& x) { return 1.0 + 0.0 * x[0].a; };
  dn::Propagate(marginals, other, p);  // wrong
}
