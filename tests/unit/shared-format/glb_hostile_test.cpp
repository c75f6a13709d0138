// A .glb from a stranger: framing, JSON, counts and references that are wrong on purpose.
#include "glb_support.h"

#include "fluxgs/io/file.h"
#include "support/sanitized.h"

namespace fluxgs {
namespace {

using namespace test;

void set_u32(Bytes& bytes, std::size_t at, std::uint32_t value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

TEST(HostileGlb, CutAtAnyByteIsAnError) {
  const Bytes bytes = small_glb();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    Bytes cut(bytes.begin(), bytes.begin() + std::ptrdiff_t(size));  // exactly sized for ASan
    EXPECT_FALSE(read(cut)) << size;
    if (size < 12) continue;
    set_u32(cut, 8, static_cast<std::uint32_t>(size));  // a header that agrees
    EXPECT_FALSE(read(cut)) << size;
  }
}

TEST(HostileGlb, FramingIsChecked) {
  const Bytes ok = small_glb();
  const auto with = [&](std::size_t at, std::uint32_t value) {
    Bytes bytes = ok;
    set_u32(bytes, at, value);
    return read(bytes);
  };
  expect_error(with(0, 0), {"test.glb: header", "glTF"});
  expect_error(with(4, 1), {"header", "version 1; expected 2"});
  expect_error(with(8, 0xffffffff), {"header", "promises 4294967295 bytes"});
  expect_error(with(8, 12), {"header", "promises 12 bytes"});
  expect_error(with(12, 0xfffffffc), {"chunk 0", "promises 4294967292"});
  expect_error(with(12, 7), {"chunk 0", "multiple of 4"});
  expect_error(with(16, 0x004E4942), {"chunk 0", "not JSON"});
  const std::size_t bin = 20 + u32_at(ok, 12);
  expect_error(with(bin, u32_at(ok, bin) + 4), {"chunk 1", "promises"});
  expect_error(with(bin + 4, 0x4E4F534A), {"chunk 1", "second JSON"});
  expect_error(with(bin + 4, 0x12345678), {"buffers[0].byteLength", "BIN chunk holds 0"});
  expect_error(read({}), {"header", "0 bytes"});
}

TEST(HostileGlb, UnknownChunksAtTheEndAreSkipped) {
  Bytes bytes = small_glb();
  append(bytes, std::uint32_t{4});
  append(bytes, std::uint32_t{0x58585858});
  append(bytes, std::uint32_t{0});
  set_u32(bytes, 8, static_cast<std::uint32_t>(bytes.size()));
  EXPECT_TRUE(read(bytes));
}

TEST(HostileGlb, DeepNestingIsRefusedBeforeParsing) {
  for (const std::size_t depth : {65u, 100000u, 5000000u}) {
    expect_error(read(make_glb(std::string(depth, '['))),
                 {"JSON", fmt::format("nested {} deep", depth)});
    expect_error(
        read(make_glb(R"({"extras":)" + std::string(depth, '[') + std::string(depth, ']') + "}")),
        {"JSON", "nested"});
  }
  // Brackets inside strings do not count.
  EXPECT_TRUE(read(edited(small_glb(), R"("asset":{)",
                          R"("extras":")" + std::string(200, '[') + R"(\"[[","asset":{)")));
}

TEST(HostileGlb, BrokenJsonIsExplained) {
  for (const char* text : {"", "null", "[]", "{", R"({"asset":)", "\xff\xfe\xfd",
                           R"({"asset":{"version":"2.0"},"a":1e999})", R"("{}")"}) {
    expect_error(read(make_glb(text)), {"JSON"});
  }
  expect_error(read(make_glb(std::string("{\0}", 3))), {"JSON", "is not JSON from byte 2 on"});
  expect_error(read(make_glb("{}")), {"asset.version", "is missing; expected \"2.0\""});
  expect_error(read(make_glb(R"({"asset":{"version":"1.0"}})")), {"asset.version", "1.0"});
  expect_error(read(make_glb(R"({"asset":{"version":2}})")), {"asset.version"});
  expect_error(read(make_glb(R"({"asset":{"version":"2.0"}})")),
               {"meshes", "no primitive has KHR_gaussian_splatting"});
  expect_error(read(make_glb(std::string((16 << 20) + 4, ' ') + "{}")), {"JSON", "16777216"});
  std::string many = R"({"asset":{"version":"2.0"},"nodes":[{})";
  for (int i = 0; i < 70000; ++i) many += ",{}";
  expect_error(read(make_glb(many + "]}")), {"nodes", "at most 65536"});
}

TEST(HostileGlb, EveryListOfTheWrongKindIsRefused) {
  const Bytes ok = small_glb();
  for (const char* key :
       {"accessors", "bufferViews", "buffers", "meshes", "nodes", "scenes", "extensionsUsed"}) {
    for (const char* wrong : {"{}", "1", "\"x\"", "[1]", "[[]]"}) {
      if (std::string_view(key) == "extensionsUsed" && std::string_view(wrong) == "\"x\"") continue;
      std::string json = json_of(ok);
      const std::string quoted = fmt::format("\"{}\":[", key);
      const std::size_t at = json.find(quoted);
      ASSERT_NE(at, std::string::npos);
      json.replace(at, quoted.size(), fmt::format("\"{}\":{},\"was\":[", key, wrong));
      expect_error(read(make_glb(json, bin_of(ok))), {key});
    }
  }
}

TEST(HostileGlb, UnknownRequiredExtensionsAreNamed) {
  const Bytes ok = small_glb();
  const auto required = [&](const std::string& list) {
    return read(edited(ok, R"("extensionsUsed":)",
                       fmt::format(R"("extensionsRequired":{},"extensionsUsed":)", list)));
  };
  expect_error(required(R"(["VENDOR_secret"])"), {"extensionsRequired", "VENDOR_secret"});
  expect_error(required(R"(["KHR_gaussian_splatting","EXT_meshopt_compression"])"),
               {"extensionsRequired", "EXT_meshopt_compression"});
  expect_error(required("[7]"), {"extensionsRequired"});
  EXPECT_TRUE(required(R"(["KHR_gaussian_splatting"])"));
}

TEST(HostileGlb, CompressedSplatsAreNamedEvenIfNotRequired) {
  for (const char* other :
       {"KHR_gaussian_splatting_compression_x", "KHR_gaussian_splatting_compression_spz_3"}) {
    expect_error(
        read(edited(
            small_glb(), R"("KHR_gaussian_splatting":{)",
            fmt::format(R"("KHR_gaussian_splatting":{{"extensions":{{"{}":{{"bufferView":0}}}},)",
                        other))),
        {"meshes[0].primitives[0]", other, "not supported"});
  }
}

TEST(HostileGlb, UrisOfBuffersAreRefusedByName) {
  const Bytes ok = small_glb();
  const auto with = [&](const std::string& uri) {
    return read(edited(ok, R"("buffers":[{)", fmt::format(R"("buffers":[{{"uri":{},)", uri)));
  };
  for (const char* uri :
       {"../../etc/passwd", "https://example.org/x.bin", "/etc/passwd", "file:x.bin", "a/../b.bin",
        "C:x.bin", "$(reboot)", "x.bin", "", "%2e%2e%2fx.bin", "%00", "%zz", "x%0a.bin"}) {
    expect_error(with(fmt::format("\"{}\"", uri)), {"buffers[0].uri", uri});
  }
  expect_error(with("7"), {"buffers[0].uri", "expected text"});
  expect_error(with("{}"), {"buffers[0].uri", "expected text"});
  const std::string blob(1000, 'A');
  for (const std::string& uri : {"data:" + blob, "data:," + blob, "data:x;base32," + blob}) {
    const auto scene = with("\"" + uri + "\"");
    expect_error(scene, {"buffers[0].uri", "base64"});
    EXPECT_LT(scene.error().message().size(), 300u);
  }
  for (const char* text : {"A*AA", "AA AA", "AA=A", "\xc3\xa4", "AA\\nAA"})
    expect_error(with(fmt::format("\"data:;base64,{}\"", text)), {"buffers[0].uri", "base64"});
  expect_error(with("\"data:application/octet-stream;base64,AAAA\""),
               {"buffers[0].byteLength", "URI holds 3 bytes"});
  // A number of ours in a document of theirs
  expect_error(with("\"\\u0064ata:7\""), {"buffers[0].uri"});
  EXPECT_TRUE(read(edited(ok, R"("buffers":[)", R"("images":[{"uri":"x.png"}],"buffers":[)")));
}

TEST(HostileGlb, HugeNumbersAreRefusedBeforeAllocating) {
  const Bytes ok = small_glb();
  for (const char* huge : {"3", "2147483648", "4294967298", "4611686018427387904",
                           "9223372036854775808", "18446744073709551615", "18446744073709551616",
                           "1e300", "-1", "2.5", "\"2\"", "null", "1537228672809129302"}) {
    EXPECT_FALSE(read(edited(ok, R"("count":2)", fmt::format(R"("count":{})", huge)))) << huge;
    EXPECT_FALSE(read(edited(ok, R"("byteLength":24,)", fmt::format(R"("byteLength":{},)", huge))))
        << huge;
  }
  for (const char* huge : {"400", "2147483648", "9007199254740991", "9223372036854775808", "-4"}) {
    EXPECT_FALSE(read(edited(ok, R"("byteOffset":32,)", fmt::format(R"("byteOffset":{},)", huge))));
    EXPECT_FALSE(read(
        edited(ok, R"("bufferView":2,)", fmt::format(R"("bufferView":2,"byteOffset":{},)", huge))));
  }
  for (const char* index : {"99", "4294967296", "-1", "1.5", "true", "[0]"}) {
    EXPECT_FALSE(read(edited(ok, R"("bufferView":0,)", fmt::format(R"("bufferView":{},)", index))));
    EXPECT_FALSE(read(edited(ok, R"("buffer":0,)", fmt::format(R"("buffer":{},)", index))));
    EXPECT_FALSE(read(edited(ok, R"("POSITION":0)", fmt::format(R"("POSITION":{})", index))));
    EXPECT_FALSE(read(edited(ok, R"({"mesh":0})", fmt::format(R"({{"mesh":{}}})", index))));
    EXPECT_FALSE(read(edited(ok, R"("nodes":[0])", fmt::format(R"("nodes":[{}])", index))));
    EXPECT_FALSE(read(edited(ok, R"("scene":0)", fmt::format(R"("scene":{})", index))));
  }
  const Bytes zeros = edited(ok, R"("bufferView":0,)", "");
  expect_error(read(edited(zeros, R"("count":2)", R"("count":2000000000)")), {"POSITION", "zeros"});
  expect_error(read(edited(ok, R"("count":2)", R"("count":1)")),
               {"has 2 elements", "POSITION has 1"});
  expect_error(read(edited(ok, R"("byteLength":24,)", R"("byteLength":24,"byteStride":8,)")),
               {"byteStride", "less than the 12"});
  expect_error(read(edited(ok, R"("byteLength":24,)", R"("byteLength":24,"byteStride":16,)")),
               {"POSITION", "promises 2 elements"});
}

TEST(HostileGlb, WrongTypesAreNamed) {
  const Bytes ok = small_glb(2, 0);
  const auto with = [&](const std::string& from, const std::string& to) {
    return read(edited(ok, from, to));
  };
  expect_error(with(R"("type":"SCALAR")", R"("type":"VEC2")"),
               {"KHR_gaussian_splatting:OPACITY", "VEC2 of float; expected SCALAR"});
  expect_error(with(R"("type":"SCALAR")", R"("type":"MAT4")"), {"OPACITY", "a matrix"});
  expect_error(with(R"("type":"SCALAR")", R"("type":"VEC9")"), {"VEC9"});
  expect_error(with(R"("type":"SCALAR")", R"("type":5)"), {"accessors[4].type"});
  // Signed scales are those of the drafts, which were logarithms.
  expect_error(
      with(R"("bufferView":3,"componentType":5126)", R"("bufferView":3,"componentType":5122)"),
      {"SCALE", "signed short", "unsigned byte or short"});
  expect_error(
      with(R"("bufferView":2,"componentType":5126)", R"("bufferView":2,"componentType":5120)"),
      {"ROTATION", "signed byte; expected"});
  expect_error(
      with(R"("bufferView":2,"componentType":5126)", R"("bufferView":2,"componentType":5130)"),
      {"ROTATION", "double"});
  expect_error(
      with(R"("bufferView":2,"componentType":5126)", R"("bufferView":2,"componentType":1)"),
      {"componentType"});
  expect_error(with(R"("mode":0)", R"("mode":4)"), {"has mode 4; splats need POINTS"});
  expect_error(with(R"(,"mode":0)", ""), {"has mode 4"});
  expect_error(with(R"("kernel":"ellipse")", R"("kernel":"disk")"), {"kernel", "disk", "ellipse"});
  expect_error(with(R"("kernel":"ellipse")", R"("kernel":7)"), {"kernel", "7; expected a name"});
  expect_error(with(R"("colorSpace":"srgb_rec709_display")", R"("colorSpace":"BT.2020-pq")"),
               {"colorSpace", "BT.2020-pq", "lin_rec709_display"});
  expect_error(with(R"("KHR_gaussian_splatting":{)", R"("KHR_gaussian_splatting":7,"was":{)"),
               {"KHR_gaussian_splatting", "expected an object"});
  expect_error(with(R"("normalized":true)", R"("normalized":1)"), {"accessors[1].normalized"});
  expect_error(with(R"("bufferView":0,)", R"("bufferView":0,"sparse":{"count":1},)"),
               {"accessors[0].sparse", "bufferView"});
}

TEST(HostileGlb, MissingAttributesAreNamed) {
  const Bytes ok = small_glb(2, 3);
  for (const char* semantic :
       {"POSITION", "KHR_gaussian_splatting:ROTATION", "KHR_gaussian_splatting:SCALE",
        "KHR_gaussian_splatting:OPACITY", "KHR_gaussian_splatting:SH_DEGREE_0_COEF_0",
        "KHR_gaussian_splatting:SH_DEGREE_1_COEF_2", "KHR_gaussian_splatting:SH_DEGREE_2_COEF_0",
        "KHR_gaussian_splatting:SH_DEGREE_3_COEF_6"}) {
    expect_error(read(edited(ok, fmt::format("\"{}\"", semantic), "\"_OTHER\"")),
                 {"meshes[0].primitives[0]", fmt::format("attribute {} is missing", semantic)});
  }
}

TEST(HostileGlb, NodesThatAreNoTreeAreRefused) {
  const Bytes ok = small_glb();
  const auto nodes = [&](const std::string& list) {
    return read(edited(ok, R"("nodes":[{"mesh":0}])", R"("nodes":)" + list));
  };
  expect_error(nodes(R"([{"children":[0],"mesh":0}])"), {"nodes[0]", "reached twice"});
  expect_error(nodes(R"([{"children":[1]},{"children":[0]}])"), {"reached twice"});
  expect_error(nodes(R"([{"children":[1,1]},{"mesh":0}])"), {"nodes[1]", "reached twice"});
  expect_error(nodes(R"([{"children":[5]}])"), {"nodes[5]", "does not exist"});
  expect_error(nodes(R"([{"children":7}])"), {"nodes[0].children"});
}

// Three bytes each in the file, hundreds in memory
TEST(HostileGlb, PrimitivesOfAllMeshesAreCountedTogether) {
  std::string meshes = R"("meshes":[)";
  for (int m = 0; m < 70; ++m) {
    meshes += m == 0 ? R"({"primitives":[{})" : R"(,{"primitives":[{})";
    for (int i = 1; i < 1000; ++i) meshes += ",{}";
    meshes += "]}";
  }
  expect_error(read(make_glb(R"({"asset":{"version":"2.0"},)" + meshes + "]}")),
               {"meshes[65].primitives", "more than 65536 primitives in all meshes"});
}

TEST(HostileGlb, LongChainsOfNodesDoNotOverflowTheStack) {
  std::string nodes = R"("nodes":[)";
  for (int i = 1; i < 60000; ++i) nodes += fmt::format(R"({{"children":[{}]}},)", i);
  EXPECT_TRUE(read(edited(small_glb(), R"("nodes":[{"mesh":0}])", nodes + R"({"mesh":0}])")));
}

TEST(HostileGlb, ManyInstancesCannotDemandMemoryOutOfProportion) {
  const Bytes ok = small_glb(1000, 0);
  const auto instances = [&](int count) {
    std::string nodes = R"("nodes":[{"children":[1)";
    for (int i = 2; i <= count; ++i) nodes += fmt::format(",{}", i);
    nodes += "]}";
    for (int i = 0; i < count; ++i) nodes += R"(,{"mesh":0})";
    return edited(ok, R"("nodes":[{"mesh":0}])", nodes + "]");
  };
  FLUXGS_UNWRAP(scene, read(instances(5)));
  EXPECT_EQ(scene.cloud.size(), 5000u);
  expect_error(read(instances(1000)), {"nodes", "repeating meshes"});
}

// Damaged files may be read or refused, but nothing else (run under the sanitizers).
TEST(HostileGlb, DamagedFilesNeverCrash) {
  const Bytes ok = small_glb(2, 1);
  const std::size_t json = 20, json_size = u32_at(ok, 12);
  std::mt19937 random(8);
  constexpr std::string_view kLikely = "0123456789-{}[]\",:eE.tfn";
  int accepted = 0;
  for (int i = 0; i < (test::kSanitized ? 5000 : 15000); ++i) {
    Bytes damaged = ok;
    const unsigned changes = 1 + random() % 3;
    for (unsigned k = 0; k < changes; ++k) {
      if (i % 3 == 0) {
        damaged[random() % damaged.size()] = std::byte(random());
      } else {
        damaged[json + random() % json_size] = std::byte(kLikely[random() % kLikely.size()]);
      }
    }
    const auto scene = read(damaged);
    accepted += scene.has_value();
    if (scene) {
      EXPECT_EQ(count_non_finite(scene->cloud), 0u);
    }
  }
  EXPECT_GT(accepted, test::kSanitized ? 30 : 100);
}

}  // namespace
}  // namespace fluxgs
