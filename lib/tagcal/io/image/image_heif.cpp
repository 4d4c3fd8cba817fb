#include <libheif/heif.h>

#include <memory>
#include <vector>

#include "tagcal/error.hpp"
#include "tagcal/io/image/image_codec.hpp"
#include "tagcal/io/image/loaded_library.hpp"

namespace tagcal::internal {
namespace {

struct Libheif {
  decltype(&::heif_context_alloc) heif_context_alloc;
  decltype(&::heif_context_free) heif_context_free;
  decltype(&::heif_context_read_from_memory_without_copy)
      heif_context_read_from_memory_without_copy;
  decltype(&::heif_context_get_primary_image_handle) heif_context_get_primary_image_handle;
  decltype(&::heif_image_handle_get_width) heif_image_handle_get_width;
  decltype(&::heif_image_handle_get_height) heif_image_handle_get_height;
  decltype(&::heif_image_handle_release) heif_image_handle_release;
  decltype(&::heif_decode_image) heif_decode_image;
  decltype(&::heif_image_get_plane_readonly) heif_image_get_plane_readonly;
  decltype(&::heif_image_get_width) heif_image_get_width;
  decltype(&::heif_image_get_height) heif_image_get_height;
  decltype(&::heif_image_release) heif_image_release;
};

Libheif load_libheif() {
  const LoadedLibrary heif("heif", 1, "HEIC and AVIF pictures", "libheif1");
  Libheif all{};
  heif.find("heif_context_alloc", all.heif_context_alloc);
  heif.find("heif_context_free", all.heif_context_free);
  heif.find("heif_context_read_from_memory_without_copy",
            all.heif_context_read_from_memory_without_copy);
  heif.find("heif_context_get_primary_image_handle", all.heif_context_get_primary_image_handle);
  heif.find("heif_image_handle_get_width", all.heif_image_handle_get_width);
  heif.find("heif_image_handle_get_height", all.heif_image_handle_get_height);
  heif.find("heif_image_handle_release", all.heif_image_handle_release);
  heif.find("heif_decode_image", all.heif_decode_image);
  heif.find("heif_image_get_plane_readonly", all.heif_image_get_plane_readonly);
  heif.find("heif_image_get_width", all.heif_image_get_width);
  heif.find("heif_image_get_height", all.heif_image_get_height);
  heif.find("heif_image_release", all.heif_image_release);
  return all;
}

const Libheif& libheif() {
  static const Libheif all = load_libheif();
  return all;
}

struct Release {
  void operator()(heif_context* context) const { libheif().heif_context_free(context); }
  void operator()(heif_image_handle* handle) const { libheif().heif_image_handle_release(handle); }
  void operator()(heif_image* image) const { libheif().heif_image_release(image); }
};

void check_heif(const heif_error& error) {
  if (error.code == heif_error_Ok) return;
  if (error.code == heif_error_Unsupported_feature || error.code == heif_error_Unsupported_filetype)
    throw Error(std::string("HEIF: ") + error.message);
  throw Error("HEIF: is damaged or truncated");
}

// The primary picture of a HEIC, HEIF or AVIF file, turned as the file says, in 8 bits.
class HeifDecoder : public ImageDecoder {
 public:
  explicit HeifDecoder(std::string_view bytes) : context_(libheif().heif_context_alloc()) {
    const Libheif& heif = libheif();
    check_heif(heif.heif_context_read_from_memory_without_copy(context_.get(), bytes.data(),
                                                               bytes.size(), nullptr));
    heif_image_handle* handle = nullptr;
    check_heif(heif.heif_context_get_primary_image_handle(context_.get(), &handle));
    handle_.reset(handle);
    header_.width = heif.heif_image_handle_get_width(handle);
    header_.height = heif.heif_image_handle_get_height(handle);
    header_.channels = 3;
    check_picture_size(header_.width, header_.height, bytes.size());
  }

  void decode(const RowSink& sink) override {
    const Libheif& heif = libheif();
    heif_image* decoded = nullptr;
    check_heif(heif.heif_decode_image(handle_.get(), &decoded, heif_colorspace_RGB,
                                      heif_chroma_interleaved_RGB, nullptr));
    const std::unique_ptr<heif_image, Release> image(decoded);
    if (heif.heif_image_get_width(decoded, heif_channel_interleaved) != header_.width ||
        heif.heif_image_get_height(decoded, heif_channel_interleaved) != header_.height)
      throw Error("HEIF: has another size than its header says");
    int stride = 0;
    const std::uint8_t* const pixels =
        heif.heif_image_get_plane_readonly(decoded, heif_channel_interleaved, &stride);
    std::vector<std::uint16_t> row;
    for (int y = 0; y < header_.height; ++y) {
      const std::uint8_t* const from = pixels + static_cast<std::ptrdiff_t>(y) * stride;
      row.assign(from, from + 3 * static_cast<std::ptrdiff_t>(header_.width));
      sink(y, row.data());
    }
  }

 private:
  std::unique_ptr<heif_context, Release> context_;
  std::unique_ptr<heif_image_handle, Release> handle_;
};

}  // namespace

std::unique_ptr<ImageDecoder> heif_decoder(std::string_view bytes) {
  return std::make_unique<HeifDecoder>(bytes);
}

}  // namespace tagcal::internal
