#include "somas/sdk/plugin.hpp"

#include "plugins/environments/particle_aggression/particle_aggression.hpp"

SOMAS_PLUGIN("somas.particle_aggression", "0.1.0", somas::environments::ParticleAggression)
