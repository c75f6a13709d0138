#include "codec/draco_positions.h"

#include <array>

#include <draco/compression/point_cloud/point_cloud_sequential_decoder.h>
#include <draco/point_cloud/point_cloud.h>
#include <fmt/format.h>

namespace fluxgs::codec {
namespace {

// Draco bitstream specification, sections 4.1 (header) and 5.1; version 2.2 is what 1.4 and later
// write. All that comes before the coded values, byte by byte.
constexpr std::uint8_t kPointCloud = 0, kSequential = 0;
constexpr std::uint8_t kPositionKind = 0, kInt32 = 5, kThree = 3, kNotNormalized = 0;

Expected<void> check_draco_header(std::span<const std::byte> bytes, std::size_t count) {
  ByteReader in(bytes);
  const auto magic = in.take<std::array<char, 5>>();
  const auto major = in.take<std::uint8_t>(), minor = in.take<std::uint8_t>();
  const auto type = in.take<std::uint8_t>(), method = in.take<std::uint8_t>();
  const auto flags = in.take<std::uint16_t>();
  const auto points = in.take<std::int32_t>();
  const auto decoders = in.take<std::uint8_t>();
  const auto attributes = in.take_varint();
  const auto kind = in.take<std::array<std::uint8_t, 4>>();
  if (!magic || !minor || !flags || !points || !decoders || !attributes || !kind)
    return fail("", "positions", "their Draco header is cut off");
  if (*magic != std::array{'D', 'R', 'A', 'C', 'O'} || *major != 2 || *type != kPointCloud ||
      *method != kSequential || *flags != 0)
    return fail("", "positions", "are not a sequential Draco point cloud of version 2");
  if (*points < 0 || static_cast<std::size_t>(*points) != count)
    return fail("", "positions",
                fmt::format("hold {} points in their Draco header, expected {}", *points, count));
  if (*decoders != 1 || *attributes != 1 ||
      *kind != std::array{kPositionKind, kInt32, kThree, kNotNormalized})
    return fail("", "positions", "are not one Draco attribute of three 32-bit integers");
  return {};
}

}  // namespace

Expected<void> decode_draco(ByteReader& in, std::span<Cell> cells) {
  const auto size = in.take_varint();
  const auto bytes = size ? in.take_bytes(*size) : std::nullopt;
  if (!bytes) return fail("", "positions", "are cut off");
  if (auto ok = check_draco_header(*bytes, cells.size()); !ok) return ok;

  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  // Not draco::Decoder, which would bring the decoders of all other kinds into the app
  draco::PointCloudSequentialDecoder decoder;
  draco::PointCloud cloud;
  // The integers as they are decoded: Draco would copy them to others of the same type one by one
  draco::DecoderOptions options;
  options.SetAttributeBool(draco::GeometryAttribute::POSITION, "skip_attribute_transform", true);
  if (const auto status = decoder.Decode(options, &buffer, &cloud); !status.ok())
    return fail("", "positions", fmt::format("Draco cannot decode them: {}", status.error_msg()));
  const draco::PointAttribute* attribute =
      cloud.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  if (!attribute || cloud.num_points() != cells.size() || attribute->num_components() != 3 ||
      attribute->data_type() != draco::DT_INT32)
    return fail("", "positions", "are damaged: Draco found other points than its header says");
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto point = draco::PointIndex(static_cast<std::uint32_t>(i));
    attribute->GetValue(attribute->mapped_index(point), &cells[i].x);
  }
  return {};
}

}  // namespace fluxgs::codec
