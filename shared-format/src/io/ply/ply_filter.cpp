#include "io/ply/ply_filter.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "io/ply/ply_header.h"

namespace fluxgs::io {
namespace {

constexpr double kMipDilation = 0.1;  // of Brush, as in Mip-Splatting (Yu et al. 2024)

// Lower-case words of letters and numbers; what is between them does not count.
std::vector<std::string> plain_words(std::string_view text) {
  std::vector<std::string> words(1);
  for (const char raw : text) {
    const auto c = static_cast<unsigned char>(raw);
    if (std::isalnum(c) != 0 || c == '_' || c == '.' || c == '-' || c == '+')
      words.back() += static_cast<char>(std::tolower(c));
    else if (!words.back().empty())
      words.emplace_back();
  }
  words.resize(3);
  return words;
}

// True, false, or nothing if the comment does not say.
std::optional<bool> compensation_of(const std::vector<std::string>& words) {
  constexpr std::array<std::string_view, 4> kOn{"mip", "1", "true", "antialiased"};
  const bool on = std::ranges::find(kOn, words[1]) != kOn.end();
  if (words[0] == "splatrendermode" && !words[1].empty()) return on;
  if (words[0] == "antialiased" && !words[1].empty() && words[2].empty()) return on;
  if (words[0] == "train_flags" && words[1] == "antialiasing") return true;
  return std::nullopt;
}

std::optional<double> dilation_of(const std::vector<std::string>& words) {
  if (words[0] != "screenfilterdilation") return std::nullopt;
  const auto value = number_of(words[1]);
  const bool plausible = value && *value > 0 && *value <= 100;
  return plausible ? value : std::nullopt;
}

}  // namespace

ScreenFilter filter_of_comments(std::span<const std::string> comments) {
  ScreenFilter filter;
  bool brush = false;
  std::optional<double> dilation;
  for (const std::string& comment : comments) {
    const auto words = plain_words(comment);
    brush |= words[0] == "exported" && words[1] == "from" && words[2] == "brush";
    if (const auto compensated = compensation_of(words)) filter.compensated = *compensated;
    if (const auto found = dilation_of(words)) dilation = found;
  }
  if (filter.compensated && brush) filter.dilation = kMipDilation;
  if (dilation) filter.dilation = *dilation;
  return filter;
}

std::vector<std::string> comments_of_filter(const ScreenFilter& filter) {
  std::vector<std::string> comments;
  if (filter.compensated) comments.emplace_back("SplatRenderMode: mip");
  if (filter.dilation != ScreenFilter{}.dilation)
    comments.push_back(fmt::format("ScreenFilterDilation: {}", filter.dilation));
  return comments;
}

std::string comment_lines(const ScreenFilter& filter) {
  std::string lines;
  for (const std::string& comment : comments_of_filter(filter))
    lines += "comment " + comment + '\n';
  return lines;
}

}  // namespace fluxgs::io
