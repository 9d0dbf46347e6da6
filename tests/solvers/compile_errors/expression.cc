// says: end it with .eval()
#include <dn/solvers/propagate.h>

int main() {
  dn::Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  const dn::Marginals marginals(net);
  const auto right = [](const auto& x) { return (2.0 * x).eval(); };
  dn::Propagate(marginals, right, p);
  const auto other = [](const auto& x) { return 2.0 * x; };
  dn::Propagate(marginals, other, p);  // wrong
}
