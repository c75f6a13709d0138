// Real scenes, cut to a few splats: what other programs write around them stays as it was.
#include <cstdio>

#include <fmt/format.h>

#include "file_bundle.h"
#include "fluxgs/io/file.h"
#include "io/ply/ply_header.h"
#include "io/sog/webp_image.h"
#include "io/sog/zip_archive.h"
#include "io/spz/spz_packed.h"
#include "seeds.h"
#include "unit/shared-format/glb_support.h"
#include "unit/shared-format/sog_support.h"
#include "unit/shared-format/spz_support.h"

namespace fluxgs::fuzz {
namespace {

namespace fs = std::filesystem;
using test::json;

constexpr std::size_t kSeedSplats = 8;

/// The first rows of every element, with a header that says so.
Expected<Bytes> cut_ply(const Bytes& bytes) {
  const auto header = io::parse_ply_header(bytes, "seed");
  if (!header) return std::unexpected(header.error());
  std::string text = test::text_of(Input(bytes).first(header->size));
  Bytes rows;
  std::size_t at = header->size;
  for (const io::PlyElement& element : header->elements) {
    const bool chunks = element.name == "chunk";
    const std::uint64_t kept = std::min<std::uint64_t>(element.count, chunks ? 1 : kSeedSplats);
    const std::string line = fmt::format("element {} ", element.name);
    const std::string whole = fmt::format("{}{}", line, element.count);
    const std::size_t found = text.find(whole);
    if (found == text.npos) return fail("seed", "header", "cannot find " + whole);
    text.replace(found, whole.size(), fmt::format("{}{}", line, kept));
    const std::uint64_t row = io::ply_row_bytes(element, header->encoding);
    const Input data = Input(bytes).subspan(at, kept * row);
    rows.insert(rows.end(), data.begin(), data.end());
    at += element.count * row;
  }
  return test::joined({test::bytes_of(text), rows});
}

struct SpzParts {
  Bytes header;  ///< 16 bytes
  std::vector<Bytes> attributes;
};

Expected<SpzParts> cut_spz_parts(const Bytes& bytes) {
  const io::SpzSource source{bytes, "seed", ""};
  const auto header = io::read_spz_header(source);
  if (!header) return std::unexpected(header.error());
  const auto packed = io::unpack_spz(source, *header);
  if (!packed) return std::unexpected(packed.error());
  const std::size_t count = std::min(kSeedSplats, header->count);
  SpzParts parts;
  parts.header = test::spz_header(header->version, static_cast<std::uint32_t>(count),
                                  header->sh_degree, 0, header->fractional_bits);
  const auto each = io::spz_attribute_bytes(header->version, header->sh_degree);
  for (std::size_t a = 0; a < io::kSpzAttributes; ++a) {
    if (each[a] == 0) continue;
    const Input data = Input(packed->data).subspan(packed->offsets[a], count * each[a]);
    parts.attributes.emplace_back(data.begin(), data.end());
  }
  return parts;
}

Bytes payload_of(const SpzParts& parts) {
  Bytes payload = parts.header;
  for (const Bytes& attribute : parts.attributes) payload = test::joined({payload, attribute});
  return payload;
}

Bytes file_of(const SpzParts& parts) {
  const auto count = test::u32_at(parts.header, 8);
  if (test::u32_at(parts.header, 4) < 4) return test::gzip(payload_of(parts));
  return test::spz4(count, std::to_integer<int>(parts.header[12]), parts.attributes);
}

/// The first elements of every accessor; those must lie one after the other in views of their own.
Expected<Bytes> cut_glb(const Bytes& bytes) {
  json root = json::parse(test::json_of(bytes));
  const Bytes bin = test::bin_of(bytes);
  Bytes kept;
  for (json& accessor : root["accessors"]) {
    json& view = root["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    const auto count = accessor["count"].get<std::size_t>();
    const auto length = view["byteLength"].get<std::size_t>();
    const auto offset = view.value("byteOffset", std::size_t{0});
    if (count == 0 || length % count != 0 || accessor.value("byteOffset", 0) != 0) {
      return fail("seed", "accessors", "lie otherwise than expected");
    }
    const Input data = Input(bin).subspan(offset, length / count * std::min(count, kSeedSplats));
    view["byteOffset"] = kept.size();
    view["byteLength"] = data.size();
    accessor["count"] = std::min(count, kSeedSplats);
    kept.insert(kept.end(), data.begin(), data.end());
  }
  root["buffers"][0]["byteLength"] = kept.size();
  return test::make_glb(root.dump(), kept);
}

/// The first pixels of an image, a row of them.
Expected<Bytes> cut_image(const Bytes& bytes) {
  const auto image = io::decode_webp(bytes, 1, 1 << 24, "seed", "image");
  if (!image) return std::unexpected(image.error());
  std::vector<test::Pixel> pixels(kSeedSplats);
  for (std::size_t i = 0; i < std::min(kSeedSplats, image->pixels()); ++i) {
    for (std::size_t c = 0; c < 4; ++c) pixels[i][c] = (*image)(i, c);
  }
  return test::webp(pixels);
}

/// Without SH coefficients, whose palette cannot be cut without changing every label.
Expected<Files> cut_sog(const Files& files) {
  Files cut;
  json meta = test::meta_of(files);
  meta.erase("shN");
  meta["count"] = kSeedSplats;
  for (const char* group : {"means", "scales", "quats", "sh0"}) {
    for (const json& file : meta[group]["files"]) {
      const std::string name = file.get<std::string>();
      auto image = cut_image(files.at(name));
      if (!image) return std::unexpected(image.error());
      cut[name] = std::move(*image);
    }
  }
  test::set_meta(cut, meta);
  return cut;
}

/// The entries of an archive whose members are stored or deflated.
Expected<Files> unzip(const Bytes& bytes) {
  const auto archive = io::ZipArchive::open(bytes, "seed");
  if (!archive) return std::unexpected(archive.error());
  Files files;
  for (const char* name :
       {"meta.json", "means_l.webp", "means_u.webp", "scales.webp", "quats.webp", "sh0.webp"}) {
    auto content = archive->read(name, 1 << 24);
    if (!content) return std::unexpected(content.error());
    files[name] = std::move(*content);
  }
  return files;
}

Expected<Files> read_folder(const fs::path& folder) {
  Files files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    auto content = read_file(entry.path());
    if (!content) return std::unexpected(content.error());
    files[entry.path().filename().string()] = std::move(*content);
  }
  return files;
}

/// Adds what can be made of one file; says so where nothing can.
class Adder {
 public:
  Adder(Seeds& seeds, fs::path root) : seeds_(seeds), root_(std::move(root)) {}

