#include "bench/compiled_in.hpp"

#include "somas/sdk/plugin.hpp"

#include "plugins/controllers/grn/grn.hpp"
#include "plugins/environments/nutrients/nutrients.hpp"
#include "plugins/environments/particle_aggression/particle_aggression.hpp"
#include "plugins/fitness/survival_time/survival_time.hpp"
#include "plugins/specialization/tree/tree.hpp"

SOMAS_PLUGIN("somas.bench.compiled_in", "0.1.0", somas::environments::Nutrients,
             somas::environments::ParticleAggression, somas::specialization::Tree, somas::grn::Grn,
             somas::fitness::SurvivalTime)

namespace somas::bench {

const std::shared_ptr<const plugins::Library>& compiled_in() {
  static const std::shared_ptr<const plugins::Library> library =
      plugins::Library::linked_in(somas_plugin());
  return library;
}

}  // namespace somas::bench
