#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "job/corner_cache.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/estimate/types.hpp"
#include "tagcal/scene/dataset.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal::tools {

struct WatchSettings {
  std::filesystem::path out;
  double goal_px = 0;  // 0: none
  bool json = false;
  double timeout_s = 0;  // without a change of the folders; 0: none
  std::chrono::milliseconds every{500};
};

// What became of a picture.
enum class Fate {
  board_found,
  no_board,    // `why` says so
  repeated,    // the bytes of `other`, which is still there
  renamed,     // the bytes of `other`, which is gone
  wrong_size,  // `why` says so; not kept, because the size may change
  unreadable,  // `why` says so; not kept
  removed,     // with its corners
};

struct PictureNews {
  std::string name;
  Fate fate = Fate::no_board;
  std::size_t num_corners = 0;
  std::string other;
  std::string why;
  std::vector<std::string> warnings;  // about the picture
};

struct PictureChanges {
  std::vector<std::string> ready;
  std::vector<std::string> removed;
};

// The pictures of a folder that changes, and the corners in them. A picture is known by its bytes:
// each is searched once, and counts once, whatever it is called.
class WatchedPictures {
 public:
  struct Options {
    int threads = 0;
    std::filesystem::path cache;           // of corners; "": none
    std::function<bool()> is_interrupted;  // ends a search early; pictures are unreadable then
  };
  WatchedPictures(std::filesystem::path folder, Board board, Options options);

  // Searches new pictures and forgets removed ones. News come in the order of the changes.
  std::vector<PictureNews> update(const PictureChanges& changes);

  // The views with corners, by name: `tagcal calibrate FOLDER` has the same.
  Dataset dataset() const;
  std::vector<std::string> warnings() const;  // about them, and the general ones
  const std::set<std::string>& general_warnings() const { return general_; }

  // The refusal of an answer if more than half of the views were found by a target file that they
  // contradict; else no value.
  std::optional<Finding> wrong_target() const;

  std::size_t size() const { return contents_.size(); }  // pictures, without repetitions
  bool has_corners() const;
  int revision() const { return revision_; }  // changes with the views that have corners
  bool save_cache();                          // returns true if it was written

 private:
  struct Content {
    std::set<std::string> names;  // of the files with these bytes; the picture's is `view.image`
    View view;
    ImageSize size;
    std::vector<std::string> warnings;
    std::optional<Finding> mistake;  // of the target file, as the search of that time found
  };
  struct Search {
    std::string name;
    std::string digest;
    ImageSize size;
    std::string failure;  // "": none
  };
  using Removed = std::vector<std::string>;

  std::optional<PictureNews> known(const Search& picture, const Removed& removed);
  std::vector<PictureNews> search(const std::vector<Search>& pictures);
  std::vector<DetectedPicture> detect(const std::vector<Search>& pictures);
  void find_size(const std::vector<Search>& pictures, const std::vector<DetectedPicture>& found);
  PictureNews keep(const Search& picture, View view, std::vector<std::string> warnings);
  std::optional<PictureNews> forget(const std::string& name);

  std::filesystem::path folder_;
  std::vector<PlacedBoard> boards_;
  Options options_;
  DetectOptions detection_;
  std::optional<CornerCache> cache_;
  std::map<std::string, Content> contents_;     // by digest
  std::map<std::string, std::string> digests_;  // of the files, by name
  ImageSize size_;                              // of the pictures with corners; 0x0: not known yet
  int revision_ = 0;
  std::set<std::string> general_;   // warnings about no picture alone
  std::optional<Finding> mistake_;  // of the target file, as the latest search found
};

}  // namespace tagcal::tools
