// says: dn: the vector or matrix has another size
#include <dn/network.h>

int main() {
  dn::Noise<3>::Sigma(Eigen::Vector3d(1, 1, 1));
  dn::Noise<3>::Sigma(Eigen::Vector2d(1, 1));  // wrong
}
