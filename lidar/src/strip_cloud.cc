#include <dn/lidar/strip_cloud.h>

#include <algorithm>

namespace dn {
namespace {

template <class T>
void DropFrom(const std::vector<bool>& drop, std::vector<T>* values) {
  if (values->empty()) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < drop.size(); ++i) {
    if (!drop[i]) (*values)[kept++] = (*values)[i];
  }
  values->resize(kept);
}

void DropRecords(const std::vector<bool>& drop, std::size_t bytes, std::string* records) {
  if (bytes == 0) return;
  auto to = records->begin();
  for (std::size_t i = 0; i < drop.size(); ++i) {
    if (drop[i]) continue;
    const auto from = records->begin() + static_cast<std::ptrdiff_t>(i * bytes);
    to = std::copy(from, from + static_cast<std::ptrdiff_t>(bytes), to);
  }
  records->erase(to, records->end());
}

}  // namespace

void StripCloud::Clear() { *this = StripCloud(); }

void StripCloud::Drop(const std::vector<bool>& drop) {
  DropFrom(drop, &p_c);
  DropFrom(drop, &t_s);
  DropFrom(drop, &u_s);
  DropFrom(drop, &source);
  DropFrom(drop, &intensity);
  DropFrom(drop, &return_number);
  DropFrom(drop, &returns_after);
  DropFrom(drop, &classification);
  DropFrom(drop, &flags);
  DropFrom(drop, &beam);
  DropFrom(drop, &covariance_c_m2);
  DropRecords(drop, record_bytes, &records);
}

}  // namespace dn
