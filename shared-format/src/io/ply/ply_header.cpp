#include "io/ply/ply_header.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <limits>
#include <locale>
#include <sstream>
#include <string_view>

#include <fmt/format.h>

#include "fluxgs/sanitize.h"

namespace fluxgs::io {
namespace {

constexpr std::size_t kMaxHeader = std::size_t(1) << 20;

std::optional<PlyType> type_named(std::string_view text) {
  struct Row {
    std::string_view old_name, new_name;
    PlyType type;
  };
  static constexpr std::array<Row, 8> kTypes{{{"char", "int8", PlyType::int8},
                                              {"uchar", "uint8", PlyType::uint8},
                                              {"short", "int16", PlyType::int16},
                                              {"ushort", "uint16", PlyType::uint16},
                                              {"int", "int32", PlyType::int32},
                                              {"uint", "uint32", PlyType::uint32},
                                              {"float", "float32", PlyType::float32},
                                              {"double", "float64", PlyType::float64}}};
  for (const Row& row : kTypes) {
    if (text == row.old_name || text == row.new_name) return row.type;
  }
  return std::nullopt;
}

// True if a word of any case is that word in lower case.
bool is_word(std::string_view word, std::string_view lower_case) {
  return std::ranges::equal(word, lower_case, {}, [](char c) {
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  });
}

std::uint64_t saturating_multiply(std::uint64_t a, std::uint64_t b) {
  constexpr auto kMax = std::numeric_limits<std::uint64_t>::max();
  return b != 0 && a > kMax / b ? kMax : a * b;
}
std::uint64_t saturating_add(std::uint64_t a, std::uint64_t b) {
  return a + b < a ? std::numeric_limits<std::uint64_t>::max() : a + b;
}

std::string in_quotes(std::string_view text) { return '"' + sanitized(text) + '"'; }

class HeaderParser {
 public:
  explicit HeaderParser(const std::string& name) : name_(name) {}

  // One line of the header; true once it was "end_header".
  Expected<bool> take(std::string_view line) {
    ++line_;
    const auto words = words_of(line);
    if (line_ == 1) {
      if (words.size() == 1 && words[0] == "ply") return false;
      return bad(line, "expected \"ply\"");
    }
    if (words.empty()) return false;
    if (is_word(words[0], "comment")) return take_comment(words);
    if (is_word(words[0], "obj_info")) return false;
    if (words[0] == "end_header") return finish();
    if (words[0] == "format") return take_format(line, words);
    if (words[0] == "element") return take_element(line, words);
    if (words[0] == "property") return take_property(line, words);
    return bad(line, "expected format, element, property, comment or end_header");
  }

  PlyHeader header;

 private:
  bool take_comment(const std::vector<std::string_view>& words) {
    if (words.size() == 1) return false;
    const char* end = words.back().data() + words.back().size();
    header.comments.emplace_back(words[1].data(), end);
    return false;
  }

  Expected<bool> take_format(std::string_view line, const std::vector<std::string_view>& words) {
    if (words.size() != 3 || words[2] != "1.0") return bad(line, "expected \"format NAME 1.0\"");
    if (words[1] == "ascii") {
      header.encoding = PlyEncoding::ascii;
    } else if (words[1] == "binary_little_endian") {
      header.encoding = PlyEncoding::little_endian;
    } else if (words[1] == "binary_big_endian") {
      header.encoding = PlyEncoding::big_endian;
    } else {
      return bad(line, "expected ascii, binary_little_endian or binary_big_endian");
    }
    has_format_ = true;
    return false;
  }

  Expected<bool> take_element(std::string_view line, const std::vector<std::string_view>& words) {
    PlyElement element;
    if (words.size() != 3) return bad(line, "expected \"element NAME COUNT\"");
    const auto [end, error] =
        std::from_chars(words[2].data(), words[2].data() + words[2].size(), element.count);
    if (error != std::errc() || end != words[2].data() + words[2].size()) {
      return bad(line, "expected a count from 0 to 2^64-1");
    }
    element.name = words[1];
    header.elements.push_back(std::move(element));
    return false;
  }

  Expected<bool> take_property(std::string_view line, const std::vector<std::string_view>& words) {
    if (header.elements.empty()) return bad(line, "expected an element before its properties");
    const bool is_list = words.size() == 5 && words[1] == "list";
    if (!is_list && words.size() != 3) return bad(line, "expected \"property TYPE NAME\"");
    const auto type = type_named(words[is_list ? 3 : 1]);
    const auto count = is_list ? type_named(words[2]) : std::nullopt;
    const bool float_count = count == PlyType::float32 || count == PlyType::float64;
    if (!type || (is_list && (!count || float_count))) {
      return bad(line,
                 "expected a PLY scalar type (char, uchar, short, ushort, int, uint, float, "
                 "double)");
    }
    auto& properties = header.elements.back().properties;
    properties.push_back({std::string(words.back()), *type, count});
    return false;
  }

