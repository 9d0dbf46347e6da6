// says: a block kind needs kSize
#include <dn/network.h>

struct Direction {
  static constexpr int kSize = 2, kTangentSize = 1;
  template <class T>
  static void Plus(const T* x, const T* d, T* x_plus_d) {
    x_plus_d[0] = x[0] - x[1] * d[0];
    x_plus_d[1] = x[1] + x[0] * d[0];
  }
};

int main() {
  dn::Network net;
  net.AddBlock<Direction>("north", Eigen::Vector2d(1.0, 0.0));  // wrong
}
