#include "trainer/data/heif.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "fluxgs/sanitize.h"

namespace fluxgs {
namespace {

// The part of libheif's C interface that is needed, as its header declares it since version 1.1
// (https://github.com/strukturag/libheif, libheif/heif.h). Loaded at run time: few people need it.
struct HeifError {
  int code, subcode;
  const char* message;
};
struct HeifContext;
struct HeifHandle;
struct HeifImage;
constexpr int kColorspaceRgb = 1, kInterleavedRgb = 10, kInterleavedRgba = 11, kInterleaved = 10;

struct LibHeif {
  HeifContext* (*context_alloc)();
  void (*context_free)(HeifContext*);
  HeifError (*read)(HeifContext*, const void*, std::size_t, const void*);
  HeifError (*primary)(HeifContext*, HeifHandle**);
  void (*handle_release)(const HeifHandle*);
  int (*width)(const HeifHandle*);
  int (*height)(const HeifHandle*);
  int (*has_alpha)(const HeifHandle*);
  HeifError (*decode)(const HeifHandle*, HeifImage**, int, int, const void*);
  void (*image_release)(const HeifImage*);
  int (*image_width)(const HeifImage*, int);
  int (*image_height)(const HeifImage*, int);
  const std::uint8_t* (*plane)(const HeifImage*, int, int*);
  int (*metadata_ids)(const HeifHandle*, const char*, std::uint32_t*, int);
  std::size_t (*metadata_size)(const HeifHandle*, std::uint32_t);
  HeifError (*metadata)(const HeifHandle*, std::uint32_t, void*);
};

/// Null where the library, or one of its functions, is missing.
const LibHeif* lib_heif() {
  static const auto loaded = []() -> std::unique_ptr<LibHeif> {
    void* library = dlopen("libheif.so.1", RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) return nullptr;
    auto heif = std::make_unique<LibHeif>();
    bool complete = true;
    const auto load = [&](auto& function, const char* name) {
      function =
          reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));
      complete = complete && function != nullptr;
    };
    load(heif->context_alloc, "heif_context_alloc");
    load(heif->context_free, "heif_context_free");
    load(heif->read, "heif_context_read_from_memory_without_copy");
    load(heif->primary, "heif_context_get_primary_image_handle");
    load(heif->handle_release, "heif_image_handle_release");
    load(heif->width, "heif_image_handle_get_width");
    load(heif->height, "heif_image_handle_get_height");
    load(heif->has_alpha, "heif_image_handle_has_alpha_channel");
    load(heif->decode, "heif_decode_image");
    load(heif->image_release, "heif_image_release");
    load(heif->image_width, "heif_image_get_width");
    load(heif->image_height, "heif_image_get_height");
    load(heif->plane, "heif_image_get_plane_readonly");
    load(heif->metadata_ids, "heif_image_handle_get_list_of_metadata_block_IDs");
    load(heif->metadata_size, "heif_image_handle_get_metadata_size");
    load(heif->metadata, "heif_image_handle_get_metadata");
    return complete ? std::move(heif) : nullptr;
  }();
  return loaded.get();
}

template <class T>
using HeifOwned = std::unique_ptr<T, void (*)(const T*)>;

/// An opened file, with its primary image.
struct OpenHeif {
  std::unique_ptr<HeifContext, void (*)(HeifContext*)> context;
  HeifOwned<HeifHandle> image;
};

std::unexpected<Error> heif_failure(const std::string& file, const HeifError& error) {
  return fail(file, "",
              fmt::format("cannot be decoded by libheif: {}",
                          one_line(error.message ? error.message : "no reason given")));
}

Expected<OpenHeif> open_heif(std::span<const std::byte> bytes, const std::string& file) {
  const LibHeif* heif = lib_heif();
  if (!heif)
    return fail(file, "",
                "HEIC and AVIF need libheif, which is not installed (apt install libheif1), or "
                "export the photo as JPEG");
  OpenHeif open{{heif->context_alloc(), heif->context_free}, {nullptr, heif->handle_release}};
  const HeifError read = heif->read(open.context.get(), bytes.data(), bytes.size(), nullptr);
  if (read.code != 0) return heif_failure(file, read);
  HeifHandle* handle = nullptr;
  const HeifError primary = heif->primary(open.context.get(), &handle);
  if (primary.code != 0) return heif_failure(file, primary);
  open.image.reset(handle);
  const long long width = heif->width(handle), height = heif->height(handle);
  if (width < 1 || height < 1 || width > kMaxPixels / height)
    return fail(
        file, "header",
        fmt::format("image size {}x{}, expected 1 to {} pixels", width, height, kMaxPixels));
  return open;
}

/// Exif data behind four bytes that say where in them the TIFF file begins (ISO/IEC 23008-12, A.2).
Exif exif_of(const LibHeif& heif, const HeifHandle* image) {
  constexpr std::size_t kMost = 1 << 24;
  std::uint32_t id = 0;
  if (heif.metadata_ids(image, "Exif", &id, 1) < 1) return {};
  const std::size_t size = heif.metadata_size(image, id);
  std::vector<std::uint8_t> bytes(std::min(size, kMost));
  if (size > kMost || size < 4 || heif.metadata(image, id, bytes.data()).code != 0) return {};
  std::size_t offset = 0;
  for (int i = 0; i < 4; ++i) offset = offset << 8 | bytes[static_cast<std::size_t>(i)];
  if (offset > size - 4) return {};
  Exif exif = parse_exif(std::span(bytes).subspan(4 + offset));
  exif.orientation = 1;
  return exif;
}

}  // namespace

bool has_libheif() { return lib_heif() != nullptr; }

Expected<HeifOutline> read_heif_outline(std::span<const std::byte> bytes, const std::string& file) {
  const auto open = open_heif(bytes, file);
  if (!open) return std::unexpected(open.error());
  const LibHeif& heif = *lib_heif();
  return HeifOutline{.size = {heif.width(open->image.get()), heif.height(open->image.get())},
                     .exif = exif_of(heif, open->image.get())};
}

Expected<Image<std::uint8_t>> decode_heif(std::span<const std::byte> bytes,
                                          const std::string& file) {
  const auto open = open_heif(bytes, file);
  if (!open) return std::unexpected(open.error());
  const LibHeif& heif = *lib_heif();
  const bool alpha = heif.has_alpha(open->image.get()) != 0;
  HeifImage* decoded = nullptr;
  const HeifError error = heif.decode(open->image.get(), &decoded, kColorspaceRgb,
                                      alpha ? kInterleavedRgba : kInterleavedRgb, nullptr);
  const HeifOwned<HeifImage> owned(decoded, heif.image_release);
  if (error.code != 0) return heif_failure(file, error);
  const int width = heif.image_width(decoded, kInterleaved),
            height = heif.image_height(decoded, kInterleaved);
  int stride = 0;
  const std::uint8_t* rows = heif.plane(decoded, kInterleaved, &stride);
  if (width < 1 || height < 1 || rows == nullptr)
    return fail(file, "", "the image is corrupt: it cannot be decoded");
  Image<std::uint8_t> image(width, height, alpha ? 4 : 3);
  for (int y = 0; y < height; ++y)
    std::copy_n(rows + static_cast<std::ptrdiff_t>(y) * stride,
                static_cast<std::ptrdiff_t>(width) * image.channels, image.at(0, y));
  return image;
}

}  // namespace fluxgs
