#include "core/damping_laws.hpp"

namespace tissued::core {

namespace {

// Remembers F - 1.
class RestDamping : public FemLaw {
 public:
  explicit RestDamping(double strength) : strength_(strength) {}
  std::string_view name() const override { return "damping"; }
  int history_per_point() const override { return 9; }

  void accept(const PointBatch&, const PointDeformation& deformation, double* history) const override {
    for (int k = 0; k < 9; ++k)
      for (int l = 0; l < kPointLanes; ++l)
        history[k * kPointLanes + l] = deformation.f[k][l] - (k % 4 == 0 ? 1.0 : 0.0);
  }

 protected:
  // beta times a modulus over dt; 0 where no time passes.
  double rate(const PointBatch& batch) const { return batch.time_step > 0.0 ? strength_ / batch.time_step : 0.0; }
  static double change(const PointBatch& batch, const PointDeformation& deformation, int k, int l) {
    return deformation.f[k][l] - (k % 4 == 0 ? 1.0 : 0.0) - batch.history[k * kPointLanes + l];
  }

 private:
  double strength_;  // kPa s
};

class ShapeDamping final : public RestDamping {
 public:
  using RestDamping::RestDamping;
  void add(const PointBatch& batch, const PointDeformation& f, bool, PointResponse& response) const override {
    const double mu = rate(batch);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int l = 0; l < kPointLanes; ++l)
          response.stress[3 * i + j][l] += mu * (change(batch, f, 3 * i + j, l) + change(batch, f, 3 * j + i, l));
    for (int l = 0; l < kPointLanes; ++l) {
      const double trace = change(batch, f, 0, l) + change(batch, f, 4, l) + change(batch, f, 8, l);
      for (int k = 0; k < 9; k += 4) response.stress[k][l] -= 2.0 / 3.0 * mu * trace;
    }
  }
};

class VolumeDamping final : public RestDamping {
 public:
  using RestDamping::RestDamping;
  bool on_volume() const override { return true; }
  void add(const PointBatch& batch, const PointDeformation& f, bool, PointResponse& response) const override {
    const double kappa = rate(batch);
    for (int l = 0; l < kPointLanes; ++l) {
      const double trace = change(batch, f, 0, l) + change(batch, f, 4, l) + change(batch, f, 8, l);
      for (int k = 0; k < 9; k += 4) response.stress[k][l] += kappa * trace;
    }
  }
};

}  // namespace

void add_damping_laws(const Material& material, double beta, std::vector<std::unique_ptr<FemLaw>>& laws) {
  laws.push_back(std::make_unique<ShapeDamping>(beta * material.shear_modulus()));
  laws.push_back(std::make_unique<VolumeDamping>(beta * material.bulk_modulus()));
}

}  // namespace tissued::core