  template <class Cut>
  void add(const std::string& relative, Cut cut) {
    const fs::path path = root_ / relative;
    if (!fs::exists(path)) return;
    const auto bytes = read_file(path);
    const Expected<void> done = bytes ? cut(*bytes) : std::unexpected(bytes.error());
    if (!done)
      std::fprintf(stderr, "no seed of %s: %s\n", relative.c_str(), done.error().message().c_str());
  }

  auto into(const std::string& target, const std::string& name,
            Expected<Bytes> (*cut)(const Bytes&)) {
    return [=, this](const Bytes& bytes) -> Expected<void> {
      const auto seed = cut(bytes);
      if (!seed) return std::unexpected(seed.error());
      put(target, name, *seed);
      return {};
    };
  }

  void put(const std::string& target, const std::string& name, const Bytes& seed) {
    seeds_[target]["real_" + name] = seed;
    seeds_["stability"]["real_" + name] = seed;
    if (target != "glb") return;
    seeds_["glb_parts"]["real_" + name] =
        test::joined({test::bytes_of(test::json_of(seed)), Bytes(1), test::bin_of(seed)});
  }

  Seeds& seeds() { return seeds_; }

 private:
  Seeds& seeds_;
  fs::path root_;
};

void add_sog_files(Seeds& seeds, const std::string& name, const Files& files) {
  seeds["sog_folder"]["real_" + name] = bundle_of(files);
  seeds["sog"]["real_" + name] = test::bundle(files);
}

}  // namespace

void add_real_seeds(Seeds& seeds, const fs::path& data) {
  Adder adder(seeds, data / "splats");
  const auto as_it_is = [](const Bytes& bytes) -> Expected<Bytes> { return bytes; };
  const auto first_records = [](const Bytes& bytes) -> Expected<Bytes> {
    return Bytes(bytes.begin(), bytes.begin() + 32 * kSeedSplats);
  };
  const std::string dog = "plush-dog/point_cloud_29999_clean";
  adder.add(dog + ".ply", adder.into("ply", "dog", cut_ply));
  adder.add(dog + ".compressed.ply", adder.into("compressed_ply", "dog_compressed", cut_ply));
  adder.add("guitar/guitar.compressed.ply", adder.into("compressed_ply", "guitar", cut_ply));
  adder.add("biker/biker.compressed.ply", adder.into("compressed_ply", "biker", cut_ply));
  adder.add("plush-dog/converted/plush-dog.splat", adder.into("splat", "dog_splat", first_records));
  adder.add("plush-dog/converted/plush-dog.glb", adder.into("glb", "dog_glb", cut_glb));
  adder.add("spz-gltf-basic/basic.glb", adder.into("glb", "spz_basic", as_it_is));
  for (const std::string file : {"biker/biker.spz", "plush-dog/converted/plush-dog.v3.spz",
                                 "plush-dog/converted/plush-dog.v4.spz"}) {
    adder.add(file, [&](const Bytes& bytes) -> Expected<void> {
      const auto parts = cut_spz_parts(bytes);
      if (!parts) return std::unexpected(parts.error());
      const std::string name = fs::path(file).stem().string();
      adder.put("spz", name, file_of(*parts));
      seeds["spz_payload"]["real_" + name] = payload_of(*parts);
      return {};
    });
  }
  adder.add("angel-sog/angel.sog", [&](const Bytes& bytes) -> Expected<void> {
    const auto whole = unzip(bytes);
    if (!whole) return std::unexpected(whole.error());
    const auto cut = cut_sog(*whole);
    if (!cut) return std::unexpected(cut.error());
    add_sog_files(seeds, "angel", *cut);
    return {};
  });
  adder.add("playbot-sog-lod/6_0/meta.json", [&](const Bytes&) -> Expected<void> {
    const auto files = read_folder(data / "splats/playbot-sog-lod/6_0");
    if (!files) return std::unexpected(files.error());
    add_sog_files(seeds, "playbot", *files);
    return {};
  });
}

}  // namespace fluxgs::fuzz
