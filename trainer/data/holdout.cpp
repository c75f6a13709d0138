#include "trainer/data/holdout.h"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "trainer/data/file_bytes.h"
#include "trainer/data/file_list.h"
#include "trainer/data/name_key.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int kTestEvery = 8;
constexpr std::uint64_t kLargestList = 1 << 26;  // bytes

std::string normalized(const std::string& name) {
  std::string key = name_key(name);
  return key.starts_with("./") ? key.substr(2) : key;
}

std::string stem_of(const std::string& name) { return fs::path(name).stem().string(); }

bool ends_with_path(const std::string& path, const std::string& tail) {
  return path == tail || path.ends_with("/" + tail);
}

/// True for two normalized names of one image, one of which may lack folders or the extension.
bool same_image(const std::string& a, const std::string& b) {
  if (ends_with_path(a, b) || ends_with_path(b, a)) return true;
  const auto bare = [](const std::string& name) {
    return fs::path(name).replace_extension().generic_string();
  };
  return ends_with_path(bare(a), bare(b)) || ends_with_path(bare(b), bare(a)) ||
         ends_with_path(bare(a), b) || ends_with_path(bare(b), a);
}

/// Finds listed names among those of images.
class NameSet {
 public:
  explicit NameSet(const std::vector<std::string>& names) {
    for (const std::string& name : names) {
      const std::string n = normalized(name);
      for (const std::string& stem : {stem_of(n), fs::path(n).filename().string()})
        by_stem_[stem].insert(n);
    }
  }
  bool holds(const std::string& name) const {
    const std::string n = normalized(name);
    const auto found = by_stem_.find(stem_of(n));
    return found != by_stem_.end() &&
           std::ranges::any_of(found->second, [&](const auto& m) { return same_image(m, n); });
  }

 private:
  std::map<std::string, std::set<std::string>> by_stem_;
};

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    const auto space = [](unsigned char c) { return std::isspace(c) != 0; };
    line.erase(line.begin(), std::ranges::find_if_not(line, space));
    while (!line.empty() && space(static_cast<unsigned char>(line.back()))) line.pop_back();
    if (!line.empty() && line.front() != '#') lines.push_back(line);
  }
  return lines;
}

/// Appends the names of a list; numbers count the frames sorted by name.
void add_names(const Json& json, const char* key, const std::vector<SourceFrame>& frames,
               std::vector<std::string>& names) {
  const auto list = json.find(key);
  if (list == json.end() || !list->is_array()) return;
  for (const Json& entry : *list) {
    if (entry.is_string()) names.push_back(entry.get<std::string>());
    const bool number = entry.is_number_unsigned();
    if (number && entry.get<std::uint64_t>() < frames.size())
      names.push_back(frames[entry.get<std::size_t>()].name);
  }
}

/// A file of names: {"train": [...], "test": [...], "val": [...]}, a JSON list, or lines.
Expected<SplitLists> read_lists(const fs::path& file, const std::vector<SourceFrame>& frames) {
  const auto text = read_text(file, kLargestList);
  if (!text) return std::unexpected(text.error());
  SplitLists lists{.train = {}, .test = {}, .file = file.string()};
  if (file.extension() != ".json") {
    lists.test = lines_of(*text);
    return lists;
  }
  const Json json = Json::parse(*text, nullptr, false);
  if (json.is_array()) {
    add_names({{"test", json}}, "test", frames, lists.test);
  } else if (json.is_object()) {
    add_names(json, "train", frames, lists.train);
    for (const char* key : {"test", "val"}) add_names(json, key, frames, lists.test);
  } else {
    return fail(file.string(), "", "not valid JSON, expected {\"train\": [...], \"test\": [...]}");
  }
  return lists;
}

/// The lists that lie in the folder of a data set, if any.
Expected<SplitLists> find_lists(const fs::path& folder, const std::vector<SourceFrame>& frames) {
  for (const char* name : {"train_test_split.json", "train_test_lists.json"})
    if (is_file(folder / name)) return read_lists(folder / name, frames);
  for (const auto& [train, test] :
       {std::pair("train.txt", "test.txt"), std::pair("train_list.txt", "test_list.txt"),
        std::pair("", "sparse/0/test.txt")}) {
    SplitLists lists;
    if (is_file(folder / test)) {
      auto read = read_lists(folder / test, frames);
      if (!read) return read;
      lists = std::move(*read);
    }
    if (is_file(folder / train)) {
      auto read = read_lists(folder / train, frames);
      if (!read) return read;
      lists.train = std::move(read->test);
      if (lists.file.empty()) lists.file = read->file;
    }
    if (!lists.train.empty() || !lists.test.empty()) return lists;
  }
  return SplitLists();
}

