#include "io/ply/ply_view.h"

#include <cmath>
#include <initializer_list>
#include <limits>
#include <string_view>
#include <type_traits>

#include <fmt/format.h>

#include "io/ply/ply_header.h"

namespace fluxgs::io {
namespace {

constexpr std::string_view kKeyword = "StartView:";

template <class Number>
bool fits(double value) {
  if constexpr (std::is_floating_point_v<Number>) return true;
  const auto least = static_cast<double>(std::numeric_limits<Number>::min());
  const auto most = static_cast<double>(std::numeric_limits<Number>::max());
  return value >= least && value <= most && value == std::floor(value);
}

/// Reads words one after the other; false from the first that is not as expected.
class Words {
 public:
  explicit Words(std::span<const std::string_view> words) : words_(words) {}

  bool done() const { return words_.empty(); }
  bool take(std::string_view expected) {
    if (words_.empty() || words_[0] != expected) return false;
    words_ = words_.subspan(1);
    return true;
  }
  template <class Number>
  bool take(std::initializer_list<Number*> numbers) {
    for (Number* number : numbers) {
      if (words_.empty()) return false;
      const auto read = number_of(words_[0]);
      if (!read || !fits<Number>(*read)) return false;
      *number = static_cast<Number>(*read);
      words_ = words_.subspan(1);
    }
    return true;
  }

 private:
  std::span<const std::string_view> words_;
};

std::optional<InitialView> view_of(std::string_view comment) {
  const auto all = words_of(comment);
  Words words(all);
  InitialView v;
  glm::dvec3 &p = v.position, &up = v.up;
  glm::dquat& q = v.orientation;
  const bool whole =
      words.take(kKeyword) && words.take("position") && words.take({&p.x, &p.y, &p.z}) &&
      words.take("orientation") && words.take({&q.w, &q.x, &q.y, &q.z}) && words.take("fov_y") &&
      words.take({&v.fov_y}) && words.take("up") && words.take({&up.x, &up.y, &up.z});
  if (!whole) return std::nullopt;
  if (words.take("image_size") && !words.take({&v.image_width, &v.image_height}))
    return std::nullopt;
  return words.done() && is_sound(v) ? std::optional(v) : std::nullopt;
}

}  // namespace

std::optional<InitialView> view_of_comments(std::span<const std::string> comments) {
  std::optional<InitialView> view;
  for (const std::string& comment : comments)
    if (const auto found = view_of(comment)) view = found;
  return view;
}

std::string comment_line(const std::optional<InitialView>& view) {
  if (!view || !is_sound(*view)) return "";
  const InitialView& v = *view;
  const glm::dquat& q = v.orientation;
  std::string line =
      fmt::format("comment {} position {} {} {} orientation {} {} {} {} fov_y {} up {} {} {}",
                  kKeyword, v.position.x, v.position.y, v.position.z, q.w, q.x, q.y, q.z, v.fov_y,
                  v.up.x, v.up.y, v.up.z);
  if (v.image_width > 0) line += fmt::format(" image_size {} {}", v.image_width, v.image_height);
  return line + '\n';
}

}  // namespace fluxgs::io
