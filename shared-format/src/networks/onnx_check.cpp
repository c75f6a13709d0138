#include "networks/onnx_check.h"

#include <algorithm>
#include <map>
#include <string_view>

#include <fmt/format.h>

namespace fluxgs::networks {
namespace {

/// A value of the graph: a matrix with one row a splat, or a constant.
struct Value {
  int columns = 0;
  const Tensor* constant = nullptr;
};
using Operands = std::vector<const Value*>;  // null: an optional input left out

/// Result of an operator.
struct Made {
  int columns = 0;
  std::uint64_t work = 0;
};

std::uint64_t unsigned_of(int n) { return static_cast<std::uint64_t>(n); }

// A transcendental function takes about as long as this many multiply-adds.
constexpr std::uint64_t kTranscendental = 16;

bool is_rows(const Value* value) { return value != nullptr && value->constant == nullptr; }
bool is_matrix(const Value* value) {
  return value != nullptr && value->constant != nullptr && value->constant->dims.size() == 2;
}

/// An integer attribute, or `otherwise` if it is not there.
std::int64_t integer(const Node& node, std::string_view name, std::int64_t otherwise) {
  for (const Attribute& a : node.attributes) {
    if (a.name == name) return std::get<std::int64_t>(a.value);
  }
  return otherwise;
}

/// The columns of a constant that is added to (or multiplied with) every row alike, else 0.
int row_columns(const Value& value) {
  if (value.constant == nullptr) return value.columns;
  const auto& dims = value.constant->dims;
  if (dims.size() == 2 && dims[0] != 1) return 0;
  return dims.empty() ? 1 : static_cast<int>(dims.back());
}

Expected<Made> product(const Value* row, const Value* weights, bool transposed,
                       const Place& place) {
  if (!is_rows(row) || !is_matrix(weights)) {
    return fail(place, "expected rows times a constant matrix");
  }
  const auto& dims = weights->constant->dims;
  const auto inner = static_cast<int>(dims[transposed ? 1 : 0]);
  const auto outer = static_cast<int>(dims[transposed ? 0 : 1]);
  if (inner != row->columns) {
    return fail(place, fmt::format("rows of {} columns times a matrix of {}x{}", row->columns,
                                   inner, outer));
  }
  return Made{outer, unsigned_of(inner) * unsigned_of(outer)};
}

Expected<Made> mat_mul(const Node&, const Operands& in, const Place& place) {
  return product(in[0], in[1], false, place);
}

// alpha·A·B + beta·C
Expected<Made> gemm(const Node& node, const Operands& in, const Place& place) {
  const std::int64_t transposed = integer(node, "transB", 0);
  if (integer(node, "transA", 0) != 0)
    return fail(place, "transA would mix the splats; expected 0");
  if (transposed != 0 && transposed != 1) return fail(place, "transB must be 0 or 1");
  auto made = product(in[0], in[1], transposed == 1, place);
  if (!made || in.size() < 3 || in[2] == nullptr) return made;
  const int bias = is_rows(in[2]) ? 0 : row_columns(*in[2]);
  if (bias != 1 && bias != made->columns) {
    return fail(place, fmt::format("its bias does not fit {} columns", made->columns));
  }
  return made;
}

Expected<Made> elementwise(const Node&, const Operands& in, const Place& place) {
  if (!is_rows(in[0]) && !is_rows(in[1])) return fail(place, "expected rows as an operand");
  const int a = row_columns(*in[0]), b = row_columns(*in[1]);
  if (a == 0 || b == 0 || (a != b && a != 1 && b != 1)) {
    return fail(place, "its operands' columns do not fit");
  }
  const int columns = std::max(a, b);
  return Made{columns, unsigned_of(columns)};
}

Expected<Made> of_each(const Operands& in, std::uint64_t work, const Place& place) {
  if (!is_rows(in[0])) return fail(place, "expected rows as its operand");
  return Made{in[0]->columns, work * unsigned_of(in[0]->columns)};
}
Expected<Made> cheap(const Node&, const Operands& in, const Place& place) {
  return of_each(in, 1, place);
}
Expected<Made> costly(const Node&, const Operands& in, const Place& place) {
  return of_each(in, kTranscendental, place);
}

Expected<Made> clip(const Node&, const Operands& in, const Place& place) {
  for (std::size_t i = 1; i < in.size(); ++i) {
    if (in[i] == nullptr) continue;
    if (in[i]->constant == nullptr || !in[i]->constant->dims.empty()) {
      return fail(place, "its limits must be constant numbers");
    }
  }
  return of_each(in, 1, place);
}

Expected<Made> concat(const Node& node, const Operands& in, const Place& place) {
  const std::int64_t axis = integer(node, "axis", 0);
  if (axis != 1 && axis != -1) return fail(place, "axis would mix the splats; expected 1");
  int columns = 0;
  for (const Value* operand : in) {
    if (!is_rows(operand)) return fail(place, "expected rows as its operands");
    columns += operand->columns;
  }
  return Made{columns, unsigned_of(columns)};
}

enum class Kind { real, integer };
struct Known {
  std::string_view name;
  Kind kind;
};

struct Operator {
  std::string_view name;
  std::size_t least, most;  // operands
  Expected<Made> (*make)(const Node&, const Operands&, const Place&);
  std::vector<Known> attributes = {};
};

const std::vector<Operator>& operators() {
  static const std::vector<Operator> table = {
      {"Gemm",
       2,
       3,
       gemm,
       {{"alpha", Kind::real},
        {"beta", Kind::real},
        {"transA", Kind::integer},
        {"transB", Kind::integer}}},
      {"MatMul", 2, 2, mat_mul},
      {"Add", 2, 2, elementwise},
      {"Sub", 2, 2, elementwise},
      {"Mul", 2, 2, elementwise},
      {"Div", 2, 2, elementwise},
      {"Relu", 1, 1, cheap},
      {"LeakyRelu", 1, 1, cheap, {{"alpha", Kind::real}}},
      {"Sigmoid", 1, 1, costly},
      {"Tanh", 1, 1, costly},
      {"Clip", 1, 3, clip},
      {"Concat", 1, kMaxOperands, concat, {{"axis", Kind::integer}}},
      {"Identity", 1, 1, cheap},
  };
  return table;
}

Expected<void> check_attributes(const Node& node, const Operator& op, const Place& place) {
  for (std::size_t i = 0; i < node.attributes.size(); ++i) {
    const Attribute& attribute = node.attributes[i];
    const auto same = [&](const auto& other) { return other.name == attribute.name; };
    const auto known = std::ranges::find_if(op.attributes, same);
    const Kind kind = std::holds_alternative<float>(attribute.value) ? Kind::real : Kind::integer;
    if (known == op.attributes.end() || known->kind != kind) {
      return fail(
          place, fmt::format("attribute \"{}\" is not known or of the wrong type", attribute.name));
    }
    if (std::count_if(node.attributes.begin(), node.attributes.end(), same) > 1) {
      return fail(place, fmt::format("attribute \"{}\" appears twice", attribute.name));
    }
  }
  return {};
}

class Checker {
 public:
  Checker(const OnnxModel& model, const Place& place) : model_(model), place_(place) {}

