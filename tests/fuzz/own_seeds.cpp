#include <zlib.h>

#include <fmt/format.h>

#include "codec/channels.h"
#include "codec/compact.h"
#include "codec/positions.h"
#include "codec/rans.h"
#include "file_bundle.h"
#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/initial_view.h"
#include "fluxgs/io/ply.h"
#include "fluxgs/io/scene.h"
#include "fluxgs/networks/appearance.h"
#include "io/spz/spz_layout.h"
#include "seeds.h"
#include "support/draco_cells.h"
#include "unit/shared-format/compressed_ply_support.h"
#include "unit/shared-format/glb_support.h"
#include "unit/shared-format/networks/support.h"
#include "unit/shared-format/sog_support.h"
#include "unit/shared-format/spz_support.h"
#include "unit/trainer/data/exif_support.h"

namespace fluxgs::fuzz {
namespace {

using test::append;
using test::bytes_of;
using test::joined;
using test::random_cloud;
using test::raw;

constexpr std::size_t kSplats = 3;
constexpr int kDegrees[] = {0, 1, 2, 3};

/// Everything that a writer makes of small scenes, for its reader and for `stability`.
void add_written(Seeds& seeds) {
  for (const SceneFormat& format : scene_formats()) {
    if (format.encode == nullptr) continue;
    for (const int degree : kDegrees) {
      if (degree > format.max_sh_degree) continue;
      const auto bytes = format.encode(random_cloud(kSplats, degree), "x", {});
      require(bytes.has_value(), "the scenes of the seeds can be written");
      const std::string name = fmt::format("{}_degree{}", format.name, degree);
      seeds[std::string(format.name)][name] = seeds["stability"][name] = *bytes;
    }
    // A scene without splats, where the format has such
    if (const auto empty = format.encode(SplatCloud(), "x", {})) {
      seeds[std::string(format.name)][std::string(format.name) + "_empty"] = *empty;
    }
  }
}

std::string ply_header(const std::string& format, const std::string& elements) {
  return "ply\nformat " + format + " 1.0\ncomment made by hand\n" + elements + "end_header\n";
}

std::string properties(std::initializer_list<const char*> names, const char* type) {
  std::string text;
  for (const char* name : names) text += fmt::format("property {} {}\n", type, name);
  return text;
}

void add_ply(Seeds& seeds) {
  auto& ply = seeds["ply"];
  const std::string vertex =
      "element vertex 2\n" +
      properties({"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1",
                  "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"},
                 "float");
  const std::string row = "0.5 -1e3 2 0 .25 1 -3 -4 nan -2 1 0 0 0\n";
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\n";
  ply["text"] = bytes_of(ply_header("ascii", vertex) + row + row);
  ply["text_behind_lists"] = bytes_of(ply_header("ascii", face + vertex) + "3 0 1 1\n" + row + row);
  std::string mixed = vertex;
  for (const auto& [name, type] :
       {std::pair("x", "double"), {"y", "short"}, {"opacity", "uchar"}}) {
    const std::string from = fmt::format("property float {}\n", name);
    mixed.replace(mixed.find(from), from.size(), fmt::format("property {} {}\n", type, name));
  }
  for (const char* format : {"binary_little_endian", "binary_big_endian"}) {
    Bytes list = raw({3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0}), data = list;
    data.resize(list.size() + 2 * (14 * 4 + 4 - 2 - 3), std::byte{0x3f});
    ply[fmt::format("{}_of_types_and_lists", format)] =
        joined({bytes_of(ply_header(format, face + mixed)), data});
  }
}

void add_ply_points(Seeds& seeds) {
  auto& points = seeds["ply_points"];
  const std::string position = "element vertex 2\n" + properties({"x", "y", "z"}, "float");
  const std::string color = properties({"red", "green", "blue"}, "uchar");
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\n";
  points["text"] =
      bytes_of(ply_header("ascii", position + color) + "0.5 -1e3 2 255 0 9\nnan 1 2 1 2 3\n");
  points["text_behind_lists"] =
      bytes_of(ply_header("ascii", face + position) + "3 0 1 1\n1 2 3\n4 5 6\n");
  for (const char* format : {"binary_little_endian", "binary_big_endian"}) {
    const Bytes data(2 * (3 * 4 + 3), std::byte{0x3f});
    points[format] = joined({bytes_of(ply_header(format, position + color)), data});
  }
}

void add_camera_track(Seeds& seeds) {
  const std::string values = R"({"position": [1, 2, 3, 4, 5, 6], "target": [0, 0, 0, 0, 1, 0])";
  const auto track = [&](const std::string& rest, const std::string& more) {
    return bytes_of(R"({"animTracks": [{"duration": 4, "loopMode": "repeat", "keyframes": )"
                    R"({"times": [0, 30], "values": )" +
                    values + more + "}}" + rest + "}]}");
  };
  auto& tracks = seeds["camera_track"];
  tracks["first_version"] = track("", "");
  tracks["second_version"] =
      track(R"(, "frameRate": 30, "smoothness": 0.5)", R"(, "fov": [60, 7e1])");
}

/// Headers of each format of images, as small as they can be; the phone's Exif data in three of
/// them.
void add_image_header(Seeds& seeds) {
  auto& headers = seeds["image_header"];
  const test::TiffWriter w;
  const std::string tiff =
      w.file({w.shorts(256, 9), w.shorts(257, 7), w.shorts(274, 6), w.text(271, "Maker"),
              w.shorts(273, 8), w.shorts(279, 4)},
             {w.rationals(37386, {{425, 100}}), w.shorts(41989, 26), w.shorts(40962, 9),
              w.rationals(41486, {{2000, 1}}), w.shorts(41488, 3)},
             {w.text(1, "S"), w.rationals(2, {{48, 1}, {30, 1}, {0, 1}}), w.text(3, "E"),
              w.rationals(4, {{11, 1}, {15, 1}, {0, 1}}), w.rationals(6, {{500, 1}})});
  const std::string frame("\xff\xc0\0\x11\x08\0\x07\0\x09\x03\x01\x11\0\x02\x11\0\x03\x11\0", 19);
  headers["tiff"] = bytes_of(tiff);
  headers["jpeg"] = bytes_of(test::jpeg_with_exif("\xff\xd8" + frame + "\xff\xd9", tiff));
  const std::string png("\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\0\x09\0\0\0\x07\x08\x02\0\0\0\0\0\0\0",
                        33);
  headers["png"] =
      bytes_of(test::png_with_exif(png + std::string("\0\0\0\0IEND\xae\x42\x60\x82", 12), tiff));
  const auto number = [&](std::size_t n) { return w.number(static_cast<std::uint32_t>(n), 4); };
  const std::string vp8x = "VP8X" + number(10) + std::string("\x08\0\0\0\x08\0\0\x06\0\0", 10);
  const std::string webp = "WEBP" + vp8x + "EXIF" + number(tiff.size()) + tiff;
  headers["webp"] = bytes_of("RIFF" + number(webp.size()) + webp);
  headers["bmp"] =
      bytes_of("BM" + number(58) + number(0) + number(54) + number(40) + number(1) + number(1) +
               w.number(1, 2) + w.number(24, 2) + number(0) + std::string(24, '\0'));
  headers["heic"] =
      bytes_of(std::string("\0\0\0\x18"
                           "ftypheic\0\0\0\0mif1heic",
                           24));
}

void add_compressed_ply(Seeds& seeds) {
  for (const int degree : kDegrees) {
    for (const bool colours : {false, true}) {
      test::CompressedPly file = test::compress(random_cloud(kSplats, degree));
      file.colour_bounds = colours;
      const std::string name =
          fmt::format("compressed_ply_degree{}{}", degree, colours ? "_colours" : "");
      seeds["compressed_ply"][name] = seeds["stability"][name] = file.bytes();
    }
  }
  seeds["compressed_ply"]["two_chunks"] = test::compress(random_cloud(257, 0)).bytes();
}

// Any bytes are splats of the older versions, which we do not write.
Bytes spz_attributes(unsigned version, int degree, std::size_t count) {
  Bytes bytes(count * io::spz_splat_bytes(version, degree));
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(i * 37);
  return bytes;
}

void add_spz(Seeds& seeds) {
  const Bytes axes = test::spz_extension(0xADBE0003, raw({5, 0, 0, 0}));
  const Bytes unknown = test::spz_extension(0x12345678, raw({1, 2, 3}));
  for (const int degree : kDegrees) {
    for (const unsigned version : {1u, 2u, 3u, 4u}) {
      const Bytes header = test::spz_header(version, kSplats, degree);
      const Bytes payload = joined({header, spz_attributes(version, degree, kSplats)});
      const std::string name = fmt::format("spz{}_degree{}", version, degree);
      seeds["spz_payload"][name] = payload;
      if (version < 4) {
        seeds["spz"][name] = test::gzip(payload);
        seeds["stability"][name] = test::gzip(payload);
      }
    }
    const SpzOptions options{.version = 4};
    const Bytes four = *encode_spz(random_cloud(kSplats, degree), "x", options);
    seeds["spz"][fmt::format("spz4_degree{}", degree)] = four;
  }
  const Bytes extended =
      joined({test::spz_header(3, 1, 1, 2), spz_attributes(3, 1, 1), unknown, axes});
  seeds["spz_payload"]["spz3_extensions"] = extended;
  seeds["spz"]["spz3_extensions"] = test::gzip(extended);
  seeds["spz"]["spz4_extensions"] =
      test::spz4(1, 0, {Bytes(9), Bytes(1), Bytes(3), Bytes(3), Bytes(4)}, joined({unknown, axes}));
}

std::string attributes_up_to(int degree) {
  std::string text = R"("POSITION":0,"COLOR_0":1,"KHR_gaussian_splatting:ROTATION":2)";
  for (int l = 1; l <= degree; ++l) {
    for (int i = 0; i <= 2 * l; ++i) {
      text += fmt::format(R"(,"KHR_gaussian_splatting:SH_DEGREE_{}_COEF_{}":0)", l, i);
    }
  }
  return text;
}

/// KHR_gaussian_splatting_compression_spz_2, as its draft has it.
Bytes glb_of_spz(const Bytes& spz, std::size_t count, int degree) {
  return test::make_glb(
      fmt::format(
          R"({{"asset":{{"version":"2.0"}},"extensionsUsed":["KHR_gaussian_splatting"],)"
          R"("accessors":[{{"componentType":5126,"count":{0},"type":"VEC3","min":[-1,-1,-1],"max":[1,1,1]}},)"
          R"({{"componentType":5121,"normalized":true,"count":{0},"type":"VEC4"}},)"
          R"({{"componentType":5126,"count":{0},"type":"VEC4"}}],)"
          R"("buffers":[{{"byteLength":{1}}}],"bufferViews":[{{"buffer":0,"byteLength":{1}}}],)"
          R"("meshes":[{{"primitives":[{{"mode":0,"attributes":{{{2}}},"extensions":{{)"
          R"("KHR_gaussian_splatting":{{"extensions":{{)"
          R"("KHR_gaussian_splatting_compression_spz_2":{{"bufferView":0}}}}}}}}}}]}}],)"
          R"("nodes":[{{"mesh":0}}],"scenes":[{{"nodes":[0]}}],"scene":0}})",
          count, spz.size(), attributes_up_to(degree)),
      spz);
}

/// Every integer that an attribute may be made of.
Bytes quantized_glb() {
  const Bytes bin = raw({1,   0,   2, 0, 3, 0, 0, 0, 0, 0, 0,   127, 1, 2, 3, 0,
                         255, 255, 0, 0, 0, 0, 0, 0, 0, 0, 128, 63,  0, 0, 0, 0});
  return test::make_glb(
      R"({"asset":{"version":"2.0"},"extensionsRequired":["KHR_mesh_quantization"],)"
      R"("buffers":[{"byteLength":32}],"bufferViews":[{"buffer":0,"byteLength":8,"byteStride":8},)"
      R"({"buffer":0,"byteOffset":8,"byteLength":4},{"buffer":0,"byteOffset":12,"byteLength":4},)"
      R"({"buffer":0,"byteOffset":16,"byteLength":4},{"buffer":0,"byteOffset":20,"byteLength":12}],)"
      R"("accessors":[{"bufferView":0,"componentType":5122,"count":1,"type":"VEC3"},)"
      R"({"bufferView":1,"componentType":5120,"normalized":true,"count":1,"type":"VEC4"},)"
      R"({"bufferView":2,"componentType":5121,"count":1,"type":"VEC3"},)"
      R"({"bufferView":3,"componentType":5123,"normalized":true,"count":1,"type":"SCALAR"},)"
      R"({"bufferView":4,"byteOffset":0,"componentType":5126,"count":1,"type":"VEC3"}],)"
      R"("meshes":[{"primitives":[{},{"mode":0,"attributes":{"POSITION":0,)"
      R"("KHR_gaussian_splatting:ROTATION":1,"KHR_gaussian_splatting:SCALE":2,)"
      R"("KHR_gaussian_splatting:OPACITY":3,"KHR_gaussian_splatting:SH_DEGREE_0_COEF_0":4},)"
      R"("extensions":{"KHR_gaussian_splatting":)"
      R"({"kernel":"ellipse","colorSpace":"srgb_rec709_display"}}}]}],"nodes":[{"mesh":0}]})",
      bin);
}

/// A network of the fewest weights that fits a signature.
Bytes smallest_network(const networks::Signature& signature) {
  int columns = 0;
  for (const networks::Columns& in : signature.inputs) columns += in.count;
  return *networks::encode_onnx(networks::test::random_mlp({columns, signature.output.count}, 1),
                                signature);
}

/// With Φ, edited in: the writer would run it with onnxruntime, which is not everywhere.
Bytes glb_with_networks(const Bytes& compact) {
  test::json root = test::json::parse(test::json_of(compact));
  Bytes bin = test::bin_of(compact);
  test::json constants = test::json::parse(
      R"({"normalisation":{"center":[0,0,0],"extent":1,"logScaleMean":-3,"logScaleDeviation":1,)"
      R"("shMean":[0,0,0,0,0,0,0,0,0,0,0,0],"shDeviation":[1,1,1,1,1,1,1,1,1,1,1,1]}})");
  const Bytes model = smallest_network(networks::phi_signature());
  constants["phi"] = {{"bufferView", root["bufferViews"].size()}};
  root["bufferViews"].push_back(
      {{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", model.size()}});
  bin = joined({bin, model});
  root["buffers"][0]["byteLength"] = bin.size();
  root["meshes"][0]["primitives"][0]["extensions"]["KHR_gaussian_splatting"]["extensions"]
      ["FLUXGS_gaussian_splatting_compact"]["networks"] = constants;
  return test::make_glb(root.dump(), bin);
}

void add_gltf(Seeds& seeds) {
  for (const auto& [name, bytes] : seeds["glb"]) {
    test::json root = test::json::parse(test::json_of(bytes));
    const Bytes bin = test::bin_of(bytes);
    const auto text_with = [&](const std::string& uri) {
      root["buffers"][0]["uri"] = uri;
      return bytes_of(root.dump());
    };
    seeds["gltf"][name] = text_with("data:application/octet-stream;base64," + test::base64(bin));
    seeds["gltf"][name + "_folder"] =
        bundle_of({{"scene.gltf", text_with("a%20b/x.bin")}, {"a b/x.bin", bin}});
  }
}

void add_glb(Seeds& seeds) {
  auto& glb = seeds["glb"];
  const Bytes plain = test::small_glb(2, 1);
  glb["quantized"] = quantized_glb();
  glb["moved"] =
      test::edited(plain, R"({"mesh":0})",
                   R"({"mesh":0,"translation":[1,2,3],"rotation":[0,0.6,0,0.8],"scale":[2,2,2]})");
  glb["tree"] = test::edited(plain, R"({"mesh":0})",
                             R"({"children":[1,2],"matrix":[2,0,0,0,0,2,0,0,0,0,2,0,1,0,0,1]},)"
                             R"({"mesh":0,"translation":[10,0,0]},{"mesh":0})");
  for (const int bits : {8, 16})
    glb[fmt::format("attributes_of_{}_bits", bits)] =
        *encode_glb(random_cloud(kSplats, 1), {.attribute_bits = bits}, "x");
  SplatCloud filtered = random_cloud(kSplats, 0);
  filtered.filter = {.dilation = 0.1, .compensated = true};
  glb["screen_filter"] = *encode_glb(filtered, "x");
  glb["without_scenes"] = test::edited(plain, R"("scenes":)", R"("other":)");
  for (const int degree : kDegrees) {
    for (const int version : {3, 4}) {
      const Bytes spz =
          *encode_spz(random_cloud(kSplats, degree), "x", SpzOptions{.version = version});
      glb[fmt::format("spz{}_degree{}", version, degree)] = glb_of_spz(spz, kSplats, degree);
    }
  }
  for (const int degree : kDegrees) {
    for (const bool with_plain : {false, true}) {
      const SplatCloud cloud = random_cloud(kSplats, degree);
      const CompactOptions options{default_quantization_steps(cloud), with_plain};
      glb[fmt::format("compact_degree{}{}", degree, with_plain ? "_and_plain" : "")] =
          *encode_compact_glb(cloud, options, "x");
    }
  }
  glb["compact_of_several_degrees"] =
      test::joined_glb({glb["compact_degree0"], glb["compact_degree1"], glb["compact_degree3"]});
  glb["compact_in_chunks"] =
      test::edited(test::edited(glb["compact_of_several_degrees"],
                                R"("FLUXGS_gaussian_splatting_compact":{"bufferView":1)",
                                R"("FLUXGS_gaussian_splatting_compact":{"chunk":1,"bufferView":1)"),
                   R"("FLUXGS_gaussian_splatting_compact":{"bufferView":2)",
                   R"("FLUXGS_gaussian_splatting_compact":{"chunk":2,"bufferView":2)");
  glb["plain_compact_and_spz"] = test::joined_glb(
      {plain, glb["compact_degree2_and_plain"], glb["spz3_degree1"], glb["compact_degree0"]});
  glb["compact_with_networks"] = glb_with_networks(glb["compact_degree1"]);
  glb["with_initial_view"] =
      *with_initial_view(glb["compact_degree1"], {.position = {1, 2, 3}, .fov_y = 0.7}, "x");
  glb["with_a_camera_in_a_tree"] = test::edited(
      test::edited(glb["tree"], "[1,2]", "[1,2,3]"), R"({"mesh":0}])",
      R"({"camera":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,4,5,6,1],"extras":{"up":[0,0,1]}}],)"
      R"("cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":0.1}}])");
  for (const auto& [name, bytes] : glb) {
    seeds["stability"]["glb_" + name] = bytes;
    seeds["glb_parts"][name] =
        joined({bytes_of(test::json_of(bytes)), Bytes(1), test::bin_of(bytes)});
  }
  add_gltf(seeds);
}

/// The same scene as a folder of a streamed one: two chunks, and a level that is left out.
Files streamed(const Files& first, const Files& second, std::size_t count) {
  Files files;
  for (const auto& [name, bytes] : first) files["0_0/" + name] = bytes;
  for (const auto& [name, bytes] : second) files["0_1/" + name] = bytes;
  files["lod-meta.json"] = bytes_of(fmt::format(
      R"({{"version":1,"lodLevels":2,"filenames":["0_0/meta.json","0_1/meta.json"],"tree":)"
      R"({{"children":[{{"lods":{{"0":{{"file":0,"offset":0,"count":{0}}}}}}},)"
      R"({{"lods":{{"0":{{"file":1,"offset":0,"count":{0}}},"1":{{"file":1,"count":1}}}}}}]}}}})",
      count));
  return files;
}

Files version_one(Files files) {
  test::json meta = test::meta_of(files);
  const auto count = meta["count"];
  meta.erase("version");
  meta.erase("count");
  meta["means"]["shape"] = {count, 3};
  for (const char* key : {"scales", "sh0"}) {
    meta[key].erase("codebook");
    const auto channels = std::string(key) == "sh0" ? 4u : 3u;
    meta[key]["mins"] = std::vector<int>(channels, -5);
    meta[key]["maxs"] = std::vector<int>(channels, 5);
  }
  if (meta.contains("shN")) {
    meta["shN"] = {{"mins", -1}, {"maxs", 1}, {"files", meta["shN"]["files"]}};
  }
  test::set_meta(files, meta);
  return files;
}

test::ZipEntry deflated(const std::string& name, const Bytes& content) {
  test::ZipEntry entry = test::stored(name, content);
  uLongf size = compressBound(content.size());
  Bytes packed(size);
  require(compress(reinterpret_cast<Bytef*>(packed.data()), &size,
                   reinterpret_cast<const Bytef*>(content.data()), content.size()) == Z_OK,
          "zlib packs");
  // zlib's header of 2 bytes and checksum of 4 are not part of a ZIP archive
  entry.data.assign(packed.begin() + 2, packed.begin() + static_cast<std::ptrdiff_t>(size) - 4);
  entry.packed_size = static_cast<std::uint32_t>(entry.data.size());
  entry.method = 8;
  return entry;
}

void add_sog(Seeds& seeds) {
  for (const int degree : kDegrees) {
    const Files files = test::make_sog(random_cloud(kSplats, degree));
    const std::string name = fmt::format("sog_degree{}", degree);
    seeds["sog"][name] = seeds["stability"][name] = test::bundle(files);
    seeds["sog_folder"][name] = bundle_of(files);
    seeds["sog_folder"][name + "_version1"] = bundle_of(version_one(files));
    seeds["sog_folder"][name + "_streamed"] =
        bundle_of(streamed(files, test::make_sog(random_cloud(kSplats, 1, 2)), kSplats));
  }
  Files small = test::make_sog(random_cloud(1, 0));
  std::vector<test::ZipEntry> entries;
  for (const auto& [name, content] : small) entries.push_back(deflated(name, content));
  seeds["sog"]["sog_deflated"] = test::zip_of(entries);
  test::json meta = test::meta_of(small);
  for (const char* key : {"scales", "sh0"}) meta[key]["codebook"] = {0.5};
  test::set_meta(small, meta);
  seeds["sog_folder"]["short_codebook"] = bundle_of(small);
}

Bytes with_count(std::size_t count, std::initializer_list<int> more, const Bytes& stream) {
  return joined(
      {raw({static_cast<int>(count & 255), static_cast<int>(count >> 8)}), raw(more), stream});
}

void add_codec(Seeds& seeds) {
  const QuantizationSteps fine{}, coarse{.position = 0.1, .log_scale = 1};
  for (const std::size_t count : {1u, 3u, 40u}) {
    for (const int degree : kDegrees) {
      for (const auto& steps : {fine, coarse}) {
        seeds["compact"][fmt::format("degree{}_{}_{}", degree, count, steps.position)] = with_count(
            count, {degree}, *codec::encode_compact(random_cloud(count, degree), {steps}));
      }
    }
    const SplatCloud cloud = random_cloud(count, 1);
    Bytes positions;
    require(codec::encode_positions(
                in_order(cloud, codec::position_order(cloud.positions, 1e-3)).positions, 1e-3,
                positions)
                .has_value(),
            "positions");
    seeds["positions"][fmt::format("{}", count)] = with_count(count, {}, positions);
    std::vector<codec::Cell> cells;
    for (const glm::vec3& p : cloud.positions) cells.emplace_back(100.0f * (p + 50.0f));
    seeds["draco_positions"][fmt::format("{}", count)] =
        with_count(count, {}, test::draco_positions(cells, 0.01));
    for (const std::size_t channels : {1u, 3u}) {
      codec::Channels list{channels, {}};
      for (std::size_t i = 0; i < count * channels; ++i)
        list.values.push_back(cloud.positions[i % count].x);
      Bytes stream;
      require(codec::encode_channels(list, 0.01f, {}, stream).has_value(), "channels");
      seeds["channels"][fmt::format("{}_of_{}", count, channels)] =
          with_count(count, {static_cast<int>(channels), static_cast<int>(count % 2)}, stream);
    }
  }
  Bytes triples;
  const codec::Layout layout{
      .step = 0.01f, .axes = {1, 0, 0, 0, 1, 0, 0, 0, 1}, .predicted = {0, 0, 0}};
  codec::encode_whole(layout, {{0, 1, -2, 9}, {3, 3, 3, 3}, {-1, 0, 0, 5}}, triples);
  seeds["channels"]["triples"] = with_count(4, {3, 0}, triples);
  for (const std::int32_t spread : {1, 2, 100, 1 << 20}) {
    std::vector<std::int32_t> numbers;
    for (std::int32_t i = 0; i < 50; ++i) numbers.push_back(i * i * 7919 % spread - spread / 2);
    Bytes stream;
    codec::encode_values({{numbers}}, stream);
    seeds["values"][fmt::format("spread{}", spread)] = with_count(numbers.size(), {0}, stream);
  }
  Bytes several;
  codec::encode_values({{{0, 1, 1, 5}, {7, 7, 7, 7}, {-1 << 25, 0, 3, 1 << 25}}}, several);
  seeds["values"]["channels"] = with_count(4, {2}, several);
}

void add_onnx(Seeds& seeds) {
  using namespace networks;
  auto& onnx = seeds["onnx"];
  onnx["raw"] = networks::test::RawModel().bytes();
  for (const auto& [name, signature] :
       {std::pair("psi", psi_signature()), std::pair("phi", phi_signature())}) {
    int columns = 0;
    for (const Columns& in : signature.inputs) columns += in.count;
    for (const std::vector<int>& hidden : {std::vector<int>{}, {4}, {3, 5}}) {
      std::vector<int> sizes{columns};
      sizes.insert(sizes.end(), hidden.begin(), hidden.end());
      sizes.push_back(signature.output.count);
      onnx[fmt::format("{}_{}", name, hidden.size())] =
          *encode_onnx(networks::test::random_mlp(sizes, 1), signature);
    }
  }
}

void add_floats(Seeds& seeds) {
  for (const int degree : kDegrees) {
    const SplatCloud cloud = random_cloud(2, degree);
    Bytes bytes = raw({degree});
    const auto put = [&](const auto& list) {
      for (const auto& value : list) append(bytes, value);
    };
    put(cloud.positions);
    put(cloud.log_scales);
    put(cloud.rotations);
    put(cloud.opacity_logits);
    put(cloud.sh_dc);
    put(cloud.sh_rest);
    seeds["stability"][fmt::format("floats_degree{}", degree)] = bytes;
  }
}

}  // namespace

void add_own_seeds(Seeds& seeds) {
  add_written(seeds);
  add_ply(seeds);
  add_ply_points(seeds);
  add_camera_track(seeds);
  add_image_header(seeds);
  add_compressed_ply(seeds);
  add_spz(seeds);
  add_glb(seeds);
  add_sog(seeds);
  add_codec(seeds);
  add_onnx(seeds);
  add_floats(seeds);
}

}  // namespace fluxgs::fuzz
