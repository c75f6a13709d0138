// SPZ from a stranger: damaged streams, counts that lie, bombs.
#include <random>

#include "spz_support.h"

namespace fluxgs {
namespace {

using namespace test;

// Without extension records, so that each byte belongs to splats.
Bytes small_spz(int version, std::size_t count = 3, int degree = 1) {
  return *encode_spz(spz_cloud(count, degree), "x", {.version = version, .name_axes = false});
}

// The unpacked content of versions 1 to 3.
Bytes inflated(const Bytes& file) {
  Bytes plain(1 << 20);
  const io::Inflated got = io::inflate_gzip(file, plain);
  EXPECT_TRUE(got.ended);
  plain.resize(got.written);
  return plain;
}

template <class T>
Bytes changed(Bytes bytes, std::size_t at, const T& value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
  return bytes;
}

TEST(HostileSpz, CutAtAnyByteIsAnError) {
  for (const int version : {3, 4}) {
    const Bytes bytes = small_spz(version);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      const Bytes cut(bytes.begin(), bytes.begin() + std::ptrdiff_t(size));  // exactly sized
      EXPECT_FALSE(read_as_spz(cut)) << version << ' ' << size;
    }
    const Bytes most(bytes.begin(), bytes.end() - 20);
    expect_error(read_as_spz(most), {"the file is cut off"});
    // Cut before it was compressed.
    if (version == 4) continue;
    const Bytes plain = inflated(bytes);
    for (std::size_t size = 0; size < plain.size(); ++size) {
      const Bytes cut(plain.begin(), plain.begin() + std::ptrdiff_t(size));
      expect_error(read_as_spz(gzip(cut)), {"test.spz: gzip: ends after"});
    }
  }
}

TEST(HostileSpz, BytesBehindTheEndAreIgnoredWithAWarningUnlessTheyArePadding) {
  for (const int version : {3, 4}) {
    const Bytes bytes = small_spz(version);
    const auto warnings = [&](const Bytes& tail) {
      const auto scene = read_as_spz(joined({bytes, tail}));
      EXPECT_TRUE(scene && scene->cloud.size() == 3) << version;
      return scene ? scene->warnings : std::vector<std::string>{"not read"};
    };
    using Lines = std::vector<std::string>;
    EXPECT_EQ(warnings(raw({0, 0, 0})), Lines());
    EXPECT_EQ(warnings(raw({0, 0, 0, 0})), Lines{"4 bytes behind its compressed data are ignored"});
    EXPECT_EQ(warnings(raw({7})), Lines{"1 bytes behind its compressed data are ignored"});
    EXPECT_EQ(warnings(bytes).size(), 1U);
  }
}

TEST(HostileSpz, HeadersAreChecked) {
  const Bytes plain = inflated(small_spz(3));
  const auto with = [&](std::size_t at, auto value) {
    return read_as_spz(gzip(changed(plain, at, value)));
  };
  expect_error(with(0, 'X'), {"test.spz: header", "NGSP"});
  for (const std::uint32_t version : {0u, 4u, 5u, 0xffffffffu}) {
    expect_error(with(4, version), {"header", fmt::format("version {} inside", version), "1 to 3"});
  }
  expect_error(with(12, char{5}), {"header", "degree 5", "0 to 4"});
  expect_error(with(13, char{25}), {"header", "25 fractional bits", "0 to 24"});
  FLUXGS_UNWRAP(unknown, with(14, char{'\x84'}));
  ASSERT_EQ(unknown.warnings.size(), 1U);
  EXPECT_TRUE(unknown.warnings[0].contains("unknown flags (0x84)")) << unknown.warnings[0];
  FLUXGS_UNWRAP(antialiased, with(14, char{1}));
  EXPECT_TRUE(antialiased.cloud.filter.compensated);
  EXPECT_TRUE(antialiased.warnings.empty());
  EXPECT_TRUE(with(15, char{9}));  // reserved
  expect_error(read_as_spz(plain), {"header", "version 3 outside of gzip"});
  const Bytes four = small_spz(4);
  expect_error(read_as_spz(changed(four, 4, std::uint32_t{5})), {"version 5 outside of gzip"});
  expect_error(read_as_spz(changed(four, 12, char{9})), {"degree 9"});
  expect_error(read_as_spz(bytes_of("NGSP and so on")), {"header", "14 bytes"});
  expect_error(read_as_spz(bytes_of("neither of them")), {"gzip", "damaged"});
}

TEST(HostileSpz, CountsThatLieAreRefused) {
  const Bytes plain = inflated(small_spz(3));
  const auto counted = [&](std::uint32_t count) {
    return read_as_spz(gzip(changed(plain, 8, count)));
  };
  expect_error(counted(4), {"gzip: ends after 103 bytes; expected 132"});
  expect_error(counted(2), {"gzip: holds more than the 74 bytes"});
  expect_error(counted(0), {"gzip: holds more than the 16 bytes"});
  expect_error(counted(1 << 20), {"gzip: ends after 103 bytes"});
  expect_error(counted((1 << 20) + 1), {"header: promises 1048577 splats", "32 times"});
  expect_error(counted(0xffffffff), {"header: promises 4294967295 splats"});
  const Bytes four = small_spz(4);
  expect_error(read_as_spz(changed(four, 8, std::uint32_t{4})),
               {"stream 0: promises 27 bytes; the splats of the header take 36"});
  expect_error(read_as_spz(changed(four, 8, std::uint32_t{0})), {"6 streams; expected 0"});
  expect_error(read_as_spz(changed(four, 8, std::uint32_t{0xffffffff})), {"promises 4294967295"});
}

TEST(HostileSpz, TablesAreChecked) {
  const Bytes four = small_spz(4);
  expect_error(read_as_spz(changed(four, 15, char{5})), {"5 streams; expected 6"});
  for (const std::uint32_t at : {0u, 31u, 0xffffffffu, std::uint32_t(four.size())}) {
    expect_error(read_as_spz(changed(four, 16, at)), {"header", "table of 6 streams"});
  }
  EXPECT_FALSE(read_as_spz(changed(four, 16, std::uint32_t{33})));
  for (const std::uint64_t size : {std::uint64_t{100000}, ~std::uint64_t{0}}) {
    expect_error(read_as_spz(changed(four, 32, size)), {"stream 0: takes", "are left"});
    expect_error(read_as_spz(changed(four, 40, size)), {"stream 0: promises", "take 27"});
  }
  expect_error(read_as_spz(changed(four, 32, std::uint64_t{3})), {"stream 0: zstd"});
  expect_error(read_as_spz(changed(four, 32 + 6 * 16, std::uint32_t{0})), {"stream 0: zstd"});
}

TEST(HostileSpz, GzipBombsAreRefused) {
  Bytes zeros(std::size_t(32) << 20);
  const Bytes header = spz_header(3, 1, 0);
  std::ranges::copy(header, zeros.begin());
  Bytes bomb = gzip(zeros);
  EXPECT_LT(bomb.size(), 100'000u);
  expect_error(read_as_spz(bomb), {"gzip: holds more than the 36 bytes"});
  const auto count = static_cast<std::uint32_t>((zeros.size() - 16) / 20);
  std::ranges::copy(spz_header(3, count, 0), zeros.begin());
  bomb = gzip(zeros);
  expect_error(read_as_spz(bomb), {"header: promises", "at most 32 times"});
  // Room for extensions is no room for more.
  std::ranges::copy(spz_header(3, 1, 0, 2), zeros.begin());
  expect_error(read_as_spz(gzip(zeros)), {"gzip: holds more than the 65572 bytes"});
}

TEST(HostileSpz, ZstdBombsAreRefused) {
  const auto bomb = [](std::uint32_t count, std::uint64_t promised) {
    Bytes file =
        spz4(count, 0, {Bytes(std::size_t(32) << 20), Bytes(1), Bytes(3), Bytes(3), Bytes(4)});
    return changed(file, 40, promised);
  };
  EXPECT_LT(bomb(1, 9).size(), 20'000u);
  expect_error(read_as_spz(bomb(1, 9)), {"stream 0: zstd", "too small"});
  expect_error(read_as_spz(bomb(1, 32 << 20)), {"stream 0: promises 33554432 bytes"});
  expect_error(read_as_spz(bomb(3728270, 32 << 20)), {"header: promises 3728270 splats"});
}

TEST(HostileSpz, ChecksumsAreChecked) {
  Bytes file = small_spz(3);
  file[file.size() - 8] ^= std::byte{1};  // CRC-32
  expect_error(read_as_spz(file), {"gzip: is damaged"});
  file = small_spz(3);
  file[file.size() - 1] ^= std::byte{1};  // length
  expect_error(read_as_spz(file), {"gzip: is damaged"});
}

// Scenes of equal splats compress far, and small ones are read all the same.
TEST(HostileSpz, EqualSplatsAreNoBomb) {
  SplatCloud cloud;
  cloud.resize(200'000);
  for (const int version : {3, 4}) {
    FLUXGS_UNWRAP(bytes, encode_spz(cloud, "x", {version}));
    EXPECT_LT(bytes.size(), 40'000u);
    FLUXGS_UNWRAP(scene, read_as_spz(bytes));
    EXPECT_EQ(scene.cloud.size(), cloud.size());
  }
}

// Damaged files may be read or refused, but nothing else (run under the sanitizers).
TEST(HostileSpz, DamagedFilesNeverCrash) {
  const Bytes three = small_spz(3, 2), four = small_spz(4, 2), plain = inflated(three);
  std::mt19937 random(9);
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    Bytes damaged = i % 3 == 0 ? three : i % 3 == 1 ? four : plain;
    const unsigned changes = 1 + random() % 3;
    for (unsigned k = 0; k < changes; ++k) {
      const std::size_t room =
          random() % 2 ? damaged.size() : std::min<std::size_t>(128, damaged.size());
      damaged[random() % room] = std::byte(random());
    }
    if (random() % 8 == 0) damaged.resize(random() % damaged.size());
    if (i % 3 == 2) damaged = gzip(damaged);
    (void)is_spz(damaged);
    const auto scene = read_as_spz(damaged);
    accepted += scene.has_value();
    if (scene) {
      EXPECT_EQ(count_non_finite(scene->cloud), 0u);
    }
  }
  EXPECT_GT(accepted, 1000);
}

}  // namespace
}  // namespace fluxgs
