// says: dn: the vector or matrix has another size
#include <dn/network.h>

int main() {
  dn::Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  net.AddVector<2>("q", Eigen::Vector2d::Zero());
  net.AddVector<3>("r", Eigen::Vector2d::Zero());  // wrong
}
