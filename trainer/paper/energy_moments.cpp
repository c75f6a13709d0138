#include "trainer/paper/energy_moments.h"

#include "fluxgs/math/spherical_harmonics.h"

namespace fluxgs {
namespace {

constexpr std::size_t kMomentPiece = 1024;  // splats per piece of parallel work

std::vector<EnergySample> samples_of(const SphereRule& rule) {
  std::vector<EnergySample> samples(rule.directions.size());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const glm::dvec3& d = rule.directions[k];
    double basis[15];
    math::sh_basis(3, math::Vec3<double>{d.x, d.y, d.z}, basis);
    for (int j = 0; j < 15; ++j) samples[k].basis[j] = static_cast<float>(basis[j]);
    const double moments[4] = {1, d.x, d.y, d.z};
    for (int m = 0; m < 4; ++m)
      samples[k].moments[m] = static_cast<float>(rule.weights[k] * moments[m]);
  }
  return samples;
}

int degree_left_out(Residual residual) {
  if (residual == Residual::from_0) return 0;
  return residual == Residual::from_1 ? 1 : 2;
}

}  // namespace

PlanarFloats energy_moments(const PlanarFloats& parameters, Residual residual,
                            const SphereRule& rule, const Threads& threads,
                            const EnergyKernels& kernels) {
  const std::vector<EnergySample> samples = samples_of(rule);
  PlanarFloats result(12, parameters.size());
  for (int channel = 0; channel < 3; ++channel) {
    EnergyArgs args{.coefficients = {},
                    .first = sh_rest_count(degree_left_out(residual)),
                    .end = sh_rest_count(sh_degree_of(parameters)),
                    .samples = samples.data(),
                    .sample_count = samples.size(),
                    .moments = {}};
    for (int k = args.first; k < args.end; ++k)
      args.coefficients[k] = parameters.row(row::sh_rest + 3 * k + channel);
    for (int m = 0; m < 4; ++m) args.moments[m] = result.row(3 * m + channel);
    threads.for_pieces(parameters.size(), kMomentPiece, [&](std::size_t begin, std::size_t end) {
      kernels.energy(args, begin, end);
    });
  }
  return result;
}

void add_projection(const PlanarFloats& energy, PlanarFloats& parameters) {
  constexpr double k4Pi = 4 * std::numbers::pi;
  const auto y0 = static_cast<float>(k4Pi * math::kSh0), y1 = static_cast<float>(k4Pi * math::kSh1);
  constexpr int kAxis[] = {1, 2, 0};  // y, z, x
  constexpr float kSign[] = {-1, 1, -1};
  for (int c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      parameters.row(row::sh_dc + c)[i] += y0 * energy.row(c)[i];
      for (int k = 0; k < 3; ++k)
        parameters.row(row::sh_rest + 3 * k + c)[i] +=
            kSign[k] * y1 * energy.row(3 + 3 * kAxis[k] + c)[i];
    }
}

}  // namespace fluxgs
