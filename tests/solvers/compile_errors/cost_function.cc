// says: dn: the function returns a different number of residuals
#include <dn/ceres.h>

int main() {
  const auto length = [](const auto& x) { return x.norm(); };
  dn::MakeCostFunction<dn::Vec<3>>(length, dn::Noise<1>::Sigma(1.0));
  dn::MakeCostFunction<dn::Vec<3>>(length, dn::Noise<3>::Sigma(1.0));  // wrong
}