  Expected<bool> finish() {
    if (!has_format_) return fail(name_, "header", "has no \"format\" line");
    return true;
  }

  std::unexpected<Error> bad(std::string_view line, std::string_view expected) const {
    return fail(name_, fmt::format("header line {}", line_),
                fmt::format("{}: {}", in_quotes(line), expected));
  }

  const std::string& name_;
  int line_ = 0;
  bool has_format_ = false;
};

Expected<void> check_promise(const PlyHeader& header, std::uint64_t file_size,
                             const std::string& name) {
  std::uint64_t need = 0;
  for (const PlyElement& element : header.elements) {
    need = saturating_add(
        need, saturating_multiply(element.count, ply_row_bytes(element, header.encoding)));
  }
  if (header.encoding == PlyEncoding::ascii && need > 0) --need;  // no newline after the last row
  const std::uint64_t have = file_size - header.size;
  if (need <= have) return {};
  std::string promised;
  for (const PlyElement& element : header.elements) {
    promised += fmt::format("{}{} {} of {} bytes", promised.empty() ? "" : ", ", element.count,
                            in_quotes(element.name), ply_row_bytes(element, header.encoding));
  }
  return fail(
      name, "header",
      fmt::format("promises {}{} bytes of data ({}), but the file holds {} after its header",
                  need == std::numeric_limits<std::uint64_t>::max() ? "more than " : "", need,
                  promised.substr(0, 300), have));
}

}  // namespace

std::vector<std::string_view> words_of(std::string_view line) {
  constexpr std::string_view kBlank = " \t\r";
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(kBlank); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlank, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(kBlank, end);
  }
  return words;
}

std::optional<double> number_of(std::string_view word) {
  std::istringstream stream{std::string(word)};
  stream.imbue(std::locale::classic());
  double number = 0;
  if (!(stream >> std::noskipws >> number) ||
      stream.peek() != std::istringstream::traits_type::eof())
    return std::nullopt;
  return number;
}

bool PlyElement::has_lists() const {
  return std::ranges::any_of(properties, [](const auto& p) { return p.list_count.has_value(); });
}

std::size_t ply_type_bytes(PlyType type) {
  switch (type) {
    case PlyType::int8:
    case PlyType::uint8:
      return 1;
    case PlyType::int16:
    case PlyType::uint16:
      return 2;
    case PlyType::int32:
    case PlyType::uint32:
    case PlyType::float32:
      return 4;
    case PlyType::float64:
      break;
  }
  return 8;
}

std::uint64_t ply_row_bytes(const PlyElement& element, PlyEncoding encoding) {
  std::uint64_t bytes = 0;
  for (const PlyProperty& property : element.properties) {
    // In text every number takes a digit and a separator.
    bytes += encoding == PlyEncoding::ascii
                 ? 2
                 : ply_type_bytes(property.list_count.value_or(property.type));
  }
  return bytes;
}

Expected<PlyHeader> parse_ply_header(std::span<const std::byte> bytes, const std::string& name) {
  return parse_ply_header(bytes, bytes.size(), name);
}

Expected<PlyHeader> read_ply_header(const ByteSource& source, const std::string& name) {
  std::vector<std::byte> room;
  const auto most = static_cast<std::size_t>(std::min<std::uint64_t>(source.size(), kMaxHeader));
  const auto begin = source.read(0, most, room);
  if (!begin) return std::unexpected(begin.error());
  return parse_ply_header(*begin, source.size(), name);
}

Expected<PlyHeader> parse_ply_header(std::span<const std::byte> bytes, std::uint64_t size,
                                     const std::string& name) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()),
                              std::min(bytes.size(), kMaxHeader));
  HeaderParser parser(name);
  for (std::size_t at = 0;;) {
    const std::size_t end = text.find('\n', at);
    if (end == std::string_view::npos) {
      return fail(name, "header",
                  fmt::format("no \"end_header\" line within the first {} bytes", text.size()));
    }
    const auto done = parser.take(text.substr(at, end - at));
    if (!done) return std::unexpected(done.error());
    at = end + 1;
    if (!*done) continue;
    parser.header.size = at;
    if (auto kept = check_promise(parser.header, size, name); !kept) {
      return std::unexpected(kept.error());
    }
    return std::move(parser.header);
  }
}

}  // namespace fluxgs::io
