// says: dn: the blocks of this factor are known only at run time
#include <dn/network.h>

struct Sum : dn::DynamicAutoFactor<Sum> {
  Sum() : DynamicAutoFactor(1, {dn::Scalar::kKind}) {}

  template <class T>
  bool Residual(const T* const* x, T* r) const {
    r[0] = x[0][0];
    return true;
  }
};

int main() {
  dn::Network net;
  const auto s = net.AddScalar("s", 0.0);
  net.AddFactor(std::make_shared<Sum>(), {s.id});
  net.Add(Sum(), s);  // wrong
}
