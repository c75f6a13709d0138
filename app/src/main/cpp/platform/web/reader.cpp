// The functions of the reading worker. Its scene goes to the page in blocks (scene_blocks.h).
#include <emscripten.h>

#include <exception>
#include <optional>
#include <string>
#include <vector>

#include "fluxgs/io/scene.h"
#include "platform/web/scene_blocks.h"
#include "viewer/scene_loading.h"
#include "viewer/session_json.h"

namespace fluxgs::web {
namespace {

using Bytes = std::vector<std::byte>;

/// A file of which only the beginning has come.
class Beginning final : public ByteSource {
 public:
  Beginning(std::span<const std::byte> bytes, std::uint64_t size) : bytes_(bytes), size_(size) {}
  std::uint64_t size() const override { return size_; }
  Expected<std::span<const std::byte>> read(std::uint64_t at, std::size_t count,
                                            Bytes&) const override {
    if (at + count > bytes_.size()) return fail("", "read", "the rest has not come yet");
    return bytes_.subspan(static_cast<std::size_t>(at), count);
  }

 private:
  std::span<const std::byte> bytes_;
  std::uint64_t size_;
};

struct Reader {
  Bytes file;
  std::optional<viewer::LoadedScene> scene;
  SceneHead head;
  std::array<Block, kBlocks> blocks;
  viewer::LoadState state;
  std::string json;

  void set(std::optional<viewer::LoadedScene> read) {
    scene = std::move(read);
    if (!scene) return;
    head = head_of(*scene);
    blocks = blocks_of(*scene);
  }

  Expected<viewer::LoadedScene> decode(const std::string& name, std::size_t come,
                                       std::uint64_t memory) {
    const auto bytes = std::span<const std::byte>(file).first(come);
    const auto format =
        come == file.size() ? recognise_scene(bytes, name) : recognise_beginning(bytes, name);
    if (!format) return std::unexpected(format.error());
    std::optional<viewer::LoadedScene> coarse;
    auto read = viewer::read_within(
        memory, **format, Beginning(bytes, file.size()), name,
        [&](const SceneEstimate& estimate) { state.estimate = estimate; }, {},
        [&](viewer::LoadedScene&& part) { coarse = std::move(part); });
    if (!read && come < file.size() && coarse) return std::move(*coarse);
    return read;
  }

  bool read(const std::string& name, std::size_t come, std::uint64_t memory) {
    state = {};
    set(std::nullopt);
    set(viewer::finish(
        state, viewer::load_or_fail(name, [&] { return decode(name, come, memory); }), name));
    return scene.has_value();
  }
};

Reader& reader() {
  static Reader one;
  return one;
}

}  // namespace
}  // namespace fluxgs::web

extern "C" {

/// Room for a file of so many bytes; what was written stays. Null where there is none.
EMSCRIPTEN_KEEPALIVE void* flux_reader_room(std::size_t bytes) {
  try {
    fluxgs::web::reader().file.resize(bytes);
    return fluxgs::web::reader().file.data();
  } catch (const std::exception&) {
    return nullptr;
  }
}

/// Reads the scene, of whose file so many bytes are there: of a part only what can be shown
/// already. Whether there is something to show. `memory`: bytes that the scene may take.
EMSCRIPTEN_KEEPALIVE int flux_read(const char* name, std::size_t come, double memory) {
  return fluxgs::web::reader().read(name, come, static_cast<std::uint64_t>(memory)) ? 1 : 0;
}

/// "loading" of session_json.h.
EMSCRIPTEN_KEEPALIVE const char* flux_read_state() {
  auto& reader = fluxgs::web::reader();
  reader.json = fluxgs::viewer::to_json(reader.state);
  return reader.json.c_str();
}

EMSCRIPTEN_KEEPALIVE const void* flux_read_head() { return &fluxgs::web::reader().head; }
EMSCRIPTEN_KEEPALIVE std::size_t flux_head_bytes() { return sizeof(fluxgs::web::SceneHead); }
EMSCRIPTEN_KEEPALIVE int flux_block_count() { return static_cast<int>(fluxgs::web::kBlocks); }
EMSCRIPTEN_KEEPALIVE void* flux_read_block(int i) {
  return fluxgs::web::reader().blocks.at(static_cast<std::size_t>(i)).data;
}
EMSCRIPTEN_KEEPALIVE std::size_t flux_read_block_bytes(int i) {
  return fluxgs::web::reader().blocks.at(static_cast<std::size_t>(i)).bytes;
}
}