  Expected<RowCost> run(const Signature& signature) {
    if (auto ok = match(model_.inputs, signature.inputs, "input"); !ok) return error(ok);
    if (auto ok = match(model_.outputs, {signature.output}, "output"); !ok) return error(ok);
    for (const Columns& input : model_.inputs) {
      if (auto ok = define(input.name, {input.count, nullptr}); !ok) return error(ok);
    }
    for (const Tensor& tensor : model_.tensors) {
      if (auto ok = define(tensor.name, {0, &tensor}); !ok) return error(ok);
    }
    for (std::size_t i = 0; i < model_.nodes.size(); ++i) {
      const Node& node = model_.nodes[i];
      if (auto ok = follow(node, place_.in(fmt::format("node {} ({})", i, node.op))); !ok) {
        return error(ok);
      }
    }
    if (auto ok = check_output(signature.output); !ok) return error(ok);
    return cost_;
  }

 private:
  static std::unexpected<Error> error(const Expected<void>& failed) {
    return std::unexpected(failed.error());
  }

  Expected<void> define(const std::string& name, Value value) {
    if (name.empty()) return fail(place_, "a value without a name");
    if (!values_.emplace(name, value).second) {
      return fail(place_, fmt::format("\"{}\" is made twice", name));
    }
    cost_.columns += unsigned_of(value.columns);
    return {};
  }

