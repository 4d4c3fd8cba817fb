#pragma once

#include <memory>
#include <vector>

namespace tagcal::internal {

// A vector whose copies share their elements until one of them is changed, by `own`, `push_back`
// or `reserve`. (Several threads may read and copy it; one that changes a copy of its own must not
// run beside others that release theirs.)
template <typename T>
class SharedVector {
 public:
  std::size_t size() const { return all_ ? all_->size() : 0; }
  bool empty() const { return size() == 0; }
  const T* data() const { return all_ ? all_->data() : nullptr; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size(); }
  const T& operator[](std::size_t i) const { return (*all_)[i]; }

  // The elements, to be changed.
  std::vector<T>& own() {
    if (!all_)
      all_ = std::make_shared<std::vector<T>>();
    else if (all_.use_count() > 1)
      all_ = std::make_shared<std::vector<T>>(*all_);
    return *all_;
  }
  void push_back(const T& element) { own().push_back(element); }
  void reserve(std::size_t size) { own().reserve(size); }

 private:
  std::shared_ptr<std::vector<T>> all_;
};

}  // namespace tagcal::internal
