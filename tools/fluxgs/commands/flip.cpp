#include "tools/fluxgs/commands/flip.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "fluxgs/io/file.h"
#include "tools/fluxgs/terminal/files.h"
#include "trainer/core/planar_image.h"
#include "trainer/core/process.h"
#include "trainer/data/image_io.h"
#include "trainer/data/photo_memory.h"
#include "trainer/loss/photometric.h"

namespace fluxgs::cli {
namespace {

namespace fs = std::filesystem;

/// The package's command without its start-up, which would want to be on the PATH.
constexpr const char* kScript =
    "import sys; folder = sys.argv.pop(1); folder and sys.path.insert(0, folder); "
    "from flip_evaluator import nbflip; "
    "sys.argv[0] = 'flip'; len(sys.argv) > 1 and nbflip.execute(sys.argv)";

/// Empty in packages: there FLIP is what python3 itself finds.
std::string package_folder() {
  const char* named = std::getenv("FLUXGS_FLIP");
  return named != nullptr && *named != 0 ? named : FLUXGS_FLIP_FOLDER;
}

/// Output of FLIP for these arguments.
Expected<std::string> run_flip(const TempFolder& work, const std::vector<std::string>& arguments) {
  const auto python = find_program("python3");
  if (!python) return fail("", "FLIP", "python3, which runs it, is not installed");
  if (work.path().empty()) return fail("", "FLIP", "no temporary folder can be made");
  std::vector<std::string> all{"-I", "-c", kScript, package_folder()};
  all.insert(all.end(), arguments.begin(), arguments.end());
  const fs::path output = work.path() / "output";
  if (run({*python, all, work.path() / "log", output}) != 0)
    return fail(package_folder(), "",
                "FLIP is not there for this python3, or does not run; install it: "
                "tools/deps/flip in a checkout, else pip install flip-evaluator");
  const auto bytes = read_file(output);
  if (!bytes) return std::unexpected(bytes.error());
  return std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
}

Expected<double> mean_in(const std::string& said) {
  constexpr std::string_view kMark = "Mean: ";
  const std::size_t at = said.find(kMark);
  const double mean = at == std::string::npos
                          ? std::numeric_limits<double>::quiet_NaN()
                          : std::strtod(said.c_str() + at + kMark.size(), nullptr);
  if (!(mean >= 0 && mean <= 1)) return fail(package_folder(), "", "FLIP printed no mean error");
  return mean;
}

}  // namespace

Expected<void> check_flip() {
  const TempFolder work;
  const auto ran = run_flip(work, {});
  if (!ran) return std::unexpected(ran.error());
  return {};
}

Expected<std::vector<double>> flip_errors(const std::vector<View>& views,
                                          const ViewRenderer& render,
                                          const ProgressReport& progress) {
  const TempFolder work;
  const fs::path view_file = work.path() / "view.png", image_file = work.path() / "image.png";
  const Threads one_thread(1);
  PlanarImage photo;
  std::vector<double> errors;
  for (const View& view : views) {
    const auto image = render(view.camera);
    if (!image) return std::unexpected(image.error());
    to_planar(view.rgb, one_thread, photo);
    fill_unused(view.used, *image, photo);
    if (auto written = write_png(view_file, interleaved(photo)); !written)
      return std::unexpected(written.error());
    if (auto written = write_png(image_file, interleaved(*image)); !written)
      return std::unexpected(written.error());
    const auto said =
        run_flip(work, {"--reference", view_file.string(), "--test", image_file.string(),
                        "--verbosity", "1", "--no-error-map", "--no-exposure-map"});
    if (!said) return std::unexpected(said.error());
    const auto mean = mean_in(*said);
    if (!mean) return std::unexpected(mean.error());
    errors.push_back(*mean / used_share(view.used));  // no error where a mask ignores pixels
    let_go(view);
    if (progress) progress(errors.size(), views.size());
  }
  return errors;
}

}  // namespace fluxgs::cli
