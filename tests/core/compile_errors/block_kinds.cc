// says: the blocks do not match
#include <dn/network.h>

struct First : dn::AutoFactor<First, 1, dn::Vec<3>> {
  template <class T>
  bool Residual(const T* x, T* r) const {
    r[0] = x[0];
    return true;
  }
};

int main() {
  dn::Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  const auto s = net.AddScalar("s", 0.0);
  net.Add(First{}, p);
  net.Add(First{}, s);  // wrong
}
