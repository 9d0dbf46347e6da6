// says: not a factor
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
  net.Add(First{}, p);
  net.Add(std::make_shared<First>(), p);  // wrong
}
