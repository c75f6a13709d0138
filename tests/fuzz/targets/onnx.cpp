// A network of a scene: an ONNX model. What is accepted is written anew for onnxruntime, so that
// must be read as the same model; what fits a signature must stay within the bounds of its cost.
#include "fluxgs/networks/appearance.h"
#include "harness.h"
#include "networks/onnx_check.h"
#include "networks/onnx_model.h"

namespace fluxgs::fuzz {
namespace {

using namespace networks;

const Place kPlace{"x", "network"};

void check_cost(const OnnxModel& model, const Signature& signature) {
  const auto cost = check_onnx(model, signature, kPlace);
  if (!cost) return check_error(cost.error());
  require(cost->work <= kMaxRowWork, "a row costs what onnx_check.h allows");
}

}  // namespace

FLUXGS_FUZZ_TARGET(onnx) {
  const Meter meter;
  const auto model = read_onnx(input, kPlace);
  // onnx_model.h: the size of the input; names and lists of the most nodes that there may be.
  check_memory(meter.peak(), {1 << 20, 1}, input.size(), 0);
  if (!model) {
    check_error(model.error());
    return Worth::keep;
  }
  const Bytes written = write_onnx(*model);
  const auto again = read_onnx(written, kPlace);
  if (!again) broken("what was written can be read: " + again.error().message());
  require(write_onnx(*again) == written, "the model is stable");
  for (const Signature& signature : {psi_signature(), phi_signature()})
    check_cost(*model, signature);
  if (model->outputs.size() == 1) check_cost(*model, {model->inputs, model->outputs[0]});
  return Worth::keep;
}

}  // namespace fluxgs::fuzz
