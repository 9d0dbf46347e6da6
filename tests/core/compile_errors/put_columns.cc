// says: one column per tangent
#include <dn/network.h>

struct First : dn::Factor<First, 1, dn::Vec<3>> {
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    r[0] = x[0][0];
    Put<0>(x, J, Eigen::RowVector2d(1, 0));  // wrong
    return true;
  }
};

int main() {
  dn::Network net;
  const auto p = net.AddVector<3>("p", Eigen::Vector3d::Zero());
  net.Add(First{}, p);
}
