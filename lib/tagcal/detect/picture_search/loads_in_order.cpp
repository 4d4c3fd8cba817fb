#include "tagcal/detect/picture_search/loads_in_order.hpp"

#include "tagcal/error.hpp"

namespace tagcal::internal {
namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 30;  // as a limit of memory

std::size_t bytes_of(const std::vector<LoadedPicture>& pictures) {
  std::size_t bytes = 0;
  for (const LoadedPicture& picture : pictures)
    bytes += static_cast<std::size_t>(picture.image.width()) *
             static_cast<std::size_t>(picture.image.height());
  return bytes;
}

}  // namespace

LoadedPicture load_picture(const ImageSource& source, bool skips) {
  try {
    return {source.load(), ""};
  } catch (const Error& error) {
    if (!skips) throw;
    return {{}, error.what()};
  }
}

void LoadsInOrder::Turn::pass(std::size_t bytes) {
  is_taken_ = true;
  bytes_ = bytes;
  {
    const std::lock_guard lock(order_.mutex_);
    ++order_.next_;
    order_.bytes_ += bytes;
  }
  order_.changed_.notify_all();
}

std::vector<LoadedPicture> LoadsInOrder::Turn::load(
    const std::function<std::vector<LoadedPicture>()>& load) {
  {
    std::unique_lock lock(order_.mutex_);
    order_.changed_.wait(lock,
                         [&] { return order_.next_ == number_ && order_.bytes_ < kMostBytes; });
  }
  std::vector<LoadedPicture> loaded;
  try {
    loaded = load();
  } catch (...) {
    pass(0);
    throw;
  }
  pass(bytes_of(loaded));
  return loaded;
}

LoadsInOrder::Turn::~Turn() {
  if (!is_taken_) load([] { return std::vector<LoadedPicture>(); });
  {
    const std::lock_guard lock(order_.mutex_);
    order_.bytes_ -= bytes_;
  }
  order_.changed_.notify_all();
}

}  // namespace tagcal::internal