void move_to_test(Source& source, const auto& is_test) {
  std::vector<SourceFrame> train;
  for (SourceFrame& frame : source.frames)
    (is_test(frame) ? source.test_frames : train).push_back(std::move(frame));
  source.frames = std::move(train);
}

void hold_out_every(Source& source, int n) {
  if (n == 0 || source.frames.size() < 2) return;
  int index = 0;
  move_to_test(source, [&](const SourceFrame&) { return index++ % n == 0; });
}

/// Names of a list that no image has.
FileList names_without_image(const std::vector<std::string>& names,
                             const std::vector<SourceFrame>& frames) {
  std::vector<std::string> images;
  for (const SourceFrame& frame : frames) images.push_back(frame.name);
  const NameSet there(images);
  FileList missing;
  for (const std::string& name : names)
    if (!there.holds(name)) missing.add(name);
  return missing;
}

/// False, and nothing done, where the lists name no image.
bool hold_out_listed(Source& source, const SplitLists& lists) {
  const NameSet train(lists.train), test(lists.test);
  const auto is_test = [&](const SourceFrame& frame) {
    return lists.test.empty() ? !train.holds(frame.name) : test.holds(frame.name);
  };
  const auto listed = [&](const SourceFrame& frame) {
    return test.holds(frame.name) || train.holds(frame.name);
  };
  if (std::ranges::none_of(source.frames, listed)) return false;
  const FileList missing = names_without_image(lists.test, source.frames);
  if (!missing.empty())
    source.warnings.push_back(fmt::format("{}: {} of {} images for testing are not there: {}",
                                          lists.file, missing.size(), lists.test.size(),
                                          missing.text()));
  if (!lists.train.empty() && !lists.test.empty()) {
    FileList neither;
    std::erase_if(source.frames, [&](const SourceFrame& frame) {
      if (!listed(frame)) neither.add(frame.name);
      return !listed(frame);
    });
    source.skipped_images += neither.size();
    if (!neither.empty())
      source.warnings.push_back(
          fmt::format("{}: in neither list, left out: {}", lists.file, neither.text()));
  }
  move_to_test(source, is_test);
  return true;
}

Expected<void> hold_out_as_the_data_set_says(Source& source, const fs::path& folder) {
  auto lists = source.split.file.empty() ? find_lists(folder, source.frames)
                                         : Expected<SplitLists>(std::move(source.split));
  if (!lists) return std::unexpected(lists.error());
  if (!lists->file.empty()) {
    if (hold_out_listed(source, *lists)) return {};
    source.warnings.push_back(
        fmt::format("{}: names none of the images; every {}th is kept for testing instead",
                    lists->file, kTestEvery));
  }
  hold_out_every(source, kTestEvery);
  return {};
}

void sort_by_name(std::vector<SourceFrame>& frames) {
  std::ranges::sort(frames, [](const SourceFrame& a, const SourceFrame& b) {
    return std::tie(a.name, a.file) < std::tie(b.name, b.file);
  });
}

}  // namespace

Expected<void> hold_out(Source& source, const fs::path& folder, const LoadOptions& options) {
  const bool asked = options.test_every.has_value() || !options.test_list.empty();
  if (asked)
    std::ranges::move(std::exchange(source.test_frames, {}), std::back_inserter(source.frames));
  sort_by_name(source.frames);
  sort_by_name(source.test_frames);
  if (!options.test_list.empty()) {
    const auto lists = read_lists(options.test_list, source.frames);
    if (!lists) return std::unexpected(lists.error());
    if (!hold_out_listed(source, {.train = {}, .test = lists->test, .file = lists->file}))
      return fail(options.test_list.string(), "", "names none of the images");
  } else if (options.test_every) {
    hold_out_every(source, *options.test_every);
  } else if (!source.has_split) {
    return hold_out_as_the_data_set_says(source, folder);
  }
  return {};
}

}  // namespace fluxgs
