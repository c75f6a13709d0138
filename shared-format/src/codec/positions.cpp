#include "codec/positions.h"
#include "fluxgs/byte_reader.h"

#include <array>
#include <cmath>
#include <limits>

#include <draco/compression/expert_encode.h>
#include <draco/compression/point_cloud/point_cloud_sequential_decoder.h>
#include <draco/point_cloud/point_cloud_builder.h>
#include <fmt/format.h>
#include <glm/common.hpp>

namespace fluxgs::codec {
namespace {

// Draco's encoder counts every value up to the largest: 2²⁴ steps take it 130 MB for a moment, 2³⁰
// would take 8 GB.
constexpr double kMaxSteps = 0x1p24;
// 0 is the slowest and should take the fewest bytes. Measured: 2 takes as many (±0.02%), and is
// read in half the time, because its tables fit into the caches; 3 takes up to 0.05% more, 5 up to
// 0.7%.
constexpr int kDracoSpeed = 2;
constexpr std::size_t kMinSplats = 1, kMaxSplats = std::size_t{1} << 30;

using Cell = std::array<std::int32_t, 3>;

glm::dvec3 lowest(const std::vector<glm::vec3>& positions) {
  glm::vec3 low(std::numeric_limits<float>::max());
  for (const glm::vec3& p : positions) low = glm::min(low, p);
  return glm::dvec3(low);
}

Expected<draco::PointCloudBuilder> builder_of(const std::vector<glm::vec3>& positions,
                                              const glm::dvec3& origin, double step) {
  draco::PointCloudBuilder builder;
  builder.Start(static_cast<draco::PointIndex::ValueType>(positions.size()));
  const int attribute =
      builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_INT32);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    Cell cell;
    for (int c = 0; c < 3; ++c) {
      const double steps = std::round((double{positions[i][c]} - origin[c]) / step);
      if (!(steps >= 0 && steps < kMaxSteps))
        return fail("", "positions",
                    fmt::format("extend over {:g} steps of {:g}, expected less than {:g}", steps,
                                step, kMaxSteps));
      cell[static_cast<std::size_t>(c)] = static_cast<std::int32_t>(steps);
    }
    builder.SetAttributeValueForPoint(attribute, draco::PointIndex(static_cast<std::uint32_t>(i)),
                                      cell.data());
  }
  return builder;
}

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

Expected<void> encode_positions(const std::vector<glm::vec3>& positions, double step, Bytes& out) {
  if (positions.size() < kMinSplats || positions.size() > kMaxSplats)
    return fail(
        "", "positions",
        fmt::format("{} splats, expected {} to {}", positions.size(), kMinSplats, kMaxSplats));
  const glm::dvec3 origin = lowest(positions);
  auto builder = builder_of(positions, origin, step);
  if (!builder) return std::unexpected(builder.error());
  const auto cloud = builder->Finalize(false);  // true would merge points and change their order
  draco::ExpertEncoder encoder(*cloud);
  encoder.SetEncodingMethod(draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
  encoder.SetSpeedOptions(kDracoSpeed, kDracoSpeed);
  draco::EncoderBuffer buffer;
  if (const draco::Status status = encoder.EncodeToBuffer(&buffer); !status.ok())
    return fail("", "positions", fmt::format("Draco cannot encode them: {}", status.error_msg()));
  for (int c = 0; c < 3; ++c) put(out, origin[c]);
  put(out, step);
  put_varint(out, buffer.size());
  const auto* data = reinterpret_cast<const std::byte*>(buffer.data());
  out.insert(out.end(), data, data + buffer.size());
  return {};
}

Expected<void> decode_positions(ByteReader& in, std::span<glm::vec3> positions) {
  const auto origin = in.take<std::array<double, 3>>();
  const auto step = in.take<double>();
  const auto size = in.take_varint();
  const auto bytes = size ? in.take_bytes(*size) : std::nullopt;
  if (!origin || !step || !bytes) return fail("", "positions", "are cut off");
  if (auto ok = check_draco_header(*bytes, positions.size()); !ok) return ok;

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
  if (!attribute || cloud.num_points() != positions.size() || attribute->num_components() != 3 ||
      attribute->data_type() != draco::DT_INT32)
    return fail("", "positions", "are damaged: Draco found other points than its header says");
  for (std::size_t i = 0; i < positions.size(); ++i) {
    Cell cell;
    const auto point = draco::PointIndex(static_cast<std::uint32_t>(i));
    attribute->GetValue(attribute->mapped_index(point), &cell);
    for (int c = 0; c < 3; ++c) {
      const auto k = static_cast<std::size_t>(c);
      positions[i][c] = static_cast<float>((*origin)[k] + *step * cell[k]);
      if (!std::isfinite(positions[i][c]))
        return fail("", "positions", fmt::format("splat {} is not finite", i));
    }
  }
  return {};
}

}  // namespace fluxgs::codec