  /// The same names with the same columns, in any order.
  Expected<void> match(const std::vector<Columns>& found, const std::vector<Columns>& expected,
                       const char* what) const {
    for (const Columns& f : found) {
      const auto wanted = std::ranges::find(expected, f.name, &Columns::name);
      if (wanted == expected.end()) {
        return fail(place_, fmt::format("{} \"{}\" is not expected", what, f.name));
      }
      if (wanted->count != f.count) {
        return fail(place_, fmt::format("{} \"{}\" has {} columns; expected {}", what, f.name,
                                        f.count, wanted->count));
      }
    }
    for (const Columns& e : expected) {
      const auto times = std::ranges::count(found, e.name, &Columns::name);
      if (times != 1) {
        return fail(place_, fmt::format("expected one {} \"{}\" of {} columns; found {}", what,
                                        e.name, e.count, times));
      }
    }
    return {};
  }

  Expected<Operands> operands_of(const Node& node, const Operator& op, const Place& place) const {
    if (node.inputs.size() < op.least || node.inputs.size() > op.most) {
      return fail(place, fmt::format("has {} inputs; expected {} to {}", node.inputs.size(),
                                     op.least, op.most));
    }
    Operands operands;
    for (const std::string& name : node.inputs) {
      const auto value = values_.find(name);
      if (name.empty() && operands.size() >= op.least) {
        operands.push_back(nullptr);
      } else if (value == values_.end()) {
        return fail(place, fmt::format("\"{}\" is used before it is made", name));
      } else {
        operands.push_back(&value->second);
      }
    }
    return operands;
  }

  Expected<void> follow(const Node& node, const Place& place) {
    const auto op = std::ranges::find(operators(), node.op, &Operator::name);
    if (op == operators().end()) return fail(place, "this operator is not accepted");
    if (node.outputs.size() != 1) return fail(place, "expected one output");
    if (auto ok = check_attributes(node, *op, place); !ok) return ok;
    const auto operands = operands_of(node, *op, place);
    if (!operands) return std::unexpected(operands.error());
    const auto made = op->make(node, *operands, place);
    if (!made) return std::unexpected(made.error());
    if (made->columns > kMaxColumns) {
      return fail(place, fmt::format("makes {} columns; at most {} are accepted", made->columns,
                                     kMaxColumns));
    }
    cost_.work += made->work;
    if (cost_.work > kMaxRowWork) {
      return fail(place, fmt::format("more than {} multiply-adds a splat", kMaxRowWork));
    }
    return define(node.outputs[0], {made->columns, nullptr});
  }

  Expected<void> check_output(const Columns& output) const {
    const auto made = values_.find(output.name);
    if (made == values_.end() || made->second.constant != nullptr) {
      return fail(place_, fmt::format("no node makes the output \"{}\"", output.name));
    }
    if (made->second.columns != output.count) {
      return fail(place_, fmt::format("output \"{}\" comes out with {} columns; expected {}",
                                      output.name, made->second.columns, output.count));
    }
    return {};
  }

  const OnnxModel& model_;
  const Place& place_;
  std::map<std::string, Value, std::less<>> values_;
  RowCost cost_;
};

}  // namespace

Expected<RowCost> check_onnx(const OnnxModel& model, const Signature& signature,
                             const Place& place) {
  return Checker(model, place).run(signature);
}

}  // namespace fluxgs::networks
