// says: dn: the class derived from AutoFactor needs
#include <dn/network.h>

struct Short : dn::AutoFactor<Short, 1, dn::Vec<3>, dn::Vec<1>> {
  template <class T>
  bool Residual(const T* x, T* r) const {
    r[0] = x[0];
    return true;
  }
};

int main() {
  dn::Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  const auto b = net.AddVector<1>("b", Eigen::Matrix<double, 1, 1>(0.0));
  net.Add(Short{}, p, b);  // wrong
}
