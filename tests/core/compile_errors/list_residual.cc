// says: dn: the class derived from DynamicAutoFactor needs
#include <dn/network.h>

struct Sum : dn::DynamicAutoFactor<Sum> {
  explicit Sum(int terms);
};

int main() {
  dn::Network net;
  const auto s = net.AddScalar("s", 0.0);
  net.AddFactor(std::make_shared<Sum>(1), {s.id});  // wrong
}
