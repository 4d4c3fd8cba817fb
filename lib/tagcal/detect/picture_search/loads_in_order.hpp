#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "tagcal/detect/types.hpp"

// Private to detect.
namespace tagcal::internal {

struct LoadedPicture {
  Image8 image;
  std::string unreadable;  // why it could not be loaded
};

// Throws what loading throws, unless `skips`.
LoadedPicture load_picture(const ImageSource& source, bool skips);

// Lets threads load in the order of their turns, one at a time: a video that is read in ascending
// order is decoded once. Not more than a gigabyte is loaded ahead.
class LoadsInOrder {
 public:
  // A thread's turn, which it takes by load() or at its end: the next one waits for it.
  class Turn {
   public:
    Turn(LoadsInOrder& order, std::size_t number) : order_(order), number_(number) {}
    ~Turn();
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

    std::vector<LoadedPicture> load(const std::function<std::vector<LoadedPicture>()>& load);

   private:
    void pass(std::size_t bytes);

    LoadsInOrder& order_;
    std::size_t number_;
    std::size_t bytes_ = 0;  // until the end of the turn's thread
    bool is_taken_ = false;
  };

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t next_ = 0;
  std::size_t bytes_ = 0;  // that are loaded
};

}  // namespace tagcal::internal
