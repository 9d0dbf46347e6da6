// says: dn: the function must return a number or an Eigen vector
#include <dn/network.h>

template <class Vector>
using Dynamic = Eigen::Matrix<typename Vector::Scalar, Eigen::Dynamic, 1>;

int main() {
  dn::Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  const auto right = [](const auto& x) { return x.eval(); };
  const auto dynamic = [](const auto& x) { return Dynamic<std::decay_t<decltype(x)>>(x); };
  net.Add(right, dn::Noise<3>::Sigma(1.0), p);
  net.Add(dynamic, dn::Noise<3>::Sigma(1.0), p);  // wrong
}
