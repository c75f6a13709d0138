// Cells as compact files of version 2 had them, which are still read but no longer written.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <draco/compression/expert_encode.h>
#include <draco/point_cloud/point_cloud_builder.h>

#include "codec/bytes.h"
#include "codec/octree.h"

namespace fluxgs::test {

inline codec::Bytes draco_cells(std::span<const codec::Cell> cells) {
  draco::PointCloudBuilder builder;
  builder.Start(static_cast<draco::PointIndex::ValueType>(cells.size()));
  const int attribute =
      builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_INT32);
  for (std::size_t i = 0; i < cells.size(); ++i)
    builder.SetAttributeValueForPoint(attribute, draco::PointIndex(static_cast<std::uint32_t>(i)),
                                      &cells[i].x);
  const auto cloud = builder.Finalize(false);  // true would merge points and change their order
  draco::ExpertEncoder encoder(*cloud);
  encoder.SetEncodingMethod(draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
  encoder.SetSpeedOptions(2, 2);
  draco::EncoderBuffer buffer;
  codec::Bytes bytes;
  if (!encoder.EncodeToBuffer(&buffer).ok()) return bytes;
  codec::put_varint(bytes, buffer.size());
  for (const char byte : std::span(buffer.data(), buffer.size()))
    bytes.push_back(static_cast<std::byte>(byte));
  return bytes;
}

/// A section of positions in a file of version 2: position = step·cell.
inline codec::Bytes draco_positions(std::span<const codec::Cell> cells, double step) {
  codec::Bytes bytes;
  for (const double number : {0.0, 0.0, 0.0, step}) codec::put(bytes, number);
  for (const std::byte byte : draco_cells(cells)) bytes.push_back(byte);
  return bytes;
}

}  // namespace fluxgs::test
