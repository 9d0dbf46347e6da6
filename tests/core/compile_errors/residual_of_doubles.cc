// says: dn: the class derived from AutoFactor needs
#include <dn/network.h>

struct First : dn::AutoFactor<First, 1, dn::Vec<3>> {
  bool Residual(const double* x, double* r) const {
    r[0] = x[0];
    return true;
  }
};

int main() {
  dn::Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  net.Add(First{}, p);  // wrong
}
