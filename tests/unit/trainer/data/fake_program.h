// Programs of others, played by shell scripts.
#pragma once

#include <sstream>

#include "test_files.h"

namespace fluxgs::test {

/// An environment variable for the time of a test.
class ScopedVariable {
 public:
  ScopedVariable(const char* name, const std::string& value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old;
    setenv(name, value.c_str(), 1);
  }
  ScopedVariable(const ScopedVariable&) = delete;
  ScopedVariable& operator=(const ScopedVariable&) = delete;
  ~ScopedVariable() { setenv(name_, old_.c_str(), 1); }

 private:
  const char* name_;
  std::string old_;
};

inline void write_program(const fs::path& file, const std::string& body) {
  write_text(file, "#!/bin/sh\n" + body);
  fs::permissions(file, fs::perms::owner_all);
}

/// A colmap in `folder`/bin. It notes its calls in `folder`/calls, the photos that it extracts
/// features of in /features, the pairs that it compares in /pairs, and its models are those of
/// /models. `first` runs before anything else.
inline void write_fake_colmap(const fs::path& folder, const std::string& first = "",
                              int features = 1000) {
  write_program(folder / "bin" / "colmap", fmt::format(R"sh(here='{}'
if [ "$1" = -h ]; then echo 'COLMAP 3.8 (Commit x without CUDA)'; exit; fi
if [ "$2" = -h ]; then
  echo '  --SiftExtraction.use_gpu arg (=1)'; echo '  --SiftMatching.use_gpu arg (=1)'; exit
fi
echo "$@" >> "$here/calls"
command=$1
while [ $# -gt 1 ]; do
  case "$1" in
    --database_path) database=$2;; --image_list_path) list=$2;; --match_list_path) pairs=$2;;
    --output_path) out=$2;; --image_path) images=$2;;
  esac
  shift
done
{}
case "$command" in
  feature_extractor)
    touch "$database"; n=0
    while read -r name; do
      [ -f "$images/$name" ] || exit 3
      n=$((n + 1)); echo "Processed file [$n/9]"; echo "  Name: $name"; echo "  Features:        {}"
      echo "$name" >> "$here/features"
    done < "$list";;
  matches_importer) cat "$pairs" >> "$here/pairs";;
  mapper)
    echo "Registering image #3 (2)"; [ -d "$here/models" ] || exit 1
    cp -r "$here/models/." "$out/";;
esac
)sh",
                                                       folder.string(), first, features));
}

inline std::vector<std::string> lines_of_file(const fs::path& file) {
  std::vector<std::string> lines;
  std::istringstream text(read_all(file));
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

}  // namespace fluxgs::test
