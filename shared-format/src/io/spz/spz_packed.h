// SPZ bytes from a stranger: checked, decompressed, and read splat by splat. Used for .spz files
// and for those inside of a .glb.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fluxgs/error.h"
#include "io/splat/splat_values.h"
#include "io/spz/spz_layout.h"

namespace fluxgs::io {

/// Source of SPZ bytes.
struct SpzSource {
  std::span<const std::byte> bytes;
  std::string name;   ///< of the file, for errors
  std::string field;  ///< the place in the file, for errors; empty if it is the whole file

  std::unexpected<Error> fail(const std::string& part, std::string what) const {
    return fluxgs::fail(name, field.empty() ? part : field + ": " + part, std::move(what));
  }
};

struct SpzHeader {
  unsigned version = 0;  ///< 1…4
  std::size_t count = 0;
  int sh_degree = 0;        ///< 0…4, of the file
  int fractional_bits = 0;  ///< 0…24
  unsigned flags = 0;
  std::size_t streams = 0, contents = 0;  ///< version 4: number, and offset of their table

  /// The degree that a SplatCloud takes.
  int kept_degree() const { return std::min(sh_degree, kMaxShDegree); }
  /// The filter that the scene must be drawn with.
  ScreenFilter filter() const { return {.compensated = (flags & kSpzAntialiased) != 0}; }
};

/// Decompressed, not yet decoded.
struct SpzPacked {
  SpzHeader header;
  std::optional<glm::vec3> axes;  ///< signs against those of a SplatCloud, if the file names them
  bool z_up = false;  ///< after the signs, the third axis points down and the second back
  std::vector<std::string> warnings;                  ///< see SceneFile
  std::vector<std::byte> data;                        ///< the attributes one after the other
  std::array<std::size_t, kSpzAttributes> offsets{};  ///< of each in `data`
};

/// Read and check the header; of compressed data only its beginning is decompressed. The counts are
/// then in proportion to the bytes (see spz.h).
Expected<SpzHeader> read_spz_header(const SpzSource& source);

/// Decompress everything that `header`, from read_spz_header, promises, and no more.
Expected<SpzPacked> unpack_spz(const SpzSource& source, const SpzHeader& header);

/// Decode splat i up to degree 3 and flip its axes.
void read_spz_splat(const SpzPacked& packed, std::size_t i, const AxisFlip& flip,
                    SplatValues& splat);

}  // namespace fluxgs::io
