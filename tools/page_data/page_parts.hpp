#pragma once

#include <span>

#include "page_data/corners_data.hpp"
#include "page_data/json_values.hpp"
#include "page_data/page_content.hpp"
#include "page_data/thumbnails.hpp"
#include "tagcal/io/types.hpp"

namespace tagcal::tools {

// Parts of the page's data that one function each makes.

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
PageJson halves_json(const std::optional<HalvesCheck>& halves);

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

// The data of the page of a calibration.
PageJson calibration_page(const PageContent& content);

}  // namespace tagcal::tools
