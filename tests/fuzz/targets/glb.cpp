// A .glb as it lies in a file, all of it or the first bytes.
#include "fluxgs/io/gltf.h"

#include "glb_allowance.h"
#include "harness.h"

namespace fluxgs::fuzz {
namespace {

/// A file of which the second half does not come.
class FirstHalf final : public ByteSource {
 public:
  explicit FirstHalf(Input bytes) : bytes_(bytes) {}
  std::uint64_t size() const override { return bytes_.size(); }
  Expected<std::span<const std::byte>> read(std::uint64_t at, std::size_t count,
                                            std::vector<std::byte>&) const override {
    require(at <= bytes_.size() && count <= bytes_.size() - at, "reads within the file");
    if (at + count > bytes_.size() / 2) return fail("x", "read", "ended");
    return bytes_.subspan(static_cast<std::size_t>(at), count);
  }

 private:
  Input bytes_;
};

struct AnySink final : SplatSink {
  Expected<int> begin(const ComingSplats& coming) override { return coming.sh_degree; }
  Expected<void> take(SplatCloud& part) override {
    check_cloud(part);
    return {};
  }
};

}  // namespace

FLUXGS_FUZZ_TARGET(glb) {
  AnySink sink;
  if (const auto half = read_glb(FirstHalf(input), "x", sink); !half) check_error(half.error());
  return try_reader(input, kGlbAllowance, [](Input bytes) { return read_glb(bytes, "x"); });
}

}  // namespace fluxgs::fuzz
