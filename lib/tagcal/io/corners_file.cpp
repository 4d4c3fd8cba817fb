#include "tagcal/io/corners_file.hpp"

#include <fmt/format.h>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/formats/corner_lists.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal {
using namespace internal;
namespace {

namespace fs = std::filesystem;

std::string corners_text(const fs::path& out, const std::vector<View>& views,
                         const std::vector<PlacedBoard>& boards, std::string_view format,
                         std::vector<std::string>& notes) {
  if (format == "tagcal") return observations_csv(views);
  if (format == "mrcal") return vnl_text(views, boards);
  if (format == "opencv") return image_points_text(views, boards, out.extension().string(), notes);
  throw Error(fmt::format("{} is no format of corners: tagcal (CSV), mrcal (vnl) or opencv",
                          shown(format)));
}

}  // namespace

bool is_corners_file(const fs::path& file) {
  const std::string text = read_text(file);
  return is_vnl(text) || is_image_points(text) || text.starts_with("image,tag_id,corner");
}

std::string_view corners_format_of_name(const fs::path& file) {
  const std::string extension = file.extension().string();
  if (extension == ".csv") return "tagcal";
  if (extension == ".vnl") return "mrcal";
  for (const std::string_view known : {".yaml", ".yml", ".xml", ".json"})
    if (extension == known) return "opencv";
  return "";
}

std::vector<std::string> write_corners(const fs::path& out, const std::vector<View>& views,
                                       const std::vector<PlacedBoard>& boards,
                                       std::string_view format) {
  std::vector<std::string> notes;
  try {
    write_whole(out, corners_text(out, views, boards, format, notes));
  } catch (const Error& error) {
    const std::string message = error.what();
    if (message.starts_with(out.string())) throw;
    throw Error(out.string() + ": " + message);
  }
  bool has_covariances = false;
  for (const View& view : views)
    for (const Observation& o : view.observations) has_covariances |= o.covariance_px2.has_value();
  if (has_covariances && format != "tagcal")
    notes.emplace_back("dropped: the covariances of the corners");
  return notes;
}

}  // namespace tagcal
