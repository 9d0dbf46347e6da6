// says: dn: the vector or matrix has another size
#include <dn/network.h>

int main() {
  dn::Noise<3>::Covariance(Eigen::Matrix3d::Identity());
  dn::Noise<3>::Covariance(Eigen::Matrix2d::Identity());  // wrong
}
