#include "draw/sheet.hpp"

#include <cairo/cairo-pdf.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <span>

#include "draw/cairo.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;

constexpr double kPointsPerMm = 72 / 25.4;
constexpr double kInset = 12;  // mm, as all below: white border of a tile, for printers and marks
constexpr double kOverlap = 10;
constexpr double kMarkFrom = 5, kMarkTo = 11;  // of the cutting marks, from the paper's border
constexpr double kMarkWidth = 0.2;
constexpr double kLabelHeight = 2.5;

class Pdf {
 public:
  explicit Pdf(const std::string& title)
      : surface_(cairo_pdf_surface_create_for_stream(append_to_text, &text_, 1, 1)),
        owned_context_(cairo_create(surface_.get())) {
    // All printers read it, and all versions of Cairo write it in the same form.
    cairo_pdf_surface_restrict_to_version(surface_.get(), CAIRO_PDF_VERSION_1_4);
    cairo_pdf_surface_set_metadata(surface_.get(), CAIRO_PDF_METADATA_TITLE, title.c_str());
    // Equal boards give equal bytes.
    cairo_pdf_surface_set_metadata(surface_.get(), CAIRO_PDF_METADATA_CREATE_DATE,
                                   "2000-01-01T00:00Z");
  }
  Pdf(const Pdf&) = delete;
  Pdf& operator=(const Pdf&) = delete;

  void start_page(double width_mm, double height_mm) {
    cairo_pdf_surface_set_size(surface_.get(), width_mm * kPointsPerMm, height_mm * kPointsPerMm);
    cairo_identity_matrix(context_);
    cairo_scale(context_, kPointsPerMm, kPointsPerMm);
  }
  void end_page() { cairo_show_page(context_); }

  // The part of a sheet in a window of the page; its upper-left corner shows the sheet's `from`.
  void draw_part(const PrintedSheet& sheet, const Vector2d& from, const Vector2d& window,
                 const Vector2d& size) {
    cairo_save(context_);
    cairo_rectangle(context_, window.x(), window.y(), size.x(), size.y());
    cairo_clip(context_);
    cairo_translate(context_, window.x() - from.x(), window.y() - from.y());
    const Eigen::AlignedBox2d seen(from, from + size);
    PrintedSheet part{sheet.width_mm, sheet.height_mm, {}, sheet.letters};
    std::ranges::copy_if(sheet.ink, std::back_inserter(part.ink), [&](const Contour& outline) {
      Eigen::AlignedBox2d box;
      for (const Vector2d& corner : outline) box.extend(corner);
      return seen.intersects(box);
    });
    draw(part);
    cairo_restore(context_);
  }

  // One path, so that there is no seam between cells that touch.
  void draw(const PrintedSheet& sheet) {
    for (const Contour& outline : sheet.ink) add(outline);
    for (const Contour& contour : sheet.letters) add(contour);
    cairo_fill(context_);
  }

  std::string finish() {
    cairo_surface_finish(surface_.get());
    check_cairo(surface_.get(), "--out: the PDF");
    return std::move(text_);
  }

 private:
  void add(std::span<const Vector2d> points) {
    cairo_move_to(context_, points[0].x(), points[0].y());
    for (const Vector2d& point : points.subspan(1)) cairo_line_to(context_, point.x(), point.y());
    cairo_close_path(context_);
  }

  std::string text_;
  CairoSurface surface_;
  CairoContext owned_context_;
  cairo_t* context_ = owned_context_.get();
};

int pages_for(double length_mm, double paper_mm) {
  const double window = paper_mm - 2 * kInset;
  return std::max(1, static_cast<int>(std::ceil((length_mm - kOverlap) / (window - kOverlap))));
}

Tiling tiling_on(const PrintedSheet& sheet, const Paper& paper) {
  return {paper, pages_for(sheet.width_mm, paper.width_mm),
          pages_for(sheet.height_mm, paper.height_mm)};
}

// Lines in the border of a tile where its left and upper sides are cut, and where the cut sides of
// the next tiles come to lie.
std::vector<Contour> marks(const Tiling& tiling, int column, int row) {
  const Vector2d paper(tiling.paper.width_mm, tiling.paper.height_mm);
  std::vector<Contour> lines;
  const auto add = [&](int axis, double at) {
    const int other = 1 - axis;
    for (const double from : {kMarkFrom, paper[other] - kMarkTo}) {
      Vector2d low, high;
      low[axis] = at - kMarkWidth / 2;
      high[axis] = at + kMarkWidth / 2;
      low[other] = from;
      high[other] = from + kMarkTo - kMarkFrom;
      lines.push_back({low, Vector2d(high.x(), low.y()), high, Vector2d(low.x(), high.y())});
    }
  };
  if (column > 0) add(0, kInset);
  if (row > 0) add(1, kInset);
  if (column + 1 < tiling.columns) add(0, paper.x() - kInset - kOverlap);
  if (row + 1 < tiling.rows) add(1, paper.y() - kInset - kOverlap);
  return lines;
}

std::string label(const Tiling& tiling, int column, int row) {
  std::string text =
      fmt::format("page {} of {}: row {}, column {}", row * tiling.columns + column + 1,
                  tiling.columns * tiling.rows, row + 1, column + 1);
  if (column + row > 0) {
    text += fmt::format("; cut {} at the marks, lay on the marks of the page {}",
                        column == 0 ? "the top"
                        : row == 0  ? "the left side"
                                    : "top and left side",
                        column == 0 ? "above"
                        : row == 0  ? "before"
                                    : "before and of the one above");
  }
  return text;
}

}  // namespace

std::string sheet_pdf(const PrintedSheet& sheet, const std::string& title) {
  Pdf pdf(title);
  pdf.start_page(sheet.width_mm, sheet.height_mm);
  pdf.draw(sheet);
  pdf.end_page();
  return pdf.finish();
}

Tiling tiling_of(const PrintedSheet& sheet, const Paper& paper) {
  const Tiling upright = tiling_on(sheet, paper), lying = tiling_on(sheet, paper.landscape());
  return lying.columns * lying.rows < upright.columns * upright.rows ? lying : upright;
}

std::string tiled_pdf(const PrintedSheet& sheet, const Tiling& tiling, const std::string& title) {
  Pdf pdf(title);
  const Paper& paper = tiling.paper;
  const Vector2d inset(kInset, kInset);
  const Vector2d window = Vector2d(paper.width_mm, paper.height_mm) - 2 * inset;
  const Vector2d step = window - Vector2d(kOverlap, kOverlap);
  // The sheet in the middle of all pages.
  const Vector2d all =
      step.cwiseProduct(Vector2d(tiling.columns, tiling.rows)) + Vector2d(kOverlap, kOverlap);
  const Vector2d border = (all - Vector2d(sheet.width_mm, sheet.height_mm)) / 2;
  for (int row = 0; row < tiling.rows; ++row) {
    for (int column = 0; column < tiling.columns; ++column) {
      pdf.start_page(paper.width_mm, paper.height_mm);
      pdf.draw_part(sheet, step.cwiseProduct(Vector2d(column, row)) - border, inset, window);
      const Vector2d below(kInset + 3, paper.height_mm - kMarkFrom - 1);
      pdf.draw({paper.width_mm, paper.height_mm, marks(tiling, column, row),
                text_contours(label(tiling, column, row), below, kLabelHeight)});
      pdf.end_page();
    }
  }
  return pdf.finish();
}

}  // namespace tagcal::tools
