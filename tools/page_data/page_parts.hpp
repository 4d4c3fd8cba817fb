#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "page_data/json_values.hpp"
#include "page_data/page_content.hpp"
#include "tagcal/camera/camera.hpp"
#include "tagcal/estimate/rig_types.hpp"
#include "tagcal/io/types.hpp"
#include "tagcal/scene/image.hpp"

// Parts of the page's data that one function each makes.

namespace tagcal::tools {

// A small copy of a picture, for the page.
struct Thumbnail {
  std::string data_uri;  // of a JPEG; "": none
  ImageSize size;
  ImageSize picture_size;
  std::string problem;  // a sentence: why there is none
};

// "data:image/jpeg;base64,..", as a page shows it.
std::string jpeg_uri(const Picture& picture);

// Small copies of pictures, by the library's own resampling. An empty path is a picture that is not
// known. Pictures that cannot be read are no error. `image_size`: what all should have.
std::vector<Thumbnail> thumbnails(const std::vector<std::filesystem::path>& files,
                                  const ImageSize& image_size, int threads);

// A corner of a view of the data set, with its residual (observed - reprojected).
struct PageCorner {
  std::size_t view = 0;
  CornerId id;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Vector2d residual_px = Eigen::Vector2d::Zero();  // NaN: not known
  bool rejected = false;
  double sd_px = 0;  // claimed, per coordinate; NaN: not known
};

// All corners of all views, in the order of the data set.
std::vector<PageCorner> page_corners(const PageContent& content);

// Columns of equal length.
PageJson corners_json(const std::vector<PageCorner>& corners);

// Boards for the view in 3D: outline, tags or dark squares, points.
PageJson boards_json(const std::vector<PlacedBoard>& boards);

// The terms of the board, and the heights over it; null without them.
PageJson warp_json(const std::vector<PlacedBoard>& boards, const std::optional<BoardWarp>& warp);

// The next view, with the largest board projected into the image; null without one.
PageJson advice_json(const PageContent& content);

// The last part of a path: the name of a file or folder, for a title.
std::string last_part(const std::string& path);

PageJson verdict_json(Status status, std::span<const Finding> findings,
                      const std::string& sentence);
PageJson page_findings_json(std::span<const Finding> findings);
PageJson made_by_json();

PageJson parameters_json(const Calibration& calibration);

// The uncertainty of the projection at infinity, and before, at and beyond the distance of the
// corners.
PageJson projection_maps_json(const PageContent& content);
PageJson ladder_json(const Calibration& calibration);
PageJson halves_sentence_json(const std::optional<HalvesCheck>& halves);

// A view each, with its picture; `thumbnails` by view. Notes about pictures go to `notes`.
PageJson views_json(const PageContent& content, const std::vector<PageCorner>& corners,
                    const std::vector<Thumbnail>& thumbnails, std::vector<std::string>& notes);

// The files of the pictures of all views; "" for those that are not at hand.
std::vector<std::filesystem::path> picture_files_of(const PageContent& content);

// Adds the picture of a view, or the sentence why there is none.
void add_thumbnail(PageJson& view, const Thumbnail& thumbnail);
// "2 of 12 pictures are not shown: 003.png (..), .."
void note_missing(const std::vector<std::string>& names, const std::vector<Thumbnail>& thumbnails,
                  std::vector<std::string>& notes);

// The region of the image with corners; null without any.
PageJson seen_json(const SeenRegion& seen);

// Cameras as text in each format that can hold them; of a single one, the others go to `notes`.
PageJson formats_json(const CameraFile& cameras, std::vector<std::string>& notes);
PageJson formats_json(const Calibration& calibration, std::vector<std::string>& notes);

// One instant of the pair of cameras with the most instants, rectified, with lines across both
// pictures: the instant whose pictures show the most corners. `pictures`: files by camera and
// View::image. Null if no instant has both files, a file cannot be read, or the pair has no
// rectification (rectify.hpp). Precondition: the rig has an answer.
PageJson rectified_json(const RigDataset& data, const RigCalibration& answer,
                        const std::vector<std::map<std::string, std::filesystem::path>>& pictures);

}  // namespace tagcal::tools
