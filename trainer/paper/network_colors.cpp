#include "trainer/paper/network_colors.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "trainer/data/dataset.h"
#include "trainer/paper/fit_psi.h"
#include "trainer/paper/latent_adam.h"
#include "trainer/raster/rasterizer.h"

namespace fluxgs {
namespace {

class EnergyMoments final : public Phase {
 public:
  EnergyMoments(const NetworkColorOptions& options, int iteration, SharedEnergy energy)
      : residual_(options.residual), iteration_(iteration), energy_(std::move(energy)) {}

  const char* name() const override { return "energy moments"; }
  Period period() const override {
    return {.from = iteration_, .until = iteration_, .interval = 0};
  }
  std::string effect() const override {
    return fmt::format("takes the energy moments of the residual {}",
                       kResidualNames[static_cast<std::size_t>(residual_)]);
  }
  std::optional<PhaseReport> after_step(Training& t) override {
    if (period().due(t.state.iteration))
      *energy_ =
          energy_moments(t.state.parameters, residual_, sphere_rule_of(t.options), t.threads);
    return {};
  }

 private:
  Residual residual_;
  int iteration_;
  SharedEnergy energy_;
};

/// Rows sh_dc and sh_rest of degree 1.
PlanarFloats first_order(const PlanarFloats& parameters) {
  PlanarFloats rows(networks::kShColumns, parameters.size());
  for (int r = 0; r < rows.rows(); ++r)
    std::copy_n(parameters.row(row::sh_dc + r), parameters.size(), rows.row(r));
  return rows;
}

}  // namespace

OptionFields NetworkColorOptions::fields(const TrainOptions& all) {
  const bool energy =
      reduces_sh(all) && all.get<ShReductionOptions>().reduce == ShReduction::energy;
  const char* moments = "--sh-target 1 --sh-reduce energy";
  const char* network = "--sh-target 1 --sh-reduce energy --psi on";
  return {choice("residual", "bands that the energy moments are taken of", residual, kResidualNames)
              .only_if(energy, moments),
          flag("psi", "a network turns energy moments into colours", psi).only_if(energy, moments),
          flag("phi", "a network adds offsets to the colours", phi),
          whole("psi-fit-iterations", "iterations in which psi first learns known colours",
                psi_fit_iterations, 0, 1e6)
              .only_if(energy && psi, network),
          real("psi-lr", "learning rate of psi", psi_lr, 0, 1).only_if(energy && psi, network),
          real("phi-lr", "learning rate of phi", phi_lr, 0, 1).only_if(phi, "--phi on")};
}

Expected<void> NetworkColorOptions::validate(const TrainOptions& all) const {
  const bool first_order_target =
      all.get<ShReductionOptions>().target == ShTarget::degree_1 && all.sh_degree >= 1;
  if (!phi || first_order_target) return {};
  return fail("", "--phi",
              fmt::format("makes colours of degree 1 only, {}",
                          all.sh_degree >= 1 ? "expected --sh-target 1"
                                             : "expected a --sh-degree of 1 or more"));
}

bool makes_psi(const TrainOptions& options) {
  return reduces_sh(options) && options.get<ShReductionOptions>().reduce == ShReduction::energy &&
         options.get<NetworkColorOptions>().psi;
}

bool makes_phi(const TrainOptions& options) { return options.get<NetworkColorOptions>().phi; }

NetworkColors::NetworkColors(const TrainOptions& options, int iteration, SharedEnergy energy,
                             const Threads& threads)
    : options_(options.get<NetworkColorOptions>()),
      psi_(makes_psi(options)),
      phi_(makes_phi(options)),
      iteration_(iteration),
      iterations_(options.iterations),
      seed_(options.seed),
      energy_(std::move(energy)),
      threads_(threads),
      pass_(threads) {}

Period NetworkColors::period() const {
  if (!psi_ && !phi_) return {.from = iteration_, .until = iteration_, .interval = 0};
  return {.from = iteration_, .until = iterations_};
}

std::string NetworkColors::effect() const {
  if (!psi_ && !phi_) return "adds the projection of the energy to the SH coefficients";
  return fmt::format("makes colours by the networks {}{}{}", psi_ ? "psi" : "",
                     psi_ && phi_ ? " and " : "", phi_ ? "phi" : "");
}

/// Lets the networks make the colours of the splats that a camera can see, from their true
/// opacities.
void NetworkColors::before_render(Training& t) {
  if (!model_) return;
  PlanarFloats& parameters = t.state.parameters;
  std::vector<std::uint32_t> seen;
  const std::vector<std::uint8_t>& visible =
      t.rasterizer.find_visible(parameters, t.view->camera, t.render);
  for (std::uint32_t i = 0; i < parameters.size(); ++i)
    if (visible[i]) seen.push_back(i);
  t.exchange_opacities();
  pass_.shade(*model_, parameters, t.state.attached.at(kLatents).values, seen, parameters);
  t.exchange_opacities();
  t.optimized_rows = row::sh_dc;
}

/// Iterations that the latents' moments know of: E comes to be at the SH reduction, c′ was trained
/// before.
int NetworkColors::latent_iterations(int iteration) const {
  return model_->psi ? iteration - iteration_ : iteration;
}

void NetworkColors::after_backward(Training& t) {
  if (!model_) return;
  PlanarFloats& latents = t.state.attached.at(kLatents).values;
  if (latent_gradient_.size() != latents.size())
    latent_gradient_ = PlanarFloats(latents.rows(), latents.size());
  const AdamConstants constants{t.options.beta1, t.options.beta2, t.options.epsilon};
  const std::vector<std::uint8_t>& visible = t.rasterizer.visible();
  pass_.backpropagate(*model_, t.rasterizer.gradient(), visible, latent_gradient_);
  pass_.step(*model_, {.psi = options_.psi_lr, .phi = options_.phi_lr}, constants);
  AdamState moments{std::move(t.state.attached.at(kLatentMoments[0]).values),
                    std::move(t.state.attached.at(kLatentMoments[1]).values)};
  latent_adam_step(
      latents, moments, latent_gradient_, visible,
      {.constant = t.options.sh_dc_lr, .directional = t.options.sh_rest_lr},
      AdamStep(constants, latent_iterations(t.state.iteration), adam_kernels(best_isa())),
      threads_);
  t.state.attached.at(kLatentMoments[0]).values = std::move(moments.first);
  t.state.attached.at(kLatentMoments[1]).values = std::move(moments.second);
}

/// Replaces the SH coefficients of degree 1, which the parameters have by now, by what networks
/// make of latents: the energy, or without Ψ the coefficients themselves.
std::optional<PhaseReport> NetworkColors::after_step(Training& t) {
  TrainState& state = t.state;
  if (state.iteration != iteration_) return {};
  PlanarFloats energy = std::exchange(*energy_, {});
  if (energy.rows() > 0 && !psi_) add_projection(energy, state.parameters);
  if (!psi_ && !phi_) return PhaseReport();
  model_ = make_appearance_model(psi_, phi_, measure_normalisation(state.parameters), seed_);
  const PlanarFloats target = first_order(state.parameters);
  PlanarFloats latents = psi_ ? std::move(energy) : PlanarFloats(target);
  // Without Ψ, the optimiser goes on with the coefficients it knows
  const auto moments = [&](const PlanarFloats& known) -> SplatValues {
    return {psi_ ? PlanarFloats(target.rows(), target.size()) : first_order(known), true};
  };
  state.attached[kLatentMoments[0]] = moments(state.adam.first);
  state.attached[kLatentMoments[1]] = moments(state.adam.second);
  PhaseReport report;
  if (psi_ && options_.psi_fit_iterations > 0) {
    const PsiFitReport fit = fit_psi(
        *model_, state.parameters, latents, target,
        {.steps = options_.psi_fit_iterations, .rate = options_.psi_lr, .seed = seed_}, t.threads);
    report.details = {{"psi_fit_rms", {fit.rms_before, fit.rms_after}}};
    report.summary = fmt::format("psi learned known colours: error {:.4f} to {:.4f}",
                                 fit.rms_before, fit.rms_after);
  }
  state.attached[kLatents] = {std::move(latents)};
  return report;
}

void NetworkColors::bake_colors(const TrainState& state, PlanarFloats& parameters) const {
  if (model_)
    bake(*model_, state.parameters, state.attached.at(kLatents).values, threads_, parameters);
}

std::vector<double> NetworkColors::save() const {
  if (!model_) return {};
  const std::vector<float> floats = to_floats(*model_);
  return {floats.begin(), floats.end()};
}

Expected<void> NetworkColors::load(const std::vector<double>& values, const TrainState& state) {
  model_.reset();
  const auto is_attached = [&](const char* key) {
    const auto found = state.attached.find(key);
    return found != state.attached.end() && found->second.values.rows() == networks::kShColumns;
  };
  const bool attached =
      is_attached(kLatents) && is_attached(kLatentMoments[0]) && is_attached(kLatentMoments[1]);
  const bool due = (psi_ || phi_) && state.iteration >= iteration_;
  if (!due && values.empty() && !state.attached.contains(kLatents)) return {};
  if (!due || !attached || sh_degree_of(state.parameters) != 1)
    return fail("", name(), "the networks are not those of the options");
  const std::vector<float> floats(values.begin(), values.end());
  auto model = model_from_floats(psi_, phi_, floats);
  if (!model) return std::unexpected(model.error());
  model_ = std::move(*model);
  return {};
}

NetworkColorPhases make_network_colors(TrainOptions& options, const Threads& threads) {
  const bool energy =
      reduces_sh(options) && options.get<ShReductionOptions>().reduce == ShReduction::energy;
  if (!energy && !makes_phi(options)) return {};
  const int iteration = sh_reduce_iteration(options);
  const auto shared = std::make_shared<PlanarFloats>();
  NetworkColorPhases phases;
  if (energy)
    phases.energy =
        std::make_unique<EnergyMoments>(options.get<NetworkColorOptions>(), iteration, shared);
  phases.colors = std::make_unique<NetworkColors>(options, iteration, shared, threads);
  return phases;
}

}  // namespace fluxgs
