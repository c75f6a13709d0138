#include "trainer/paper/fit_psi.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "trainer/paper/appearance_pass.h"
#include "trainer/paper/latent_adam.h"

namespace fluxgs {
namespace {

constexpr int kShCount = networks::kShColumns;

bool finite_in_rows(const PlanarFloats& planes, int begin, int end, std::size_t i) {
  for (int r = begin; r < end; ++r)
    if (!std::isfinite(planes.row(r)[i])) return false;
  return true;
}

std::vector<std::uint32_t> usable_splats(const PlanarFloats& parameters,
                                         const PlanarFloats& latents, const PlanarFloats& target) {
  std::vector<std::uint32_t> splats;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (finite_in_rows(parameters, row::position, row::position + 3, i) &&
        finite_in_rows(latents, 0, kShCount, i) && finite_in_rows(target, 0, kShCount, i))
      splats.push_back(static_cast<std::uint32_t>(i));
  return splats;
}

/// Moves `count` of the splats, drawn at random, to the front, ascending.
std::span<const std::uint32_t> draw(std::vector<std::uint32_t>& splats, std::size_t count,
                                    Random& random) {
  count = std::min(count, splats.size());
  for (std::size_t i = 0; count < splats.size() && i < count; ++i) {
    const auto rest = static_cast<double>(splats.size() - i);
    std::swap(splats[i], splats[i + static_cast<std::size_t>(uniform(random) * rest)]);
  }
  std::sort(splats.begin(), splats.begin() + static_cast<std::ptrdiff_t>(count));
  return {splats.data(), count};
}

double rms_error(const PlanarFloats& colors, const PlanarFloats& target,
                 const std::vector<std::uint32_t>& splats) {
  double squares = 0;
  for (int k = 0; k < kShCount; ++k)
    for (const std::uint32_t i : splats) {
      const double error = double{colors.row(row::sh_dc + k)[i]} - double{target.row(k)[i]};
      squares += error * error;
    }
  return splats.empty() ? 0 : std::sqrt(squares / (kShCount * static_cast<double>(splats.size())));
}

}  // namespace

PsiFitReport fit_psi(AppearanceModel& model, const PlanarFloats& parameters, PlanarFloats& latents,
                     const PlanarFloats& target, const PsiFitOptions& options,
                     const Threads& threads, Isa isa) {
  PsiFitReport report;
  if (!model.psi) return report;
  std::vector<std::uint32_t> splats = usable_splats(parameters, latents, target);
  const std::vector<std::uint32_t> all = splats;
  const std::size_t size = parameters.size();
  PlanarFloats colors(row::count(1), size), gradient(row::count(1), size);
  PlanarFloats latent_gradient(kShCount, size);
  AdamState latent_state{PlanarFloats(kShCount, size), PlanarFloats(kShCount, size)};
  std::vector<std::uint8_t> visible(latents.stride(), 0);

  AppearanceModel only_psi{.normalisation = model.normalisation, .psi = std::move(model.psi)};
  reset_adam(*only_psi.psi);
  bake(only_psi, parameters, latents, threads, colors, isa);
  report.rms_before = rms_error(colors, target, all);
  AppearancePass pass(threads, isa);
  Random random(options.seed);
  for (int step = 0; step < options.steps && !all.empty(); ++step) {
    const auto batch = draw(splats, options.batch, random);
    pass.shade(only_psi, parameters, latents, batch, colors);
    const float weight = 2 / (static_cast<float>(kShCount) * static_cast<float>(batch.size()));
    for (const std::uint32_t i : batch) visible[i] = 1;
    for (int k = 0; k < kShCount; ++k)
      for (const std::uint32_t i : batch)
        gradient.row(row::sh_dc + k)[i] =
            weight * (colors.row(row::sh_dc + k)[i] - target.row(k)[i]);
    pass.backpropagate(only_psi, gradient, visible, latent_gradient);
    const double fall = std::cos(std::numbers::pi / 2 * step / options.steps);
    const NetworkRates rates{
        .psi = options.rate * fall, .psi_warmup = 0, .psi_decay = 1, .psi_decay_at = {}};
    pass.step(only_psi, rates, options.adam);
    if (options.latent_rate > 0)
      latent_adam_step(latents, latent_state, latent_gradient, visible,
                       {options.latent_rate * fall, options.latent_rate * fall},
                       AdamStep(options.adam, step + 1, adam_kernels(isa)), threads);
    for (const std::uint32_t i : batch) visible[i] = 0;
  }
  bake(only_psi, parameters, latents, threads, colors, isa);
  report.rms_after = rms_error(colors, target, all);
  reset_adam(*only_psi.psi);
  model.psi = std::move(only_psi.psi);
  return report;
}

}  // namespace fluxgs
