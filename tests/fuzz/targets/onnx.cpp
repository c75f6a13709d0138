// A network of a scene, up to where onnxruntime would get it. What is accepted must be written anew
// as the same model.
#include "harness.h"
#include "networks/onnx_check.h"

namespace fluxgs::fuzz {
namespace {

// That of the seeds
const networks::Signature kSignature{{{"a", 2}, {"b", 3}}, {"y", 3}};

}  // namespace

FLUXGS_FUZZ_TARGET(onnx) {
  const networks::Place place{"x", "network"};
  const Meter meter;
  const auto model = networks::read_onnx(input, place);
  check_memory(meter.peak(), {256 << 10, 2}, input.size(), 0);
  if (!model) {
    check_error(model.error());
    return Worth::keep;
  }
  const auto cost = networks::check_onnx(*model, kSignature, place);
  if (!cost) check_error(cost.error());
  const Bytes written = networks::write_onnx(*model);
  const auto again = networks::read_onnx(written, place);
  require(again.has_value(), "what was written anew can be read");
  require(networks::write_onnx(*again) == written, "it is written as the same bytes again");
  const auto same = networks::check_onnx(*again, kSignature, place);
  require(same.has_value() == cost.has_value(), "it is accepted as the original was");
  if (cost) {
    require(same->work == cost->work && same->columns == cost->columns, "its cost is the same");
    require(cost->work <= networks::kMaxRowWork, "its work is bounded");
  }
  return Worth::keep;
}

}  // namespace fluxgs::fuzz
