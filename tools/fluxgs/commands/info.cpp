// fluxgs info: what is in a scene file.
#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>
#include <glm/common.hpp>
#include <nlohmann/json.hpp>

#include "bench/self_test.h"
#include "fluxgs/io/scene.h"
#include "fluxgs/splat_degree.h"
#include "tools/fluxgs/commands/command.h"
#include "tools/fluxgs/commands/inner_box.h"
#include "tools/fluxgs/terminal/json_file.h"

namespace fluxgs::cli {
namespace {

using nlohmann::json;

json box_json(const Box& box) {
  const auto& [low, high] = box;
  return {{"min", {low.x, low.y, low.z}}, {"max", {high.x, high.y, high.z}}};
}

json bounds_of(const SplatCloud& cloud) {
  if (cloud.size() == 0) return nullptr;
  glm::vec3 low = cloud.positions[0], high = low;
  for (const glm::vec3& p : cloud.positions) low = glm::min(low, p), high = glm::max(high, p);
  return box_json({low, high});
}

json most_of(const SplatCloud& cloud) {
  return cloud.size() == 0 ? json(nullptr) : box_json(inner_box(cloud));
}

json initial_view_json(const std::optional<InitialView>& start) {
  if (!start) return nullptr;
  const glm::dvec3 &at = start->position, &up = start->up;
  json view = {
      {"position", {at.x, at.y, at.z}}, {"up", {up.x, up.y, up.z}}, {"fov_y", start->fov_y}};
  if (start->image_width > 0) view["image_size"] = {start->image_width, start->image_height};
  return view;
}

json chunks_json(const SceneFile& scene) {
  json chunks = json::array();
  for (const SceneChunk& chunk : scene.chunks)
    chunks.push_back({{"splats", chunk.splats}, {"end", chunk.end}});
  return chunks;
}

json describe(const SceneFile& scene) {
  const double splats = static_cast<double>(std::max<std::size_t>(scene.cloud.size(), 1));
  return {{"format", scene.format},
          {"splats", scene.cloud.size()},
          {"dropped", scene.dropped},
          {"sh_degree", scene.cloud.sh_degree},
          {"splats_by_degree", count_degrees(scene.cloud)},
          {"bytes", scene.bytes},
          {"bits_per_splat", 8.0 * static_cast<double>(scene.bytes) / splats},
          {"attributes", scene.attribute_bits},
          {"bounds", bounds_of(scene.cloud)},
          {"bounds_98", most_of(scene.cloud)},
          {"antialiased", scene.cloud.filter.compensated},
          {"dilation", scene.cloud.filter.dilation},
          {"warnings", scene.warnings},
          {"start", initial_view_json(scene.start)},
          {"chunks", chunks_json(scene)},
          {"extensions", scene.extensions}};
}

/// "4: 2% of the splats in 7% of the bytes, 12% in 30%, …"
std::string in_chunks(const json& d) {
  std::string text;
  double splats = 0;
  for (const json& chunk : d["chunks"]) {
    splats += chunk["splats"].get<double>();
    text +=
        fmt::format("{}{:.0f}%{} in {:.0f}%{}", text.empty() ? "" : ", ",
                    100 * splats / d["splats"].get<double>(), text.empty() ? " of the splats" : "",
                    100 * chunk["end"].get<double>() / d["bytes"].get<double>(),
                    text.empty() ? " of the bytes" : "");
  }
  return fmt::format("{}: {}", d["chunks"].size(), text);
}

/// Text with the splats of each degree, where they differ.
std::string mixture(const json& splats_by_degree) {
  const auto counts = splats_by_degree.get<DegreeCounts>();
  if (std::ranges::count_if(counts, [](std::size_t n) { return n > 0; }) < 2) return "";
  return fmt::format(" (splats of degree 0, 1, 2, 3: {})", fmt::join(counts, ", "));
}

void print_box(const char* name, const json& box) {
  if (box.is_null()) return;
  const auto corner = [&](const char* which) {
    const auto p = box[which].get<std::array<double, 3>>();
    return fmt::format("{:.4g},{:.4g},{:.4g}", p[0] + 0.0, p[1] + 0.0, p[2] + 0.0);  // -0 is 0
  };
  fmt::print("  {:<12}{} to {}\n", name, corner("min"), corner("max"));
}

void print_info(const std::string& path, const json& d) {
  fmt::print("{}: {}\n", path, d["format"].get<std::string>());
  fmt::print("  splats      {} ({} left out for NaN or infinity)\n", d["splats"].get<std::size_t>(),
             d["dropped"].get<std::size_t>());
  fmt::print("  SH degree   {}{}\n", d["sh_degree"].get<int>(), mixture(d["splats_by_degree"]));
  fmt::print("  filter      blur of {:.3g} px², {}\n", d["dilation"].get<double>(),
             d["antialiased"].get<bool>() ? "opacities compensated (antialiased)" : "classic");
  fmt::print("  size        {} bytes, {:.1f} bits a splat\n", d["bytes"].get<std::size_t>(),
             d["bits_per_splat"].get<double>());
  for (const auto& [name, bits] : d["attributes"].items())
    fmt::print("    {:<10}{:.4g} bits\n", name, bits.get<double>());
  if (!d["chunks"].empty()) fmt::print("  chunks      {}\n", in_chunks(d));
  print_box("bounds", d["bounds"]);
  print_box("98% within", d["bounds_98"]);
  if (!d["start"].is_null())
    fmt::print("  start       at {}, up {}\n", d["start"]["position"].dump(),
               d["start"]["up"].dump());
  if (!d["start"].is_null() && d["start"].contains("image_size"))
    fmt::print("  images      {}x{} pixels, of the training\n",
               d["start"]["image_size"][0].get<int>(), d["start"]["image_size"][1].get<int>());
  if (d.contains("self_test")) fmt::print("  self-test   {}\n", d["self_test"].dump());
  for (const json& w : d["warnings"]) fmt::print("  warning     {}\n", w.get<std::string>());
  for (const json& e : d["extensions"]) fmt::print("  extension   {}\n", e.get<std::string>());
}

struct InfoSettings {
  std::string scene;
  bool self_test = false, as_json = false;
};

Expected<void> info(const InfoSettings& s) {
  const auto scene = read_scene_or_checkpoint(s.scene);
  if (!scene) return std::unexpected(scene.error());
  json facts = describe(*scene);
  if (s.self_test)
    facts["self_test"] =
        json::parse(to_json(bench::self_test(render::cloud_to_draw(SplatCloud(scene->cloud)))));
  if (s.as_json)
    print_json(facts);
  else
    print_info(s.scene, facts);
  return {};
}

}  // namespace

void add_info(CLI::App& app, Action& action) {
  auto settings = std::make_shared<InfoSettings>();
  CLI::App* command = app.add_subcommand("info", "Describe a scene file");
  command->footer("Example: fluxgs info garden.glb --json");
  command->add_option("scene", settings->scene, "the scene file")->required();
  command->add_flag("--self-test", settings->self_test,
                    "hash this machine's results, to compare with the app's benchmark");
  command->add_flag("--json", settings->as_json, "print one JSON object");
  command->callback([=, &action] { action = [=] { return info(*settings); }; });
}

}  // namespace fluxgs::cli
