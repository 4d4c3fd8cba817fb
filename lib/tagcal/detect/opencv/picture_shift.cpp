#include "tagcal/detect/opencv/picture_shift.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "tagcal/detect/opencv/mat_of.hpp"

namespace tagcal::internal {
namespace {

constexpr int kReducedSide = 160;         // numeric: px, a limit of work
constexpr int kReach = kReducedSide / 8;  // numeric: a limit of work
// numeric: a correlation. It saves time only, as tags are read where the shift leads; with 0.35 and
// 0.7 the same 295 of 300 frames of the study tracking are followed.
constexpr double kLeastSimilar = 0.5;
constexpr int kLeastSide = 8;  // numeric: px of the part that is compared

}  // namespace

ReducedPicture::ReducedPicture(const ImageView8& image)
    : size(image.size()),
      factor(std::max(1, std::max(image.width(), image.height()) / kReducedSide)),
      pixels({std::max(1, image.width() / factor), std::max(1, image.height() / factor)}) {
  cv::Mat reduced = mat_of(pixels);
  const cv::Rect whole(0, 0, pixels.width() * factor, pixels.height() * factor);
  cv::resize(mat_of(image)(whole & cv::Rect(0, 0, image.width(), image.height())), reduced,
             reduced.size(), 0, 0, cv::INTER_AREA);
}

std::optional<Eigen::Vector2d> PictureShift::of(const Eigen::AlignedBox2d& box) const {
  if (before_.size != now_.size) return std::nullopt;
  const cv::Rect whole(0, 0, now_.pixels.width(), now_.pixels.height());
  const Eigen::Vector2i first = (box.min() / before_.factor).cast<int>();
  const Eigen::Vector2i last = (box.max() / before_.factor).cast<int>();
  // A board that fills the picture is compared by the part that stays inside after any shift.
  const cv::Rect inner(kReach, kReach, whole.width - 2 * kReach, whole.height - 2 * kReach);
  const cv::Rect part =
      cv::Rect(first.x(), first.y(), last.x() - first.x() + 1, last.y() - first.y() + 1) & inner;
  if (part.width < kLeastSide || part.height < kLeastSide) return std::nullopt;
  const cv::Rect searched(part.x - kReach, part.y - kReach, part.width + 2 * kReach,
                          part.height + 2 * kReach);
  cv::Mat similar;
  cv::matchTemplate(mat_of(now_.pixels)(searched), mat_of(before_.pixels)(part), similar,
                    cv::TM_CCOEFF_NORMED);
  double most = 0;
  cv::Point at;
  cv::minMaxLoc(similar, nullptr, &most, nullptr, &at);
  if (!(most > kLeastSimilar)) return std::nullopt;
  return before_.factor * Eigen::Vector2d(at.x - kReach, at.y - kReach);
}

}  // namespace tagcal::internal
