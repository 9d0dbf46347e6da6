#include <dn/solvers/linear_algebra.h>

#include <cstdlib>
#include <string_view>

namespace dn {

LinearAlgebra DefaultLinearAlgebra() {
  const char* value = std::getenv("DN_LINEAR_ALGEBRA");
  return value != nullptr && std::string_view(value) == "cholmod" ? LinearAlgebra::kCholmod
                                                                  : LinearAlgebra::kMultifrontal;
}

}  // namespace dn
