#pragma once

#include <cstddef>
#include <initializer_list>
#include <memory>
#include <utility>
#include <vector>

namespace dn {

/// An immutable list that its copies share. Copying it allocates nothing and increments one
/// reference counter, whatever the number of elements.
template <class T>
class SharedList {
 public:
  SharedList() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): implicit conversion is intended.
  SharedList(std::vector<T> elements) {
    if (elements.empty()) return;
    elements_ = std::make_shared<const std::vector<T>>(std::move(elements));
  }
  SharedList(std::initializer_list<T> elements) : SharedList(std::vector<T>(elements)) {}

  std::size_t size() const { return elements_ ? elements_->size() : 0; }
  bool empty() const { return size() == 0; }
  const T* begin() const { return elements_ ? elements_->data() : nullptr; }
  const T* end() const { return begin() + size(); }
  const T& operator[](std::size_t k) const { return (*elements_)[k]; }

 private:
  std::shared_ptr<const std::vector<T>> elements_;
};

}  // namespace dn
