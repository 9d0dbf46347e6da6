// says: dn: a block kind whose Plus takes only doubles needs PlusJacobian
#include <dn/network.h>

struct Direction {
  static constexpr int kSize = 2, kTangentSize = 1;
  static void Plus(const double* x, const double* d, double* x_plus_d) {
    x_plus_d[0] = x[0] - x[1] * d[0];
    x_plus_d[1] = x[1] + x[0] * d[0];
  }
  static void Minus(const double* y, const double* x, double* y_minus_x) {
    y_minus_x[0] = x[0] * y[1] - x[1] * y[0];
  }
};

int main() {
  dn::Network net;
  net.AddBlock<Direction>("north", Eigen::Vector2d(1.0, 0.0));  // wrong
}
